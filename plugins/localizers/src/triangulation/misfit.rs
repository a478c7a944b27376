//! Landmarks that fit worse, all together, than usual: the factor by which their covariances are too small then.

/// How badly landmarks fit, over the last scans.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Misfit {
    /// Mean of squared deviations, two numbers each.
    squared_deviation: f64,
}

/// What fitting landmarks have. Below 2, as much of what their covariances contain (of a corner between two readings, of a
/// wall that is not quite straight) stays from scan to scan: there it is an offset that the filter follows.
const FITTING: f64 = 0.5;
/// Share of a scan in the mean.
const NEW: f64 = 0.05;
/// Landmarks that fit still worse are those of another place.
const MOST: f64 = 20.0;

impl Default for Misfit {
    fn default() -> Self {
        Misfit { squared_deviation: FITTING }
    }
}

impl Misfit {
    /// Takes in a scan's mean of squared deviations.
    pub fn note(&mut self, squared_deviation: f64) {
        self.squared_deviation += NEW * (squared_deviation - self.squared_deviation);
    }

    /// Covariances are too small by this factor; never less than one.
    pub fn factor(&self) -> f64 {
        (self.squared_deviation / FITTING).clamp(1.0, MOST)
    }
}
