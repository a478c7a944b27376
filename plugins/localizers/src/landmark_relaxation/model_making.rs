//! Makes the model of a map part by part, or takes it from its file.

use super::matching::Knowledge;
use rumbo_core::map::Grid;
use rumbo_core::stages::GiveUp;
use rumbo_kit::landmark_model::{
    ModelBuilder, ModelFileError, ModelSettings, Progress, Surroundings, load_model, save_model,
};
use std::io::ErrorKind;
use std::path::PathBuf;
use std::sync::Arc;

/// What became of the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FileUse {
    /// The model came from it.
    pub was_read: bool,
    /// There was one that is not the model of this map: it was replaced.
    pub was_refused: bool,
    /// It could not be written.
    pub is_unwritable: bool,
}

/// A model on its way.
#[derive(Debug)]
pub struct ModelMaking {
    grid: Grid,
    fingerprint: [u8; 32],
    settings: ModelSettings,
    surroundings: Surroundings,
    file: Option<PathBuf>,
    progress: Arc<Progress>,
    stage: Stage,
    file_use: FileUse,
}

#[derive(Debug)]
enum Stage {
    /// The file was not looked at yet.
    New,
    Building(ModelBuilder),
    /// From the file, with the parts that building would still take.
    Read(Knowledge, usize),
    Done(Knowledge),
    /// Asked to give up.
    GivenUp,
}

/// Cells that are traced at once: some seconds' work, so that no step of a simulation takes long.
const PART: usize = 65_536;

impl ModelMaking {
    /// Begins the model of a map. With a `file` it is read from there, if it is the same, and written there, if not.
    /// The `fingerprint` is that of the map with these settings.
    pub fn new(
        grid: &Grid,
        settings: &ModelSettings,
        file: Option<PathBuf>,
        fingerprint: [u8; 32],
    ) -> ModelMaking {
        ModelMaking {
            grid: grid.clone(),
            fingerprint,
            settings: *settings,
            surroundings: Surroundings::new(grid),
            file,
            progress: Arc::default(),
            stage: Stage::New,
            file_use: FileUse::default(),
        }
    }

    /// How far it is; may be looked at while it is made.
    pub fn progress(&self) -> Arc<Progress> {
        self.progress.clone()
    }

    /// Goes on by one part. A model from a file takes as many parts as one that is built: what a simulation gives must not
    /// depend on what lies on the disk.
    pub fn go_on(&mut self, give_up: &GiveUp) {
        self.stage = match std::mem::replace(&mut self.stage, Stage::GivenUp) {
            Stage::New => return self.begin(),
            Stage::Building(builder) => return self.build(builder, give_up),
            Stage::Read(knowledge, n_left) if n_left > 1 => Stage::Read(knowledge, n_left - 1),
            Stage::Read(knowledge, _) => Stage::Done(knowledge),
            other => other,
        };
    }

    fn begin(&mut self) {
        let read = self.file.as_deref().map(|file| load_model(file, &self.fingerprint));
        self.stage = match read {
            Some(Ok(model)) => {
                self.file_use.was_read = true;
                let (grid, surroundings) = (self.grid.clone(), self.surroundings.clone());
                let n_parts = model.n_places().div_ceil(PART);
                Stage::Read(Knowledge { grid, surroundings, model }, n_parts)
            }
            missing => {
                self.file_use.was_refused = missing.is_some_and(|read| read.is_err_and(|e| !is_absent(&e)));
                Stage::Building(ModelBuilder::new(&self.surroundings))
            }
        };
    }

    fn build(&mut self, mut builder: ModelBuilder, give_up: &GiveUp) {
        builder.go_on(&self.surroundings, &self.settings, PART, &self.progress, give_up);
        if give_up.is_raised() {
            return;
        }
        if !builder.is_done() {
            self.stage = Stage::Building(builder);
            return;
        }
        let Some(model) = builder.finish() else { return };
        let written = self.file.as_deref().map(|file| save_model(file, &model, &self.fingerprint));
        self.file_use.is_unwritable = written.is_some_and(|written| written.is_err());
        let (grid, surroundings) = (self.grid.clone(), self.surroundings.clone());
        self.stage = Stage::Done(Knowledge { grid, surroundings, model });
    }

    /// What has come of it.
    pub fn finish(self) -> Made {
        match self.stage {
            Stage::Done(knowledge) => Made::Done(Box::new(knowledge), self.file_use),
            Stage::GivenUp => Made::GivenUp,
            Stage::New | Stage::Building(_) | Stage::Read(..) => Made::Unfinished(Box::new(self)),
        }
    }
}

/// What has come of the making of a model.
#[derive(Debug)]
pub enum Made {
    /// What is known, and what became of the file.
    Done(Box<Knowledge>, FileUse),
    /// It has to go on.
    Unfinished(Box<ModelMaking>),
    /// It was asked to give up.
    GivenUp,
}

fn is_absent(error: &ModelFileError) -> bool {
    matches!(error, ModelFileError::System(error) if error.kind() == ErrorKind::NotFound)
}
