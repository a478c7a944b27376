//! A scripted drive at work: the mission's commands, as time goes by.

use super::build::EngineError;
use super::events::Event;
use super::navigator::{Navigator, Outcome};
use crate::frames::Twist;
use crate::pipeline::{Pipeline, Script};
use crate::stages::BuildError;
use crate::time::Time;

/// A script and when it began.
#[derive(Debug)]
pub(super) struct ScriptedDrive {
    script: Script,
    began: Option<Time>,
}

impl ScriptedDrive {
    /// What the mission names.
    pub fn of(pipeline: &Pipeline) -> Result<Option<ScriptedDrive>, EngineError> {
        let Some(file) = &pipeline.mission.commands else { return Ok(None) };
        let script = Script::read(&pipeline.folder.join(file)).map_err(|error| EngineError {
            section: "mission".to_owned(),
            error: BuildError::at("commands", error.to_string()),
        })?;
        Ok(Some(ScriptedDrive { script, began: None }))
    }

    /// What to do now; the mission ends with the script.
    pub fn steer(&mut self, now: Time, navigator: &mut Navigator, events: &mut Vec<Event>) -> Twist {
        let began = *self.began.get_or_insert(now);
        let twist = self.script.at(now - began);
        if twist.is_none() {
            navigator.end(now, Outcome::Driven, events);
        }
        twist.unwrap_or(Twist::ZERO)
    }
}
