//! What can be wrong with a file of poses, each with the way out.

use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::log_file::{LineFault, LogError};

/// Why a trajectory, a file of stamps or a file of relations cannot be read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum TrajectoryError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot read the file: {source}; give the path of a trajectory, plain or gzip", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A folder stands where a file is expected.
    #[error("{}: is a folder, expected a file of poses", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
    },
    /// There is nothing in it that says anything.
    #[error("{}: {found}, expected {expected}", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
        /// What was found instead.
        found: String,
        /// What a line should look like.
        expected: String,
    },
    /// The first line of numbers is of no format that we know.
    #[error(
        "{}:{line}: the line has {n_words} words, expected 4 (t x y theta), 8 (t tx ty tz qx qy qz qw) or 12 (KITTI); \
         if it is one of these with more behind it, name the format",
        path.display()
    )]
    UnknownFormat {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// Words in it.
        n_words: usize,
    },
    /// A line cannot be read.
    #[error(
        "{}:{}: {} is {}, expected {}; correct or remove the line, or name the format if this is not {format}",
        path.display(), fault.line, fault.field, fault.found, fault.expected
    )]
    Line {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        fault: Box<LineFault>,
        /// The format it was taken for.
        format: &'static str,
    },
    /// The file of stamps does not belong to the file of poses.
    #[error(
        "{}: {n_stamps} stamps for the {n_poses} poses of {}, expected one a pose; give the times file of the same \
         sequence",
        times.display(), path.display()
    )]
    Times {
        /// The poses.
        path: PathBuf,
        /// The stamps.
        times: PathBuf,
        /// Stamps found.
        n_stamps: usize,
        /// Lines of poses found.
        n_poses: usize,
    },
}

impl TrajectoryError {
    /// The trouble of the line reader, said of poses rather than of a log.
    pub(crate) fn of_lines(error: LogError, expected: &str) -> TrajectoryError {
        let expected = expected.to_owned();
        match error {
            LogError::Unreadable { path, source } => TrajectoryError::Unreadable { path, source },
            LogError::Folder { path } => TrajectoryError::Folder { path },
            LogError::Empty { path } => {
                TrajectoryError::Empty { path, found: "the file is empty".to_owned(), expected }
            }
            LogError::NoRecords { path, found, expected } => {
                let found = format!("no record found: {found}");
                TrajectoryError::Empty { path, found, expected: expected.to_owned() }
            }
        }
    }

    pub(crate) fn of_line(path: &Path, fault: LineFault, format: &'static str) -> TrajectoryError {
        TrajectoryError::Line { path: path.to_owned(), fault: Box::new(fault), format }
    }
}
