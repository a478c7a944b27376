//! How much one beam says, in log-odds.

/// What a passing and an ending beam add to a cell, and where certainty ends: `ln(p / (1 - p))` of four probabilities.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Evidence {
    /// Added to a cell that a beam passes; below zero.
    pub free: f32,
    /// Added to a cell that a beam ends in; above zero.
    pub occupied: f32,
    /// No cell is surer to be free than this.
    pub least: f32,
    /// No cell is surer to be occupied than this.
    pub most: f32,
}

/// A probability that makes no evidence.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} is {found}, expected {expected}")]
pub struct EvidenceFault {
    /// Which one.
    pub name: &'static str,
    /// Its value.
    pub found: f64,
    /// Between which numbers it lies.
    pub expected: &'static str,
}

fn log_odds(probability: f64) -> f32 {
    (probability / (1.0 - probability)).ln() as f32
}

impl Evidence {
    /// Evidence from the probability that a passed cell, and one with an end in it, is occupied, and from the bounds
    /// of certainty. Clamping on both sides keeps a cell that was free for long able to become occupied, and the
    /// reverse.
    ///
    /// # Errors
    /// All probabilities that make no sense: passing must say "free" and ending must say "occupied".
    pub fn new(
        update_factor_free: f64,
        update_factor_occupied: f64,
        p_min: f64,
        p_max: f64,
    ) -> Result<Evidence, Vec<EvidenceFault>> {
        let (below, above) = ("a probability above 0 and below 0.5", "a probability above 0.5 and below 1");
        let is_below = |p: f64| p > 0.0 && p < 0.5;
        let is_above = |p: f64| p > 0.5 && p < 1.0;
        let checks = [
            ("update_factor_free", update_factor_free, is_below(update_factor_free), below),
            ("update_factor_occupied", update_factor_occupied, is_above(update_factor_occupied), above),
            ("p_min", p_min, is_below(p_min), below),
            ("p_max", p_max, is_above(p_max), above),
        ];
        let faults: Vec<EvidenceFault> = checks
            .into_iter()
            .filter(|(_, _, fine, _)| !fine)
            .map(|(name, found, _, expected)| EvidenceFault { name, found, expected })
            .collect();
        if !faults.is_empty() {
            return Err(faults);
        }
        Ok(Evidence {
            free: log_odds(update_factor_free),
            occupied: log_odds(update_factor_occupied),
            least: log_odds(p_min),
            most: log_odds(p_max),
        })
    }

    /// A cell after a beam passed it.
    #[inline(always)]
    pub fn passed(&self, cell: f32) -> f32 {
        let freer = cell + self.free;
        if freer < self.least { self.least } else { freer }
    }

    /// A cell after a beam ended in it.
    #[inline(always)]
    pub fn hit(&self, cell: f32) -> f32 {
        let surer = cell + self.occupied;
        if surer > self.most { self.most } else { surer }
    }
}
