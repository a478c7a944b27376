//! A fix as the robot has it: of an antenna somewhere on it, and of a moment ago.

use nalgebra::Vector2;
use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::PositionFix;

/// No receiver is better than this, whatever it claims, meters.
const LEAST_DEVIATION_M: f64 = 0.005;
/// Half around the earth: beyond this a claim means nothing more, and its square must stay a number, meters.
const MOST_DEVIATION_M: f64 = 2e7;

/// A position of the antenna in the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeenFix {
    /// The position, meters.
    pub antenna_m: Vector2<f64>,
    /// Its variance along x and y, m².
    pub variance_m2: Vector2<f64>,
    /// The antenna seen from the base as it was when the fix was taken.
    pub lever_then_m: Vector2<f64>,
    /// The same place seen from the base as it is now: a fix that comes late is one of a place behind the robot.
    pub lever_now_m: Vector2<f64>,
}

impl SeenFix {
    /// A fix of a receiver that is mounted like this. `error_m` is the bound of its even errors, where it is not what the
    /// receiver claims.
    pub fn new(
        fix: &PositionFix,
        base_from_sensor: &Pose3,
        now_from_then: &Pose2,
        error_m: Option<f64>,
    ) -> SeenFix {
        let [x_m, y_m, _] = fix.position_m;
        let [x_deviation_m, y_deviation_m, _] = fix.deviation_m;
        let variance_m2 = |claimed_m: f64| {
            let deviation_m = error_m.map_or(claimed_m, |error_m| error_m / 3f64.sqrt());
            deviation_m.clamp(LEAST_DEVIATION_M, MOST_DEVIATION_M).powi(2)
        };
        let lever_then_m = base_from_sensor.translation.vector.xy();
        SeenFix {
            antenna_m: Vector2::new(x_m, y_m),
            variance_m2: Vector2::new(variance_m2(x_deviation_m), variance_m2(y_deviation_m)),
            lever_then_m,
            lever_now_m: (now_from_then * nalgebra::Point2::from(lever_then_m)).coords,
        }
    }

    /// One variance for both axes, m².
    pub fn mean_variance_m2(&self) -> f64 {
        self.variance_m2.mean()
    }
}
