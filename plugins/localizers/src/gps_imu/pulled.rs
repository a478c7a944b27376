//! Dead reckoning that fixes pull back: a position with one variance, the heading from elsewhere.
//!
//! The source only recommends to fuse (Valverde Moreno 2015, chapters 6 and 7.2). One variance is enough while the yaw is
//! measured: wheels and fixes then err alike in all directions.

use nalgebra::{Rotation2, Vector2};
use rumbo_core::frames::Pose2;

use super::seen_fix::SeenFix;

/// What every reading of the odometer adds to the variance besides, m².
const LEAST_GROWTH_M2: f64 = 1e-7;

/// How the filter works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PulledSettings {
    /// Standard deviation of a step of the odometer, meters per meter; each step errs anew.
    pub step_noise: f64,
    /// A fix is refused that is farther from what is expected along an axis, in standard deviations.
    pub gate: f64,
    /// After so many refused fixes in a row the next one is where the robot is.
    pub reset_after: u32,
}

/// What became of a fix.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Taken {
    /// It corrected the position.
    Used,
    /// It is the position: the first one, or the one after too many refused ones.
    Placed,
    /// It is too far from what is expected.
    Refused,
}

/// A position with one variance.
#[derive(Debug, Clone, PartialEq)]
pub struct Pulled {
    settings: PulledSettings,
    /// The base (m) and the variance along each axis (m²).
    known: Option<(Vector2<f64>, f64)>,
    n_refused_in_row: u32,
}

impl Pulled {
    /// From a start that somebody named, or from the first fix.
    pub fn new(settings: PulledSettings, start: Option<(Vector2<f64>, f64)>) -> Pulled {
        Pulled { settings, known: start, n_refused_in_row: 0 }
    }

    /// Position of the base (m) and variance along each axis (m²).
    pub fn position(&self) -> Option<(Vector2<f64>, f64)> {
        self.known
    }

    /// A step of the odometer, made at this yaw.
    pub fn advance(&mut self, step: &Pose2, yaw_rad: f64) {
        if let Some((position_m, variance_m2)) = &mut self.known {
            *position_m += Rotation2::new(yaw_rad) * step.translation.vector;
            *variance_m2 +=
                (self.settings.step_noise * step.translation.vector.norm()).powi(2) + LEAST_GROWTH_M2;
        }
    }

    /// The robot may have gone this far without anybody knowing.
    pub fn widen(&mut self, reach_m: f64) {
        if let Some((_, variance_m2)) = &mut self.known {
            *variance_m2 += reach_m * reach_m;
        }
    }

    /// A fix, for a robot with this yaw.
    pub fn take_fix(&mut self, fix: &SeenFix, yaw_rad: f64) -> Taken {
        let base_m = fix.antenna_m - Rotation2::new(yaw_rad) * fix.lever_now_m;
        let fix_variance_m2 = fix.mean_variance_m2();
        let is_last_straw = self.n_refused_in_row >= self.settings.reset_after;
        let Some((position_m, variance_m2)) = self.known.as_mut().filter(|_| !is_last_straw) else {
            self.known = Some((base_m, fix_variance_m2));
            self.n_refused_in_row = 0;
            return Taken::Placed;
        };
        let off_m = base_m - *position_m;
        let expected_m2 = *variance_m2 + fix_variance_m2;
        if off_m.iter().any(|off_m| off_m * off_m > self.settings.gate.powi(2) * expected_m2) {
            self.n_refused_in_row += 1;
            return Taken::Refused;
        }
        let gain = *variance_m2 / expected_m2;
        *position_m += gain * off_m;
        *variance_m2 *= 1.0 - gain;
        self.n_refused_in_row = 0;
        Taken::Used
    }
}
