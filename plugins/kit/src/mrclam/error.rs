//! Why a folder cannot be used.

use std::path::PathBuf;

use thiserror::Error;

use crate::log_file::{Damage, LineFault, LogError};

/// Why a folder of a data set cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MrclamError {
    /// There is no such folder.
    #[error("{}: there is no such folder", folder.display())]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// A table is not there.
    #[error("{}: there is neither {name} nor {name}.gz", folder.display())]
    Missing {
        /// The folder.
        folder: PathBuf,
        /// Its name.
        name: String,
    },
    /// A table cannot be read at all.
    #[error(transparent)]
    Unreadable(#[from] LogError),
    /// A line of a table that must be whole.
    #[error("{}: {fault}", path.display())]
    Line {
        /// The table.
        path: PathBuf,
        /// What is wrong with it.
        fault: LineFault,
    },
    /// A table that must be whole ends too early.
    #[error("{}: {damage}; this table must be whole", path.display())]
    Damaged {
        /// The table.
        path: PathBuf,
        /// Where.
        damage: Damage,
    },
    /// A number that must be there once.
    #[error("{}: line {line}: {what} is there twice, first in line {first}", path.display())]
    Twice {
        /// The table.
        path: PathBuf,
        /// The second time.
        line: u64,
        /// The first time.
        first: u64,
        /// Which number.
        what: String,
    },
    /// A table without one row that can be read.
    #[error("{}: no row can be read{why}; expected lines of `{expected}`", path.display())]
    Empty {
        /// The table.
        path: PathBuf,
        /// What is wrong with the first line, if there is one.
        why: String,
        /// What a row should be.
        expected: &'static str,
    },
}
