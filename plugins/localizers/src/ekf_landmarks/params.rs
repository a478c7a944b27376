//! Parameters of the filter.

use rumbo_core::registry::Params;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::sureness::Sureness;
use super::tracker::TrackerSettings;
use crate::number_faults::number_faults;

/// An extended Kalman filter that follows a robot by known marks: range and bearing to marks of the map's layer
/// `landmarks`, and the odometer in between. A robot that may be anywhere is found once three marks that it knows were
/// seen within 5 s and agree; the filter does not ask it to move for that.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EkfLandmarksParams {
    /// Standard deviation of the odometer's way over one meter, meters; it grows with the square root of the way.
    /// Without it: what the odometer claims.
    pub distance_noise: Option<f64>,
    /// Standard deviation of the heading after one meter straight ahead, degrees. Without it: what the odometer claims.
    pub direction_noise_deg_m: Option<f64>,
    /// Standard deviation of a turn of one radian, radians. Without it: what the odometer claims.
    pub turn_noise: Option<f64>,
    /// By how much the odometer may count ways too long or too short all the time, a share (standard deviation). Above 0
    /// the filter estimates it along.
    pub distance_scale_deviation: f64,
    /// The same for turns.
    pub turn_scale_deviation: f64,
    /// Standard deviation of ranges, meters. Without it: what the sensor claims.
    pub range_deviation_m: Option<f64>,
    /// Part of that deviation that grows with the range, meters per meter.
    pub range_share: f64,
    /// Standard deviation of bearings, degrees. Without it: what the sensor claims.
    pub bearing_deviation_deg: Option<f64>,
    /// A mark whose identity the sensor could not tell is taken for the only one of the map that it can be (gated nearest
    /// neighbor); else such marks are not used.
    pub match_unknown: bool,
    /// So many sightings in a row that do not fit (beyond 99.9 % of the chi-square distribution) mean that the robot is
    /// lost: three marks that agree put it elsewhere then.
    pub lost_after: u32,
    /// The robot counts as followed while the standard deviation of its position is at most this, meters.
    pub sure_deviation_m: f64,
    /// And that of its heading, degrees.
    pub sure_deviation_deg: f64,
    /// Two readings of the odometer farther apart than this, beyond what the robot can drive in between, are a jump,
    /// meters: the pose stays, and is less sure.
    pub jump_m: f64,
}

impl Default for EkfLandmarksParams {
    fn default() -> Self {
        EkfLandmarksParams {
            distance_noise: None,
            direction_noise_deg_m: None,
            turn_noise: None,
            distance_scale_deviation: 0.0,
            turn_scale_deviation: 0.0,
            range_deviation_m: None,
            range_share: 0.0,
            bearing_deviation_deg: None,
            match_unknown: false,
            lost_after: 15,
            sure_deviation_m: 0.5,
            sure_deviation_deg: 20.0,
            jump_m: 1.0,
        }
    }
}

impl EkfLandmarksParams {
    /// The settings for a robot.
    pub(super) fn settings(&self, robot: &Robot) -> TrackerSettings {
        TrackerSettings {
            odometry_noise: [
                self.distance_noise,
                self.direction_noise_deg_m.map(f64::to_radians),
                self.turn_noise,
            ],
            scale_deviations: [self.distance_scale_deviation, self.turn_scale_deviation],
            range_deviation_m: self.range_deviation_m,
            range_share: self.range_share,
            bearing_deviation_rad: self.bearing_deviation_deg.map(f64::to_radians),
            match_unknown: self.match_unknown,
            sureness: Sureness {
                sure_m: self.sure_deviation_m,
                sure_rad: self.sure_deviation_deg.to_radians(),
                lost_after: self.lost_after,
            },
            jump_m: self.jump_m,
            max_speed: [robot.max_speed_m_s, robot.max_turn_rad_s()],
        }
    }
}

impl Params for EkfLandmarksParams {
    fn check(&self) -> Vec<BuildError> {
        let given = [
            ("distance_noise", self.distance_noise),
            ("direction_noise_deg_m", self.direction_noise_deg_m),
            ("turn_noise", self.turn_noise),
            ("range_deviation_m", self.range_deviation_m),
            ("bearing_deviation_deg", self.bearing_deviation_deg),
        ];
        let at_least_0 = given.into_iter().filter_map(|(key, value)| Some((key, value?))).chain([
            ("distance_scale_deviation", self.distance_scale_deviation),
            ("turn_scale_deviation", self.turn_scale_deviation),
            ("range_share", self.range_share),
        ]);
        let above_0 = [
            ("sure_deviation_m", self.sure_deviation_m),
            ("sure_deviation_deg", self.sure_deviation_deg),
            ("jump_m", self.jump_m),
        ];
        let mut faults = number_faults(at_least_0, above_0);
        if self.lost_after == 0 {
            faults.push(BuildError::at("lost_after", "is 0, expected at least 1"));
        }
        faults
    }
}
