//! How well the scans fit a place, beam by beam: what keeps a place that only has the right landmarks from being believed.

use super::sighting::Beam;
use super::traced_beams::Comparison;

/// Counts of beams.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Fit {
    /// Beams that say something.
    pub n_beams: usize,
    /// Of these, beams of which the map says something as well.
    pub n_judged: usize,
    /// Of these, beams that end where the map has a surface.
    pub n_explained: usize,
    /// Beams that pass through what the map shows: people and boxes explain beams that end too early, but nothing this.
    pub n_through: usize,
}

/// What a place must reach to be believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitLimits {
    /// Least share of judged beams that are explained.
    pub explained: f64,
    /// With a smaller share a place is believed only when it fits from elsewhere, too.
    pub sure: f64,
    /// So it is when fewer landmarks name it.
    pub sure_matches: usize,
    /// Largest share of judged beams that pass through something.
    pub through: f64,
    /// Least share of all beams that can be judged.
    pub judged: f64,
    /// Two places fit alike when their shares of explained beams differ by no more than this.
    pub alike: f64,
}

/// With fewer beams nothing is said of a place.
const LEAST_JUDGED: usize = 20;
/// A beam is explained when it ends this near to its surface (across it), meters.
const NEAR_M: f64 = 0.08;
/// Where a larger share of the beams passes through what the map shows, the robot surely is not.
const CONTRADICTED: f64 = 0.15;
/// It passes through when it ends farther than this behind, meters.
const BEHIND_M: f64 = 0.30;

impl Fit {
    /// Judges all beams.
    pub fn of(comparisons: &[Comparison]) -> Fit {
        let mut fit = Fit::default();
        comparisons.iter().for_each(|comparison| fit.add(comparison));
        fit
    }

    fn add(&mut self, comparison: &Comparison) {
        let Comparison { beam, expected_m, farthest_m, direction: [x, y], normal, .. } = *comparison;
        match beam {
            Beam::Silent => return,
            // That nothing is seen where nothing is expected says little: a device that sees nothing at all fits there.
            Beam::Free if expected_m.is_infinite() => return,
            Beam::Hit(_) | Beam::Free => self.n_beams += 1,
        }
        if expected_m.is_nan() {
            return;
        }
        self.n_judged += 1;
        let Beam::Hit(range_m) = beam else {
            self.n_through += usize::from(farthest_m.is_finite());
            return;
        };
        let off_m = range_m - expected_m;
        let across_m = normal.map_or(off_m, |[nx, ny]| off_m * (nx * x + ny * y));
        if across_m.abs() <= NEAR_M {
            self.n_explained += 1;
        } else if range_m - farthest_m > BEHIND_M {
            self.n_through += 1;
        }
    }

    /// Share of judged beams that are explained.
    pub fn explained(&self) -> f64 {
        self.n_explained as f64 / self.n_judged.max(1) as f64
    }

    fn through(&self) -> f64 {
        self.n_through as f64 / self.n_judged.max(1) as f64
    }

    /// The place may be believed.
    pub fn is_within(&self, limits: &FitLimits) -> bool {
        self.n_judged >= LEAST_JUDGED
            && self.n_judged as f64 >= limits.judged * self.n_beams as f64
            && self.explained() >= limits.explained
            && self.through() <= limits.through
    }

    /// The robot surely is not there.
    pub fn is_contradicted(&self, limits: &FitLimits) -> bool {
        self.n_judged < LEAST_JUDGED || self.through() > limits.through.max(CONTRADICTED)
    }
}
