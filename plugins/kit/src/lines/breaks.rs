//! Where neighboring readings do not belong to one wall (Borges and Aldon 2004: adaptive break-point detector).

use super::LineSettings;

/// The rule for one spacing of beams: neighbors farther apart than
/// `min(r) sin(step) / sin(lambda - step) + 3 sigma_r` are a break.
#[derive(Debug, Clone, Copy)]
pub(super) struct BreakRule {
    cos_step: f64,
    /// Farthest step on one wall, meters per meter; none where the beams are wider apart than `lambda`: a wall at that
    /// incidence has no bound.
    per_range: Option<f64>,
    slack_m: f64,
}

impl BreakRule {
    pub fn new(settings: &LineSettings, bearing_step_rad: f64) -> BreakRule {
        let step_rad = bearing_step_rad.abs();
        let left_rad = settings.grazing_rad - step_rad;
        BreakRule {
            cos_step: step_rad.cos(),
            per_range: (left_rad > 0.0).then(|| step_rad.sin() / left_rad.sin()),
            slack_m: 3.0 * settings.noise.range_m,
        }
    }

    /// Neighboring readings of these ranges are a break.
    #[inline]
    pub fn parts(&self, one_m: f64, other_m: f64) -> bool {
        let Some(per_range) = self.per_range else { return false };
        let most_m = one_m.min(other_m) * per_range + self.slack_m;
        let apart_m2 = one_m * one_m + other_m * other_m - 2.0 * one_m * other_m * self.cos_step;
        apart_m2 > most_m * most_m
    }
}
