//! What `[[sensor]] plugin = "person_tracker"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Says where a person of the world is: a phone that sends its position, a tag, a tracker in the building. It is what
/// `[mission] follow = { sensor = "..." }` names, and no localizer takes it for the robot's own position.
///
/// The world `sim` knows where the people of its file are; recordings play what was recorded. There is no protocol for a
/// real device yet: programs with one give the positions as orders (`person_at`).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct PersonTrackerParams {
    /// Name of the person in the world.
    pub person: String,
    /// Standard deviation of the position along each axis, meters.
    pub deviation_m: f64,
    /// A position arrives so long after it was measured, with the time at which it was measured, seconds.
    pub delay_s: f64,
    /// Share of the readings that never arrive.
    pub dropout_share: f64,
}

/// A later position than this is of no use to anybody.
const MOST_DELAY_S: f64 = 60.0;

impl Default for PersonTrackerParams {
    fn default() -> Self {
        Self { person: "person".into(), deviation_m: 0.1, delay_s: 0.0, dropout_share: 0.0 }
    }
}

impl Params for PersonTrackerParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        if self.person.trim().is_empty() {
            faults.push(BuildError::at("person", "is empty, expected the name of a person of the world"));
        }
        let mut expect = |fine: bool, key: &str, value: f64, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        let deviation = self.deviation_m;
        expect(
            deviation.is_finite() && deviation >= 0.0,
            "deviation_m",
            deviation,
            "a finite number, 0 or more",
        );
        let delay = self.delay_s;
        expect((0.0..=MOST_DELAY_S).contains(&delay), "delay_s", delay, "a time from 0 to 60");
        let share = self.dropout_share;
        expect((0.0..=1.0).contains(&share), "dropout_share", share, "a share from 0 to 1");
        faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_impossible_numbers_are_told_at_once_and_the_defaults_are_sound() {
        assert_eq!(PersonTrackerParams::default().check(), []);
        let wrong = PersonTrackerParams {
            person: " ".into(),
            deviation_m: f64::NAN,
            delay_s: 61.0,
            dropout_share: 1.1,
        };
        let keys: Vec<String> = wrong.check().into_iter().map(|fault| fault.path).collect();
        assert_eq!(keys, ["person", "deviation_m", "delay_s", "dropout_share"]);
    }
}
