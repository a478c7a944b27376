//! What is wrong with a world file, and where.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

/// One fault of a world file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WorldFault {
    /// Line, counted from 1.
    pub line: usize,
    /// Column, counted from 1 in characters.
    pub column: usize,
    /// Full key, such as `wall[2].height_m`; empty for a fault of the syntax.
    pub key: String,
    /// What was found, what was expected.
    pub message: String,
    /// Byte range in the file's text.
    pub span: std::ops::Range<usize>,
}

impl fmt::Display for WorldFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { line, column, key, message, .. } = self;
        if key.is_empty() {
            write!(f, "{line}:{column} {message}")
        } else {
            write!(f, "{line}:{column} {key}: {message}")
        }
    }
}

/// Why a world file could not be loaded.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WorldFileError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot read the world file: {source}; give a TOML world file or a map_server YAML file", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file was read; these are all its faults.
    #[error("{}", listed(path, faults))]
    Faults {
        /// The file.
        path: PathBuf,
        /// Every fault, in the order of the lines.
        faults: Vec<WorldFault>,
    },
}

fn listed(path: &std::path::Path, faults: &[WorldFault]) -> String {
    faults.iter().map(|fault| format!("{}:{fault}", path.display())).collect::<Vec<_>>().join("\n")
}
