//! The model of the present map: known, on its way beside the step, or wanted.

use super::matching::Knowledge;
use super::model_making::{FileUse, Made, ModelMaking};
use rumbo_core::map::Grid;
use rumbo_core::stages::{Background, BackgroundJob};
use rumbo_core::time::Time;
use rumbo_kit::landmark_model::{ModelSettings, Progress, fingerprint};
use std::path::PathBuf;
use std::sync::Arc;

/// Keeps the model of one map.
#[derive(Debug)]
pub struct ModelSeat {
    settings: ModelSettings,
    file: Option<PathBuf>,
    background: Background,
    of: Option<[u8; 32]>,
    state: State,
    file_use: FileUse,
}

#[derive(Debug)]
enum State {
    Empty,
    Wanted(Box<ModelMaking>),
    Making(BackgroundJob<Box<ModelMaking>>, Arc<Progress>),
    Known(Box<Knowledge>),
}

/// The work on a model panicked or was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the model of the map could not be made")]
pub struct NoModel;

impl ModelSeat {
    /// Nothing is known yet. Models are kept in `file`, and made in the `background`.
    pub fn new(settings: ModelSettings, file: Option<PathBuf>, background: Background) -> ModelSeat {
        let (of, state, file_use) = (None, State::Empty, FileUse::default());
        ModelSeat { settings, file, background, of, state, file_use }
    }

    /// From now on the model of this map is wanted; one that is known or on its way is kept.
    pub fn want(&mut self, grid: &Grid) {
        let wanted = fingerprint(grid, &self.settings);
        if self.of == Some(wanted) && !matches!(self.state, State::Empty) {
            return;
        }
        self.of = Some(wanted);
        let making = ModelMaking::new(grid, &self.settings, self.file.clone(), wanted);
        self.state = State::Wanted(Box::new(making));
    }

    /// Goes on by one part, if the part before is ready.
    pub fn go_on(&mut self, now: Time) -> Result<(), NoModel> {
        let making = match std::mem::replace(&mut self.state, State::Empty) {
            State::Wanted(making) => making,
            State::Making(mut job, progress) => match job.poll(now).map_err(|_| NoModel)? {
                Some(making) => making,
                None => {
                    self.state = State::Making(job, progress);
                    return Ok(());
                }
            },
            ready => {
                self.state = ready;
                return Ok(());
            }
        };
        match making.finish() {
            Made::GivenUp => return Err(NoModel),
            Made::Done(known, file_use) => {
                self.file_use = file_use;
                self.state = State::Known(known);
            }
            Made::Unfinished(mut making) => {
                let progress = making.progress();
                let job = self.background.run(now, move |give_up| {
                    making.go_on(give_up);
                    making
                });
                self.state = State::Making(job, progress);
            }
        }
        Ok(())
    }

    /// What is known of the map, once it is.
    pub fn known(&self) -> Option<&Knowledge> {
        if let State::Known(known) = &self.state { Some(known) } else { None }
    }

    /// How much of it is made, from 0 to 1.
    pub fn progress(&self) -> f64 {
        match &self.state {
            State::Empty | State::Wanted(_) => 0.0,
            State::Making(_, progress) => progress.share(),
            State::Known(_) => 1.0,
        }
    }

    /// What became of the file.
    pub fn file_use(&self) -> FileUse {
        self.file_use
    }
}
