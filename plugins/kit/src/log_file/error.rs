//! What can be wrong with a log: the file as a whole, one of its lines, its end.

use std::fmt;
use std::path::PathBuf;

use thiserror::Error;

/// Why a log cannot be opened.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LogError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot read the log: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A folder stands where a file is expected.
    #[error("{}: is a folder, expected a file", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// There is not one byte in it.
    #[error("{}: the file is empty, expected a robot log", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// No line near its beginning is of a known format.
    #[error("{}: no record found: {found}; expected {expected}, plain or gzip", path.display())]
    NoRecords {
        /// The file.
        path: PathBuf,
        /// What was found instead.
        found: String,
        /// Formats that would be understood.
        expected: &'static str,
    },
}

/// Why a line was skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum FaultKind {
    /// The line ends before its last field.
    TooFewFields,
    /// The line has another number of fields than its count announces.
    CountDiffers,
    /// A count of beams that no device has.
    ImpossibleCount,
    /// A word where a number is expected.
    NotANumber,
    /// A pose, velocity or stamp that is infinite, not-a-number or absurdly large.
    NotFinite,
    /// A range below zero, or an angle that cannot be.
    OutOfRange,
    /// The line does not end.
    LineTooLong,
}

impl FaultKind {
    /// The words used in messages.
    pub fn name(self) -> &'static str {
        match self {
            FaultKind::TooFewFields => "too few fields",
            FaultKind::CountDiffers => "a count that disagrees",
            FaultKind::ImpossibleCount => "an impossible count",
            FaultKind::NotANumber => "no number",
            FaultKind::NotFinite => "a number that is not finite",
            FaultKind::OutOfRange => "a number out of its range",
            FaultKind::LineTooLong => "a line without end",
        }
    }
}

/// One line that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineFault {
    /// Number of the line, from 1.
    pub line: u64,
    /// The reason in a word, to count by.
    pub kind: FaultKind,
    /// Which field, such as `FLASER.ranges[17]`.
    pub field: String,
    /// What stands there.
    pub found: String,
    /// What should.
    pub expected: String,
}

impl fmt::Display for LineFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {} is {}, expected {}", self.line, self.field, self.found, self.expected)
    }
}

/// Where a file stops making sense; nothing behind it was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damage {
    /// The line in which it happens, from 1.
    pub line: u64,
    /// The file is cut off, rather than changed.
    pub is_truncated: bool,
    /// What was met.
    pub found: String,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = if self.is_truncated { "the file is cut off" } else { "the file is damaged" };
        write!(f, "line {}: {what}: {}; what comes before was read", self.line, self.found)
    }
}
