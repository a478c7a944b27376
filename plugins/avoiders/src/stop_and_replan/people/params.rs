//! Parameters of meetings with people.

use super::PeopleTuning;
use super::encounter::Encounter;
use crate::stop_and_replan::meeting::MeetingTuning;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// People who walk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PeopleParams {
    /// People are predicted to go on as they go for so long, seconds: the robot slows down, waits or backs off where they
    /// would come too near. 0 takes everybody for an obstacle that stands, as published.
    pub horizon_s: f64,
    /// Room between the hull and a body, meters.
    pub keep_m: f64,
    /// Radius of a body with half of its stride, meters.
    pub radius_m: f64,
    /// A robot that has waited for so long asks once for another path around them, seconds; after that it looks less and
    /// less far ahead, since some walk to and fro for ever.
    pub patience_s: f64,
    /// The farthest that the robot backs off from who would walk into it, meters: only on the straight piece that it came.
    pub back_off_m: f64,
}

impl Default for PeopleParams {
    fn default() -> Self {
        PeopleParams { horizon_s: 4.0, keep_m: 0.15, radius_m: 0.35, patience_s: 8.0, back_off_m: 0.6 }
    }
}

impl PeopleParams {
    /// The numbers of meetings of this robot, which backs off with `back_m_s`.
    pub fn tuning(&self, robot: &Robot, expected_within_m: f64, back_m_s: f64) -> MeetingTuning {
        let encounter = Encounter {
            horizon_s: self.horizon_s,
            keep_m: self.keep_m,
            body_radius_m: self.radius_m,
            hull_radius_m: robot.hull().outer_radius_m(),
        };
        let people = PeopleTuning { encounter, patience_s: self.patience_s, expected_within_m };
        MeetingTuning { people, back_off_m: self.back_off_m, back_m_s }
    }

    /// Every impossible value.
    pub fn add_faults(&self, faults: &mut Vec<BuildError>) {
        let numbers = [
            ("people.horizon_s", self.horizon_s),
            ("people.keep_m", self.keep_m),
            ("people.radius_m", self.radius_m),
            ("people.patience_s", self.patience_s),
            ("people.back_off_m", self.back_off_m),
        ];
        let wrong = numbers.into_iter().filter(|(_, value)| !(*value >= 0.0 && value.is_finite()));
        faults.extend(wrong.map(|(key, value)| {
            BuildError::at(key, format!("is {value}, expected a finite number of at least zero"))
        }));
        const LONGEST_S: f64 = 60.0;
        if self.horizon_s.is_finite() && self.horizon_s > LONGEST_S {
            let wrong = format!("is {}, expected at most {LONGEST_S}", self.horizon_s);
            faults.push(BuildError::at("people.horizon_s", wrong));
        }
    }
}
