//! Plugins from shared libraries.

use super::{DuplicateEntry, Registry, Stage};
use crate::boundary::host::{Library, LoadError};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Why a library's plugins are not in the registry.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AddError {
    /// It cannot be loaded.
    #[error("cannot load {0}")]
    Load(#[from] LoadError),
    /// A name is taken.
    #[error(transparent)]
    Duplicate(#[from] DuplicateEntry),
    /// It has the name of a plugin, but not the plugin.
    #[error("{} has no {stage} called `{name}`, though it has its name; it has {found}", path.display())]
    NotThere {
        /// The file.
        path: PathBuf,
        /// The stage that was looked for.
        stage: &'static str,
        /// The plugin that was looked for.
        name: String,
        /// What it has.
        found: String,
    },
}

impl Registry {
    /// Adds all plugins of a library; none where one of them has a name that is taken. A file that is here already
    /// changes nothing.
    pub fn add_library(&mut self, library: &Library) -> Result<(), DuplicateEntry> {
        let is_same = |entry: &Arc<super::Entry>| entry.origin == library.origin();
        if self.iter().any(is_same) {
            return Ok(());
        }
        let mut with = self.clone();
        for entry in &library.entries {
            with.add_shared(entry.clone())?;
        }
        *self = with;
        Ok(())
    }

    /// Loads the library `path` and adds its plugins. Its `sha256`, where one is given, must be this one.
    pub fn load(&mut self, path: &Path, sha256: Option<&str>) -> Result<Arc<Library>, AddError> {
        let library = Library::open(path, sha256)?;
        self.add_library(&library)?;
        Ok(library)
    }

    /// From now on this folder is searched for the library of a plugin that somebody names.
    pub fn search(&mut self, folder: PathBuf) {
        if !self.folders.contains(&folder) {
            self.folders.push(folder);
        }
    }

    /// Looks for a plugin that is not here in the folders that may be searched, and loads its library. It is no error
    /// that there is none.
    pub fn seek(&mut self, stage: Stage, name: &str) -> Result<(), AddError> {
        if self.get(stage, name).is_some() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_') {
            return Ok(());
        }
        let (prefix, suffix) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
        let file = format!("{prefix}{name}{suffix}");
        let Some(path) = self.folders.iter().map(|folder| folder.join(&file)).find(|path| path.exists())
        else {
            return Ok(());
        };
        let library = self.load(&path, None)?;
        if self.get(stage, name).is_some() {
            return Ok(());
        }
        let found = library.entries.iter().map(|entry| format!("{} {}", entry.stage.section(), entry.name));
        let found = found.collect::<Vec<_>>().join(", ");
        Err(AddError::NotThere { path, stage: stage.section(), name: name.to_owned(), found })
    }
}
