//! Parameters of localization with lines.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::line_filter::{
    ExtractionParams, Integration, MotionModel, OdometerErrorParams, PeriodParams, SensorNoiseParams,
    SharedParams, SteeringModel,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Follows a robot from a known start along the walls of a line map, with a Kalman filter: wheels (or an odometer) and a
/// steered wheel at a fast rate, lines of laser scans at a slow one. What the map says of its own errors is considered.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EkfLinesParams {
    /// How a step is integrated: `midpoint`, or `euler` as the source prints it, which drifts sideways in curves.
    pub integration: Integration,
    /// Standard deviation of the acceleration over a step, m/s² (sigma_a). Too small makes the filter overconfident; too
    /// large is harmless. It belongs to the time between readings: the same number means more noise where they are rare.
    pub sigma_linear_acceleration: f64,
    /// The same of the turn, rad/s² (sigma_alpha).
    pub sigma_angular_acceleration: f64,
    /// Side slip after one second, meters (sigma_lat); it grows with the square root of the time.
    pub sigma_lateral: f64,
    /// Squared Mahalanobis distance up to which a line is a wall of the map (eta): 9.0 keeps 98.9 % of the right pairs.
    pub gate: f64,
    /// And up to which distance beside its wall, meters.
    pub gate_distance_m: f64,
    /// And up to which turn against it, degrees. Robots whose odometer errs by much need more.
    pub gate_normal_deg: f64,
    /// Pairs of a line and a wall must fit together, not only each by itself: slower, and safer where walls are near each
    /// other. Without it each line is the nearest wall.
    pub joint_compatibility: bool,
    /// A piece of wall farther than this from a wall of the map, along its line, is another one, meters (l_max).
    pub max_gap_m: f64,
    /// So many scans in a row of which no line is a wall of the map, and the robot is lost.
    pub lost_after_scans: u32,
    /// A scan is taken in only when the robot went so far since the last that was, meters, or turned so far: what scans of
    /// one place get wrong they get wrong alike, and a filter that takes them for independent grows too sure. 0 takes all.
    pub look_every_m: f64,
    /// The turn, degrees.
    pub look_every_deg: f64,
    /// What the steering angle has to do with the motion: `arctangent`, or `small_angle` as the source prints it.
    pub steering_model: SteeringModel,
    /// Below this speed the steering angle says nothing, m/s.
    pub steering_min_speed_m_s: f64,
    /// Squared Mahalanobis distance from which on a wheel slips, where sensors say the speeds of wheels: 13.8 is 99.9 % of what right readings keep. Wheels that
    /// disagree for longer than 0.6 s are believed again.
    pub slip_gate: f64,
    /// A reading that is older than the state by more than this is left out, and counted, seconds.
    pub late_s: f64,
    /// Standard deviations of the sensors.
    pub noise: SensorNoiseParams,
    /// Errors of the odometer that the filter learns.
    pub odometer_errors: OdometerErrorParams,
    /// When readings of a scan are a line.
    pub extraction: ExtractionParams,
    /// Periods that readings are thinned to, for filters at a fixed rate.
    pub periods: PeriodParams,
}

impl Default for EkfLinesParams {
    fn default() -> Self {
        EkfLinesParams {
            integration: Integration::Midpoint,
            sigma_linear_acceleration: 0.5,
            sigma_angular_acceleration: 0.3,
            sigma_lateral: 0.0,
            gate: 9.0,
            gate_distance_m: 0.8,
            gate_normal_deg: 20.0,
            joint_compatibility: false,
            max_gap_m: 1.0,
            lost_after_scans: 20,
            look_every_m: 0.0,
            look_every_deg: 0.0,
            steering_model: SteeringModel::Arctangent,
            steering_min_speed_m_s: 0.5,
            slip_gate: 13.8,
            late_s: 0.1,
            noise: SensorNoiseParams::default(),
            odometer_errors: OdometerErrorParams::default(),
            extraction: ExtractionParams::default(),
            periods: PeriodParams::default(),
        }
    }
}

impl Params for EkfLinesParams {
    fn check(&self) -> Vec<BuildError> {
        let faults = self.shared().faults().into_iter();
        faults.map(|(key, message)| BuildError::at(key, message)).collect()
    }
}

impl EkfLinesParams {
    /// What mapping has too.
    pub(super) fn shared(&self) -> SharedParams<'_> {
        SharedParams {
            motion: MotionModel {
                integration: self.integration,
                acceleration_m_s2: self.sigma_linear_acceleration,
                turn_acceleration_rad_s2: self.sigma_angular_acceleration,
                lateral_m: self.sigma_lateral,
            },
            extraction: &self.extraction,
            noise: &self.noise,
            odometer: &self.odometer_errors,
            periods: &self.periods,
            steering_model: self.steering_model,
            steering_min_speed_m_s: self.steering_min_speed_m_s,
            slip_gate: self.slip_gate,
            gate: self.gate,
            gate_distance_m: self.gate_distance_m,
            gate_normal_deg: self.gate_normal_deg,
            look_every_m: self.look_every_m,
            look_every_deg: self.look_every_deg,
            joint: self.joint_compatibility,
            max_gap_m: self.max_gap_m,
            late_s: self.late_s,
            lost_after_scans: self.lost_after_scans,
        }
    }
}
