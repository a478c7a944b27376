//! Parameters of mapping with lines.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::line_filter::{
    ExtractionParams, Growth, Integration, MotionModel, OdometerErrorParams, PeriodParams, SensorNoiseParams,
    SharedParams, SteeringModel,
};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Builds a map of wall lines and finds the robot in it, with one Kalman filter: wheels (or an odometer) and a steered wheel
/// at a fast rate, lines of laser scans at a slow one. For places with straight walls, and robots with a fixed axle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct EkfLineSlamParams {
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
    /// Pieces of wall farther apart than this along their line are different walls, meters (l_max).
    pub max_gap_m: f64,
    /// Scans that must show a line before it becomes a wall.
    pub confirm_hits: u32,
    /// A line that was not seen for so many scans is forgotten before it becomes a wall.
    pub forget_after_scans: u32,
    /// Long lines of the first scan become walls at once: the robot's pose at that time defines the map's frame. Without it
    /// the first walls take over the errors of the scans that had to confirm them.
    pub bootstrap: bool,
    /// How long a line of the first scan must be for that, meters.
    pub bootstrap_length_m: f64,
    /// Walls that overlap and cannot be told apart become one.
    pub merge: bool,
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

impl Default for EkfLineSlamParams {
    fn default() -> Self {
        let growth = Growth::default();
        EkfLineSlamParams {
            integration: Integration::Midpoint,
            sigma_linear_acceleration: 0.5,
            sigma_angular_acceleration: 0.3,
            sigma_lateral: 0.0,
            gate: 9.0,
            gate_distance_m: 0.8,
            gate_normal_deg: 20.0,
            joint_compatibility: false,
            max_gap_m: growth.gap_m,
            confirm_hits: growth.confirm_hits,
            forget_after_scans: growth.forget_after_scans,
            bootstrap: growth.bootstrap,
            bootstrap_length_m: growth.bootstrap_length_m,
            merge: growth.merge,
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

impl Params for EkfLineSlamParams {
    fn check(&self) -> Vec<BuildError> {
        let shared = self.shared().faults().into_iter();
        let mut faults: Vec<BuildError> = shared.map(|(key, message)| BuildError::at(key, message)).collect();
        for (key, value) in
            [("confirm_hits", self.confirm_hits), ("forget_after_scans", self.forget_after_scans)]
        {
            if value == 0 {
                faults.push(BuildError::at(key, "is 0, expected 1 or more"));
            }
        }
        let length = self.bootstrap_length_m;
        if !(length >= 0.0 && length.is_finite()) {
            let wrong = format!("is {length}, expected a finite number, 0 or more");
            faults.push(BuildError::at("bootstrap_length_m", wrong));
        }
        faults
    }
}

impl EkfLineSlamParams {
    /// What the localizer has too.
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
            // A robot that builds its map sees walls wherever it is.
            lost_after_scans: u32::MAX,
        }
    }

    /// When a line becomes a wall.
    pub(super) fn growth(&self) -> Growth {
        Growth {
            bootstrap: self.bootstrap,
            bootstrap_length_m: self.bootstrap_length_m,
            confirm_hits: self.confirm_hits,
            forget_after_scans: self.forget_after_scans,
            merge: self.merge,
            ..Growth::default()
        }
    }
}
