//! Parameters of the navigation filter.

use rumbo_core::registry::Params;
use rumbo_core::robot::{DriveKind, Robot};
use rumbo_core::stages::BuildError;
use rumbo_core::time::Span;
use rumbo_kit::nav_filter::{Intersected, NavSettings, Omega};
use rumbo_kit::scan_odometry::ScanOdometrySettings;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::tracker::TrackerSettings;
use super::unseen::UsualSpeed;
use crate::number_faults::number_faults;

/// Where the base went in space: position, roll, pitch and yaw by an inertial measurement unit, held over the floor by laser
/// scans where there is a scanner, each registered to the last ones (Kohlbrecher et al., 2011; Arroyo Sánchez, 2013,
/// section 3.2).
///
/// For robots on slopes and rubble, in `[odometer]`: it needs an `imu` with rates and accelerations, and no wheels. On a robot
/// that tilts, the scans should come from `stabilized_scan`. What an accelerometer feels levels the attitude; scans hold
/// position, velocity and the bias of the rates; a robot that does not move stands. Without scans it only reckons, and says
/// so. Of several scanners, and of several inertial devices, it takes the first that speaks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NavFilterParams {
    /// Standard deviation of each turning rate, degrees a second.
    pub gyro_noise_deg_s: f64,
    /// Standard deviation of each acceleration, m/s².
    pub accel_noise_m_s2: f64,
    /// How the bias of the rates walks, degrees a second per root of a second.
    pub gyro_bias_walk_deg_s: f64,
    /// How the bias of the accelerations walks, m/s² per root of a second.
    pub accel_bias_walk_m_s2: f64,
    /// Standard deviation of the bias of the rates at the start, degrees a second.
    pub gyro_bias_deg_s: f64,
    /// Standard deviation of the bias of the accelerations at the start, m/s².
    pub accel_bias_m_s2: f64,
    /// The base is leveled by accelerations whose length is this near to gravity, m/s².
    pub gravity_gate_m_s2: f64,
    /// Standard deviation of a leveling, degrees.
    pub leveling_std_deg: f64,
    /// Standard deviation of the velocity to the side, m/s; not for omnidirectional drives.
    pub body_lateral_m_s: f64,
    /// Standard deviation of the velocity along the base's own vertical, m/s; it keeps the height from drifting.
    pub body_vertical_m_s: f64,
    /// Leveling, standing and not sliding are used at most so often, times a second.
    pub aid_rate_hz: f64,
    /// After so many refused updates in a row the filter counts as too sure of itself.
    pub max_rejects: u32,
    /// Weight of a scan against what the filter expects in covariance intersection, from 0 to less than 1. Absent: the one
    /// that makes the pose surest.
    pub ci_omega: Option<f64>,
    /// What covariance intersection applies to. `"pose"`: the planar pose; all else follows by what it has in common with it.
    /// `"everything"`: all states, as published, which makes roll and pitch less sure with each scan.
    pub intersection: Intersection,
    /// Scans that come at most so late are put in their place, seconds.
    pub history_s: f64,
    /// There is no integration over a longer gap between two inertial readings, seconds.
    pub imu_max_gap_s: f64,
    /// Wheels tell the velocity, too. Without this the result is the same with and without wheels.
    pub wheels: bool,
    /// Standard deviation of the wheels' velocity, m/s.
    pub wheels_deviation_m_s: f64,
    /// A scan becomes the key scan once the robot moved this far since the last one, meters.
    pub key_distance_m: f64,
    /// Or turned so far, degrees.
    pub key_angle_deg: f64,
    /// Farthest match of a point of a scan in the first steps, meters.
    pub max_match_m: f64,
    /// Noise of a range, meters: what is straighter than twice this is one wall.
    pub range_noise_m: f64,
    /// Standard deviation of the attitude that levels the scans of a robot that tilts, degrees: as that of `stabilized_scan`.
    pub leveled_within_deg: f64,
    /// Scans that are less sure than this in a direction, meters, say nothing about it. Absent: what the match itself calls
    /// unseen. On slopes a match between two walls may be wrong by more than it shows.
    pub seen_within_m: Option<f64>,
    /// How fast the robot drives along ways that scans do not see, m/s: that of the avoider. Not the wheels' reading; absent:
    /// nobody knows.
    pub usual_speed_m_s: Option<f64>,
    /// Standard deviation of the mean over a second of that, m/s.
    pub usual_speed_deviation_m_s: f64,
    /// Without a match for so long the robot is only reckoned, seconds.
    pub followed_for_s: f64,
    /// Without a match for so long, and without inertial readings, it is lost, seconds.
    pub lost_after_s: f64,
}

/// What covariance intersection applies to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Intersection {
    /// The planar pose.
    Pose,
    /// All states.
    Everything,
}

impl Default for NavFilterParams {
    fn default() -> Self {
        let (filter, scan) = (NavSettings::default(), ScanOdometrySettings::default());
        NavFilterParams {
            gyro_noise_deg_s: 0.6,
            accel_noise_m_s2: filter.accel_noise_m_s2,
            gyro_bias_walk_deg_s: 0.006,
            accel_bias_walk_m_s2: filter.accel_bias_walk,
            gyro_bias_deg_s: 1.0,
            accel_bias_m_s2: filter.accel_bias_m_s2,
            gravity_gate_m_s2: filter.gravity_gate_m_s2,
            leveling_std_deg: 2.865,
            body_lateral_m_s: 0.1,
            body_vertical_m_s: filter.body_vertical_m_s,
            aid_rate_hz: 20.0,
            max_rejects: filter.max_rejects,
            ci_omega: None,
            intersection: Intersection::Pose,
            history_s: 1.0,
            imu_max_gap_s: 0.2,
            wheels: false,
            wheels_deviation_m_s: 0.05,
            key_distance_m: 0.5,
            key_angle_deg: 20.0,
            max_match_m: scan.max_match_m,
            range_noise_m: scan.range_noise_m,
            leveled_within_deg: 0.5,
            seen_within_m: None,
            usual_speed_m_s: None,
            usual_speed_deviation_m_s: 0.1,
            followed_for_s: 1.0,
            lost_after_s: 5.0,
        }
    }
}

impl NavFilterParams {
    /// The settings for a robot.
    pub(super) fn settings(&self, robot: &Robot) -> TrackerSettings {
        let slides = robot.drive.kind() == DriveKind::Omnidirectional;
        TrackerSettings {
            filter: NavSettings {
                gyro_noise_rad_s: self.gyro_noise_deg_s.to_radians(),
                accel_noise_m_s2: self.accel_noise_m_s2,
                gyro_bias_walk: self.gyro_bias_walk_deg_s.to_radians(),
                accel_bias_walk: self.accel_bias_walk_m_s2,
                gyro_bias_rad_s: self.gyro_bias_deg_s.to_radians(),
                accel_bias_m_s2: self.accel_bias_m_s2,
                gravity_gate_m_s2: self.gravity_gate_m_s2,
                leveling_std_rad: self.leveling_std_deg.to_radians(),
                body_lateral_m_s: (!slides).then_some(self.body_lateral_m_s),
                body_vertical_m_s: self.body_vertical_m_s,
                aid_period: Span::from_secs(1.0 / self.aid_rate_hz),
                max_rejects: self.max_rejects,
                history: Span::from_secs(self.history_s),
                max_gap: Span::from_secs(self.imu_max_gap_s),
                max_acceleration_m_s2: robot.max_accel_m_s2.max(robot.braking_m_s2).max(1.0),
                omega: self.ci_omega.map_or(Omega::Best, Omega::Fixed),
                intersected: match self.intersection {
                    Intersection::Pose => Intersected::Pose,
                    Intersection::Everything => Intersected::Everything,
                },
                ..NavSettings::default()
            },
            scan: ScanOdometrySettings {
                key_distance_m: self.key_distance_m,
                key_angle_rad: self.key_angle_deg.to_radians(),
                max_match_m: self.max_match_m,
                range_noise_m: self.range_noise_m,
                far_retries: 3,
                far_sees_all: true,
                ..ScanOdometrySettings::default()
            },
            wheels_m_s: self.wheels.then_some(self.wheels_deviation_m_s),
            leveled_within_rad: self.leveled_within_deg.to_radians(),
            seen_within_m: self.seen_within_m,
            usual_speed: self
                .usual_speed_m_s
                .map(|forward_m_s| UsualSpeed { forward_m_s, deviation_m_s: self.usual_speed_deviation_m_s }),
            followed_for: Span::from_secs(self.followed_for_s),
            lost_after: Span::from_secs(self.lost_after_s),
            fastest: [robot.max_speed_m_s, robot.max_turn_rad_s()],
        }
    }
}

impl Params for NavFilterParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = number_faults(
            [
                ("gyro_bias_walk_deg_s", self.gyro_bias_walk_deg_s),
                ("accel_bias_walk_m_s2", self.accel_bias_walk_m_s2),
                ("gyro_bias_deg_s", self.gyro_bias_deg_s),
                ("accel_bias_m_s2", self.accel_bias_m_s2),
                ("history_s", self.history_s),
                ("lost_after_s", self.lost_after_s),
                ("leveled_within_deg", self.leveled_within_deg),
            ],
            [
                ("gyro_noise_deg_s", self.gyro_noise_deg_s),
                ("accel_noise_m_s2", self.accel_noise_m_s2),
                ("gravity_gate_m_s2", self.gravity_gate_m_s2),
                ("leveling_std_deg", self.leveling_std_deg),
                ("body_lateral_m_s", self.body_lateral_m_s),
                ("body_vertical_m_s", self.body_vertical_m_s),
                ("aid_rate_hz", self.aid_rate_hz),
                ("imu_max_gap_s", self.imu_max_gap_s),
                ("wheels_deviation_m_s", self.wheels_deviation_m_s),
                ("key_distance_m", self.key_distance_m),
                ("key_angle_deg", self.key_angle_deg),
                ("max_match_m", self.max_match_m),
                ("range_noise_m", self.range_noise_m),
                ("followed_for_s", self.followed_for_s),
                ("seen_within_m", self.seen_within_m.unwrap_or(1.0)),
                ("usual_speed_m_s", self.usual_speed_m_s.unwrap_or(1.0)),
                ("usual_speed_deviation_m_s", self.usual_speed_deviation_m_s),
            ],
        );
        if let Some(omega) = self.ci_omega.filter(|omega| !(0.0..1.0).contains(omega)) {
            let message = format!("is {omega}, expected a weight from 0 to less than 1");
            faults.push(BuildError::at("ci_omega", message));
        }
        if self.max_rejects == 0 {
            faults.push(BuildError::at("max_rejects", "is 0, expected at least 1"));
        }
        faults
    }
}
