//! What can be wrong with a depth picture, each with the way out.

use std::path::PathBuf;

use thiserror::Error;

/// Why a depth picture could not be read or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DepthFileError {
    /// The file is missing or cannot be read.
    #[error("{}: cannot read the depth picture: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// There is not one byte in it.
    #[error("{}: the file is empty, expected a depth picture (PNG or PGM)", path.display())]
    Empty {
        /// The file.
        path: PathBuf,
    },
    /// Its first bytes belong to no format that we read.
    #[error("{}: begins with {found:?}, expected a PNG or a binary PGM (P5)", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// Its first bytes as text.
        found: String,
    },
    /// It is a picture of another kind.
    #[error("{}: is {found}, expected {expected}", path.display())]
    Kind {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: String,
        /// What the encoding needs.
        expected: &'static str,
    },
    /// It has no pixels, or more than any depth camera.
    #[error("{}: is {width} x {height} pixels, expected 1 x 1 to {most} pixels in all", path.display())]
    Size {
        /// The file.
        path: PathBuf,
        /// Columns its header says.
        width: u64,
        /// Rows its header says.
        height: u64,
        /// The limit.
        most: u64,
    },
    /// Its header or its data cannot be decoded.
    #[error("{}: broken picture: {reason}; copy the file again", path.display())]
    Broken {
        /// The file.
        path: PathBuf,
        /// What the decoder met.
        reason: String,
    },
    /// It ends before its last pixel.
    #[error("{}: ends after {found} of {expected} pixels; the file is cut off, copy it again", path.display())]
    Truncated {
        /// The file.
        path: PathBuf,
        /// Pixels that were there.
        found: u64,
        /// Pixels that the header promises.
        expected: u64,
    },
    /// A count that the encoding does not have.
    #[error("{}: column {column}, row {row}: {what} is {found}, expected at most {most}", path.display())]
    Count {
        /// The file.
        path: PathBuf,
        /// Column of the first such pixel.
        column: usize,
        /// Row, from the top.
        row: usize,
        /// Which number of the pixel.
        what: &'static str,
        /// What it is.
        found: u16,
        /// The largest one possible.
        most: u16,
    },
    /// A picture in memory does not fit its size or encoding, so it was not written.
    #[error("{}: not written: {reason}", path.display())]
    Inconsistent {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        reason: String,
    },
    /// It could not be written.
    #[error("{}: cannot write the depth picture: {reason}", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}
