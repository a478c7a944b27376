//! Parameters of pure pursuit.

use super::pursuit::PursuitTuning;
use super::way_ahead::WayTuning;
use rumbo_core::registry::Params;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Follows the path along arcs to a point ahead; keeps the turning radius, slows in curves and near obstacles, and stops
/// in front of what is in its way.
///
/// For every drive. A robot that turns in place does so where its path leads off to the side; one that cannot (a tricycle)
/// backs up where its path is behind it or ends inside its turning circles, and turns to and fro where the map leaves no room
/// for the arc to its path. Headings of waypoints are for robots that turn
/// in place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PurePursuitParams {
    /// The point that is pursued is at least and at most this far ahead along the path, meters.
    pub look_ahead_m: [f64; 2],
    /// In between it is as far ahead as the robot drives in this time, seconds.
    pub look_ahead_s: f64,
    /// Fastest speed, m/s; the robot's own where absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// Fastest speed backwards, share of the speed.
    pub backing_share: f64,
    /// Slowest speed of a curve, and near the end of the path, m/s.
    pub least_m_s: f64,
    /// Most acceleration to the side in a curve, m/s².
    pub to_the_side_m_s2: f64,
    /// A robot that turns in place does so when the point ahead is farther than this from straight ahead, degrees.
    pub turn_above_deg: f64,
    /// A heading at the end of the path is good within this, degrees.
    pub yaw_within_deg: f64,
    /// A robot that cannot turn in place may drive backwards; else a path that needs it is `blocked`.
    pub backs_up: bool,
    /// Room around the hull that stays free of what is seen, meters; more than the guard's margin.
    pub clearance_m: f64,
    /// Obstacles are looked for this far along the arc, meters, and at least as far as the brakes need.
    pub reach_m: f64,
    /// Nearer than this to the hull, what is seen slows the robot, meters: in proportion, down to `least_m_s`.
    pub slow_within_m: f64,
    /// The robot stands in front of an obstacle for so long before it says that the way is blocked, seconds: somebody may
    /// be walking by.
    pub wait_s: f64,
    /// A hit this near to an occupied cell of the map is not told as an obstacle, meters: it is known.
    pub expected_within_m: f64,
    /// A range reading older than this stops the robot, seconds.
    pub stale_after_s: f64,
    /// A robot that hardly moves for this long although it should is blocked, seconds.
    pub stuck_after_s: f64,
}

impl Default for PurePursuitParams {
    fn default() -> Self {
        PurePursuitParams {
            look_ahead_m: [0.4, 1.5],
            look_ahead_s: 1.5,
            speed_m_s: None,
            backing_share: 0.5,
            least_m_s: 0.05,
            to_the_side_m_s2: 0.4,
            turn_above_deg: 45.0,
            yaw_within_deg: 3.0,
            backs_up: true,
            clearance_m: 0.08,
            reach_m: 1.5,
            slow_within_m: 0.3,
            wait_s: 1.0,
            expected_within_m: 0.20,
            stale_after_s: 1.0,
            stuck_after_s: 4.0,
        }
    }
}

impl Params for PurePursuitParams {
    fn check(&self) -> Vec<BuildError> {
        let above = |value: f64| value.is_finite() && value > 0.0;
        let least = |value: f64| value.is_finite() && value >= 0.0;
        let checks = [
            ("look_ahead_m", self.look_ahead_m[0], above(self.look_ahead_m[0]), "above 0"),
            ("look_ahead_m", self.look_ahead_m[1], above(self.look_ahead_m[1]), "above 0"),
            ("look_ahead_s", self.look_ahead_s, least(self.look_ahead_s), "0 or more"),
            ("speed_m_s", self.speed_m_s.unwrap_or(1.0), self.speed_m_s.is_none_or(above), "above 0"),
            (
                "backing_share",
                self.backing_share,
                self.backing_share > 0.0 && self.backing_share <= 1.0,
                "above 0, to 1",
            ),
            ("least_m_s", self.least_m_s, above(self.least_m_s), "above 0"),
            ("to_the_side_m_s2", self.to_the_side_m_s2, above(self.to_the_side_m_s2), "above 0"),
            ("turn_above_deg", self.turn_above_deg, (5.0..=180.0).contains(&self.turn_above_deg), "5 to 180"),
            ("yaw_within_deg", self.yaw_within_deg, (0.1..=90.0).contains(&self.yaw_within_deg), "0.1 to 90"),
            ("clearance_m", self.clearance_m, least(self.clearance_m), "0 or more"),
            ("reach_m", self.reach_m, above(self.reach_m) && self.reach_m <= 20.0, "above 0, to 20"),
            ("slow_within_m", self.slow_within_m, least(self.slow_within_m), "0 or more"),
            ("wait_s", self.wait_s, least(self.wait_s), "0 or more"),
            ("expected_within_m", self.expected_within_m, least(self.expected_within_m), "0 or more"),
            ("stale_after_s", self.stale_after_s, above(self.stale_after_s), "above 0"),
            ("stuck_after_s", self.stuck_after_s, above(self.stuck_after_s), "above 0"),
        ];
        let bad = checks.into_iter().filter(|(_, _, is_fine, _)| !is_fine);
        let mut faults: Vec<BuildError> = bad
            .map(|(key, value, _, expected)| {
                BuildError::at(key, format!("is {value}, expected a number {expected}"))
            })
            .collect();
        let [nearest_m, farthest_m] = self.look_ahead_m;
        if nearest_m > farthest_m {
            let message =
                format!("begins at {nearest_m} and ends at {farthest_m}, expected the smaller one first");
            faults.push(BuildError::at("look_ahead_m", message));
        }
        faults
    }
}

impl PurePursuitParams {
    /// The turn in place goes on until the point ahead is within this share of `turn_above_deg`.
    const TURN_UNTIL: f64 = 0.15;

    /// Numbers of the pursuit for a robot.
    pub fn pursuit(&self, robot: &Robot) -> PursuitTuning {
        let speed_m_s = self.speed_m_s.unwrap_or(f64::INFINITY).min(robot.max_speed_m_s);
        PursuitTuning {
            look_ahead_m: self.look_ahead_m,
            look_ahead_s: self.look_ahead_s,
            speed_m_s,
            backing_m_s: speed_m_s * self.backing_share,
            least_m_s: self.least_m_s.min(speed_m_s),
            turn_rad_s: robot.max_turn_rad_s(),
            to_the_side_m_s2: self.to_the_side_m_s2,
            // Half of what they can, so that the end is met without a jerk.
            braking_m_s2: robot.braking_m_s2 / 2.0,
            turn_braking_rad_s2: robot.max_turn_accel_rad_s2() / 2.0,
            radius_m: robot.drive.turning_radius_m(),
            turn_above_rad: self.turn_above_deg.to_radians(),
            turn_below_rad: (self.turn_above_deg * Self::TURN_UNTIL).to_radians(),
            yaw_within_rad: self.yaw_within_deg.to_radians(),
            backs_up: self.backs_up,
        }
    }

    /// Numbers of the look ahead for a robot.
    pub fn way(&self, robot: &Robot) -> WayTuning {
        let clearance_m = self.clearance_m.max(robot.guard.margin_m);
        let stop_m = robot.stopping_m(robot.max_speed_m_s);
        WayTuning {
            hull: robot.hull(),
            clearance_m,
            reach_m: self.reach_m.max(2.0 * stop_m),
            beside_m: 0.3,
            expected_within_m: self.expected_within_m,
        }
    }
}
