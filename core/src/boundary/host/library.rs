//! A shared library with plugins: opened, checked, never unloaded.
#![allow(unsafe_code)]

#[cfg(feature = "host")]
use super::super::abi::RUMBO_ENTRY;
use super::super::abi::{rumbo_host, rumbo_module};
use super::callbacks::HOST;
use super::entry::entry;
#[cfg(feature = "host")]
use super::file::{self, FileError};
use super::module::{ModuleError, records};
use crate::registry::{Entry, LibraryInfo};
use std::path::{Path, PathBuf};
use std::sync::Arc;
#[cfg(feature = "host")]
use std::{collections::BTreeMap, sync::Mutex};

/// A library with its entries.
#[derive(Debug)]
pub struct Library {
    /// The file and what it says about itself.
    pub info: Arc<LibraryInfo>,
    /// Its plugins.
    pub entries: Vec<Arc<Entry>>,
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

/// Libraries that are loaded already: a second loading would give the same functions again.
#[cfg(feature = "host")]
static LOADED: Mutex<BTreeMap<PathBuf, Arc<Library>>> = Mutex::new(BTreeMap::new());

/// Opens a library with all its symbols resolved: found only when it is called, a missing one would end the program with
/// the robot moving.
///
/// # Safety
/// As `libloading::Library::new`.
#[cfg(feature = "host")]
unsafe fn opened_now(path: &Path) -> Result<libloading::Library, libloading::Error> {
    #[cfg(unix)]
    {
        use libloading::os::unix::{Library, RTLD_LOCAL, RTLD_NOW};
        // SAFETY: as promised by the caller.
        unsafe { Library::open(Some(path), RTLD_NOW | RTLD_LOCAL) }.map(Into::into)
    }
    #[cfg(not(unix))]
    {
        // SAFETY: as promised by the caller; other systems resolve everything at once.
        unsafe { libloading::Library::new(path) }
    }
}

impl Library {
    /// The file, as entries name it.
    pub fn origin(&self) -> String {
        self.info.path.display().to_string()
    }

    /// Opens the library `path`. Its `sha256`, where one is given, must be this one. A file is opened once in the life of
    /// a program.
    #[cfg(feature = "host")]
    pub fn open(path: &Path, sha256: Option<&str>) -> Result<Arc<Library>, LoadError> {
        let wrong = |reason: LoadReason| LoadError { path: path.to_path_buf(), reason };
        let mut loaded = LOADED.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some(known) = path.canonicalize().ok().and_then(|real| loaded.get(&real)) {
            let found = &known.info.sha256;
            return match sha256.filter(|sha256| !sha256.eq_ignore_ascii_case(found)) {
                None => Ok(known.clone()),
                Some(expected) => {
                    let (found, expected) = (found.clone(), expected.to_owned());
                    Err(wrong(FileError::Checksum { found, expected }.into()))
                }
            };
        }
        let checked = file::check(path, sha256).map_err(|e| wrong(e.into()))?;
        let system = |e: libloading::Error| {
            // The error's own words are only "dlopen failed"; what is behind it names the missing file or symbol.
            let why = std::error::Error::source(&e).map_or_else(|| e.to_string(), ToString::to_string);
            wrong(LoadReason::System(why))
        };
        // SAFETY: loading runs the constructors of the library: this is why only files are loaded that the user named.
        let library = unsafe { opened_now(&checked.path) }.map_err(system)?;
        // SAFETY: the ABI says which type the symbol has.
        let function = unsafe { library.get::<EntryFunction>(RUMBO_ENTRY) }.map_err(system)?;
        let function: EntryFunction = *function;
        // Never unloaded: its threads, thread-locals and statics may outlive every instance.
        std::mem::forget(library);
        // SAFETY: a function of the library that was just loaded.
        let opened = unsafe { Library::made(function, checked.path, checked.sha256) };
        let opened = Arc::new(opened.map_err(|e| wrong(e.into()))?);
        loaded.insert(opened.info.path.clone(), opened.clone());
        Ok(opened)
    }

    /// This program loads no libraries.
    #[cfg(not(feature = "host"))]
    pub fn open(path: &Path, _: Option<&str>) -> Result<Arc<Library>, LoadError> {
        let reason = LoadReason::System("this program was built without the feature `host`".to_owned());
        Err(LoadError { path: path.to_path_buf(), reason })
    }

    /// As if a library with this entry function had been loaded: for tests of both sides in one program.
    ///
    /// # Safety
    /// The function keeps the promises of the ABI.
    #[doc(hidden)]
    pub unsafe fn of_function(function: EntryFunction, origin: &str) -> Result<Library, ModuleError> {
        // SAFETY: as promised by the caller.
        unsafe { Library::made(function, PathBuf::from(origin), String::new()) }
    }

    /// # Safety
    /// The function keeps the promises of the ABI.
    unsafe fn made(function: EntryFunction, path: PathBuf, sha256: String) -> Result<Library, ModuleError> {
        // SAFETY: as promised by the caller; the host table lives as long as the program.
        let module = unsafe { function(&raw const HOST) };
        // SAFETY: what the entry function returned.
        let (info, records) = unsafe { records(module)? };
        let info = Arc::new(LibraryInfo { path, sha256, abi: info.abi, build_info: info.build_info });
        let entries = records.into_iter().map(|record| Arc::new(entry(record, &info))).collect();
        Ok(Library { info, entries })
    }
}
