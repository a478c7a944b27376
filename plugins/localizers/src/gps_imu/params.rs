//! Parameters of the localizer.

use rumbo_core::registry::Params;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use rumbo_core::time::Span;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ekf::EkfSettings;
use super::pulled::PulledSettings;
use super::tracker::TrackerSettings;
use crate::number_faults::number_faults;

/// Where a robot is by satellite fixes (`gps`), the yaw of an inertial measurement unit (`imu`) and wheels, without a map.
///
/// Without a start pose (`[mission] initial_pose = "unknown"`) the first fix is where the robot is, with the measured yaw.
/// Without fixes the wheels go on, and the position gets less sure. Between two attitudes, and without new ones, the wheels
/// turn the yaw.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GpsImuParams {
    /// `"odometry"`: wheels with the measured yaw, pulled back by fixes. `"mean3"`: the mean of the last three fixes, which
    /// needs no wheels and lags behind. `"ekf"`: a Kalman filter that also finds out by what the measured yaw is off.
    pub fusion: Fusion,
    /// `"imu"`: the yaw is measured. `"odometry"`: there is no such sensor, the wheels turn the yaw of the start pose;
    /// with `"ekf"` fixes correct it, and it may be unknown at the start: the robot then has to be moved until fixes tell
    /// it.
    pub heading: HeadingSource,
    /// Fixes err evenly between minus and plus this along each axis, meters. Without it: what the sensor claims.
    pub error_m: Option<f64>,
    /// `"odometry"`: standard deviation of each step of the wheels, meters per meter (k of the specification).
    pub step_noise: f64,
    /// `"odometry"`: a fix is refused that is farther from what is expected along an axis, in standard deviations.
    pub gate: f64,
    /// So many refused fixes (with `"ekf"` also yaws) in a row mean that they are right: the next one counts as the first.
    pub reset_after: u32,
    /// `"mean3"`: after so long without a fix the older ones are forgotten, seconds.
    pub outage_s: f64,
    /// Standard deviation of a measured yaw, degrees.
    pub yaw_deviation_deg: f64,
    /// `"ekf"`: standard deviation of what all measured yaws are off by at the start, degrees.
    pub yaw_bias_deviation_deg: f64,
    /// `"ekf"`: by how much that changes in a minute, degrees (standard deviation); it grows with the root of the time.
    pub yaw_bias_walk_deg: f64,
    /// `"ekf"`: standard deviation of the odometer's way over one meter, meters; it grows with the square root of the way.
    /// Without it: what the odometer claims.
    pub distance_noise: Option<f64>,
    /// Standard deviation of the odometer's heading after one meter straight ahead, degrees. Without it: what the odometer
    /// claims.
    pub direction_noise_deg_m: Option<f64>,
    /// Standard deviation of the odometer's turn of one radian, radians. Without it: what the odometer claims.
    pub turn_noise: Option<f64>,
    /// The robot counts as followed while the standard deviation of its position is at most this, meters.
    pub sure_deviation_m: f64,
    /// And that of its heading, degrees.
    pub sure_deviation_deg: f64,
    /// Two readings of the odometer farther apart than this, beyond what the robot can drive in between, are a jump,
    /// meters: the pose stays, and is less sure.
    pub jump_m: f64,
}

/// How fixes and wheels come together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Fusion {
    /// Wheels that fixes pull back.
    Odometry,
    /// The mean of three fixes.
    Mean3,
    /// A Kalman filter.
    Ekf,
}

/// Where the yaw comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HeadingSource {
    /// It is measured.
    Imu,
    /// The wheels turn it.
    Odometry,
}

impl Default for GpsImuParams {
    fn default() -> Self {
        GpsImuParams {
            fusion: Fusion::Odometry,
            heading: HeadingSource::Imu,
            error_m: None,
            step_noise: 0.02,
            gate: 3.0,
            reset_after: 10,
            outage_s: 5.0,
            yaw_deviation_deg: 0.5,
            yaw_bias_deviation_deg: 5.0,
            yaw_bias_walk_deg: 0.5,
            distance_noise: None,
            direction_noise_deg_m: None,
            turn_noise: None,
            sure_deviation_m: 5.0,
            sure_deviation_deg: 20.0,
            jump_m: 1.0,
        }
    }
}

impl GpsImuParams {
    /// The settings for a robot.
    pub(super) fn settings(&self, robot: &Robot) -> TrackerSettings {
        TrackerSettings {
            fusion: self.fusion,
            heading: self.heading,
            error_m: self.error_m,
            pulled: PulledSettings {
                step_noise: self.step_noise,
                gate: self.gate,
                reset_after: self.reset_after,
            },
            ekf: EkfSettings {
                bias_deviation_rad: self.yaw_bias_deviation_deg.to_radians(),
                bias_walk_rad: self.yaw_bias_walk_deg.to_radians() / 60f64.sqrt(),
                reset_after: self.reset_after,
            },
            outage: Span::from_secs(self.outage_s),
            yaw_variance_rad2: self.yaw_deviation_deg.to_radians().powi(2),
            odometry_noise: [
                self.distance_noise,
                self.direction_noise_deg_m.map(f64::to_radians),
                self.turn_noise,
            ],
            sure_m: self.sure_deviation_m,
            sure_rad: self.sure_deviation_deg.to_radians(),
            jump_m: self.jump_m,
            max_speed: [robot.max_speed_m_s, robot.max_turn_rad_s()],
        }
    }
}

impl Params for GpsImuParams {
    fn check(&self) -> Vec<BuildError> {
        let given = [
            ("distance_noise", self.distance_noise),
            ("direction_noise_deg_m", self.direction_noise_deg_m),
            ("turn_noise", self.turn_noise),
        ];
        let at_least_0 = given.into_iter().filter_map(|(key, value)| Some((key, value?))).chain([
            ("step_noise", self.step_noise),
            ("yaw_bias_deviation_deg", self.yaw_bias_deviation_deg),
            ("yaw_bias_walk_deg", self.yaw_bias_walk_deg),
        ]);
        let above_0 = self.error_m.map(|error_m| ("error_m", error_m)).into_iter().chain([
            ("gate", self.gate),
            ("outage_s", self.outage_s),
            ("yaw_deviation_deg", self.yaw_deviation_deg),
            ("sure_deviation_m", self.sure_deviation_m),
            ("sure_deviation_deg", self.sure_deviation_deg),
            ("jump_m", self.jump_m),
        ]);
        let mut faults = number_faults(at_least_0, above_0);
        if self.reset_after == 0 {
            faults.push(BuildError::at("reset_after", "is 0, expected at least 1"));
        }
        faults
    }
}
