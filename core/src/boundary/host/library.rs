//! A shared library with plugins: opened, checked, never unloaded.
#![allow(unsafe_code)]

use super::super::abi::{RUMBO_ENTRY, rumbo_host, rumbo_module};
use super::callbacks::HOST;
use super::entry::entry;
#[cfg(feature = "host")]
use super::file::{self, FileError};
use super::module::{ModuleError, ModuleInfo, records};
use crate::registry::Entry;
use std::path::{Path, PathBuf};

/// A library with its entries.
#[derive(Debug)]
pub struct Library {
    /// The file, with links followed.
    pub path: PathBuf,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// What it says about itself.
    pub info: ModuleInfo,
    /// Its plugins.
    pub entries: Vec<Entry>,
}

/// Why a library is not loaded.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{}: {reason}", path.display())]
pub struct LoadError {
    /// The file as it was named.
    pub path: PathBuf,
    /// Why.
    pub reason: LoadReason,
}

/// What is wrong with a library.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LoadReason {
    /// The file, before it is loaded.
    #[cfg(feature = "host")]
    #[error(transparent)]
    File(#[from] FileError),
    /// The system's loader refuses it.
    #[error("the system cannot load it: {0}")]
    System(String),
    /// Its record.
    #[error(transparent)]
    Module(#[from] ModuleError),
}

type EntryFunction = unsafe extern "C" fn(*const rumbo_host) -> *const rumbo_module;

impl Library {
    /// Opens the library `path`. Its `sha256`, where one is given, must be this one.
    #[cfg(feature = "host")]
    pub fn open(path: &Path, sha256: Option<&str>) -> Result<Library, LoadError> {
        let wrong = |reason: LoadReason| LoadError { path: path.to_path_buf(), reason };
        let checked = file::check(path, sha256).map_err(|e| wrong(e.into()))?;
        let system = |e: libloading::Error| {
            // The error's own words are only "dlopen failed"; what is behind it names the missing file or symbol.
            let why = std::error::Error::source(&e).map_or_else(|| e.to_string(), ToString::to_string);
            wrong(LoadReason::System(why))
        };
        // SAFETY: loading runs the constructors of the library: this is why only files are loaded that the user named.
        let library = unsafe { libloading::Library::new(&checked.path) }.map_err(system)?;
        // SAFETY: the ABI says which type the symbol has.
        let function = unsafe { library.get::<EntryFunction>(RUMBO_ENTRY) }.map_err(system)?;
        let function: EntryFunction = *function;
        // Never unloaded: its threads, thread-locals and statics may outlive every instance.
        std::mem::forget(library);
        let origin = checked.path.display().to_string();
        // SAFETY: a function of the library that was just loaded.
        let (info, entries) = unsafe { entries(function, &origin) }.map_err(|e| wrong(e.into()))?;
        Ok(Library { path: checked.path, sha256: checked.sha256, info, entries })
    }

    /// As if a library with this entry function had been loaded: for tests of both sides in one program.
    ///
    /// # Safety
    /// The function keeps the promises of the ABI.
    #[doc(hidden)]
    pub unsafe fn of_function(function: EntryFunction, origin: &str) -> Result<Library, LoadError> {
        // SAFETY: as promised by the caller.
        let found = unsafe { entries(function, origin) };
        let wrong = |e: ModuleError| LoadError { path: PathBuf::from(origin), reason: e.into() };
        let (info, entries) = found.map_err(wrong)?;
        Ok(Library { path: Path::new(origin).to_path_buf(), sha256: String::new(), info, entries })
    }
}

/// # Safety
/// The function keeps the promises of the ABI.
unsafe fn entries(function: EntryFunction, origin: &str) -> Result<(ModuleInfo, Vec<Entry>), ModuleError> {
    // SAFETY: as promised by the caller; the host table lives as long as the program.
    let module = unsafe { function(&raw const HOST) };
    // SAFETY: what the entry function returned.
    let (info, records) = unsafe { records(module)? };
    Ok((info, records.into_iter().map(|record| entry(record, origin)).collect()))
}
