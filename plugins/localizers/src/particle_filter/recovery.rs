//! Recovery of a robot that was carried away: how many particles to scatter anew.
//!
//! Augmented MCL, Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), table 8.3: when readings fit worse lately than
//! in the long run, some particles are drawn from the whole map. Differs from the book: the fit is the geometric mean
//! per beam, since the product of all beams underflows and jumps by orders of magnitude.

/// Long and short averages of the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recovery {
    alpha_slow: f64,
    alpha_fast: f64,
    averages: Option<[f64; 2]>,
}

impl Recovery {
    /// Averages that follow by these shares; both 0 turn the recovery off.
    pub fn new(alpha_slow: f64, alpha_fast: f64) -> Recovery {
        Recovery { alpha_slow, alpha_fast, averages: None }
    }

    /// Forgets the averages.
    pub fn reset(&mut self) {
        self.averages = None;
    }

    /// Takes in the mean over the particles of the fit per beam; what is not a number is passed over.
    pub fn observe(&mut self, fit: f64) {
        if !fit.is_finite() {
            return;
        }
        let [slow, fast] = self.averages.unwrap_or([fit; 2]);
        self.averages = Some([slow + self.alpha_slow * (fit - slow), fast + self.alpha_fast * (fit - fast)]);
    }

    /// The slow and the fast average; none before the first fit.
    pub fn averages(&self) -> Option<[f64; 2]> {
        self.averages
    }

    /// Share of particles to draw from the whole map.
    pub fn random_share(&self) -> f64 {
        match self.averages {
            Some([slow, fast]) if slow > 0.0 => (1.0 - fast / slow).max(0.0),
            _ => 0.0,
        }
    }
}
