//! What the plugin in `[slam]` leaves at the end of a run: its trajectory, and its state for a later run.

use super::Args;
use super::poses::trajectory_text;
use crate::exit::Failure;
use crate::terminal::{make_folder_of, write_file};
use rumbo_core::engine::{AskError, Engine};
use rumbo_core::pipeline::Pipeline;
use rumbo_core::saved_state::SavedState;
use rumbo_core::stages::SlamError;
use std::path::PathBuf;

/// As far as it was asked for, and could be had.
pub struct Leaves {
    trajectory: Option<Result<String, Failure>>,
    state: Option<Result<SavedState, Failure>>,
}

/// What no run of this pipeline could leave is refused before anything moves.
pub fn refuse_impossible(args: &Args, pipeline: &Pipeline) -> Result<(), Failure> {
    if pipeline.slam.is_some() {
        return Ok(());
    }
    let refused = if args.trajectory.is_some() {
        "--trajectory writes what a [slam] knows at the end, and this pipeline has none; --poses writes where a \
         localizer thought that the robot was"
    } else if args.save_state.is_some() {
        "--save-state keeps what a [slam] knows, and this pipeline has none; a localizer begins anew on its map, with \
         `mission.initial_pose`"
    } else {
        return Ok(());
    };
    Err(Failure::Usage(refused.to_owned()))
}

/// A plugin that cannot save is refused before anything moves, too.
pub fn refuse_unsaved(args: &Args, engine: &Engine) -> Result<(), Failure> {
    if args.save_state.is_none() {
        return Ok(());
    }
    match engine.save_state() {
        Err(AskError::Slam { section, error: SlamError::CannotSave }) => {
            let error = SlamError::CannotSave;
            Err(Failure::Usage(format!("--save-state: {section}: {error}")))
        }
        // Others may have nothing to save before they have seen something.
        _ => Ok(()),
    }
}

impl Leaves {
    /// Asks for it.
    pub fn of(args: &Args, engine: &Engine) -> Leaves {
        let state = || {
            let state = engine.save_state();
            state.map_err(|error| Failure::Internal(format!("no state was saved: {error}")))
        };
        Leaves {
            trajectory: args.trajectory.as_ref().map(|_| trajectory_text(engine)),
            state: args.save_state.as_ref().map(|_| state()),
        }
    }

    /// Writes it. What cannot be had or written does not spoil the rest: the first failure is told at the end.
    pub fn write(self, args: &Args, written: &mut Vec<(&'static str, PathBuf)>) -> Result<(), Failure> {
        let mut outcome = Ok(());
        if let (Some(path), Some(text)) = (&args.trajectory, self.trajectory) {
            let done = text.and_then(|text| write_file(path, text.as_bytes()));
            outcome = outcome.and(done.map(|()| written.push(("trajectory", path.clone()))));
        }
        if let (Some(path), Some(state)) = (&args.save_state, self.state) {
            let done = state.and_then(|state| {
                make_folder_of(path)?;
                let cannot = |error| Failure::Internal(format!("cannot write {}: {error}", path.display()));
                state.write(path).map_err(cannot)
            });
            outcome = outcome.and(done.map(|()| written.push(("state", path.clone()))));
        }
        outcome
    }
}
