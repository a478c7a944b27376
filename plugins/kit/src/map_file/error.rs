//! What can be wrong with a map file, each with the way out.

use std::path::PathBuf;

use thiserror::Error;

/// Why a map could not be loaded or saved.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MapFileError {
    /// The YAML file is missing or cannot be read.
    #[error("{}: cannot read the map file: {source}; give the path of a map_server YAML file", path.display())]
    Unreadable {
        /// The YAML file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file is not YAML, a key is missing, or a value has the wrong type.
    #[error("{}: not a map_server YAML file: {message}; expected image, resolution and origin", path.display())]
    Header {
        /// The YAML file.
        path: PathBuf,
        /// The parser's message, with line and column where it knows them.
        message: String,
    },
    /// A value of the header is out of its range.
    #[error("{}: {key} is {found}, expected {expected}", path.display())]
    Value {
        /// The YAML file.
        path: PathBuf,
        /// The key at fault.
        key: &'static str,
        /// The value it has.
        found: String,
        /// What would be right.
        expected: &'static str,
    },
    /// The picture is missing or cannot be read.
    #[error("{}: cannot read the map's picture: {source}; the key image is relative to the YAML file", path.display())]
    ImageUnreadable {
        /// The picture.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The picture's first bytes belong to no format we read.
    #[error("{}: the picture begins with {found:?}, expected a gray PGM (P2 or P5) or a PNG; convert it", path.display())]
    ImageFormat {
        /// The picture.
        path: PathBuf,
        /// Its first bytes as text.
        found: String,
    },
    /// The picture's own header or data cannot be decoded.
    #[error("{}: broken picture: {message}; save it again as PGM or PNG", path.display())]
    ImageBroken {
        /// The picture.
        path: PathBuf,
        /// What the decoder met.
        message: String,
    },
    /// The picture ends before its last cell.
    #[error(
        "{}: the picture ends after {found} of {expected} cells; the file is truncated, copy it again",
        path.display()
    )]
    ImageTruncated {
        /// The picture.
        path: PathBuf,
        /// Cells that were there.
        found: u64,
        /// Cells that the header promises.
        expected: u64,
    },
    /// The picture has no cells.
    #[error("{}: the picture is {width} x {height} cells, expected at least 1 x 1", path.display())]
    ImageEmpty {
        /// The picture.
        path: PathBuf,
        /// Columns its header says.
        width: u64,
        /// Lines its header says.
        height: u64,
    },
    /// The picture's header says more cells than the limit allows.
    #[error(
        "{}: the picture is {width} x {height} = {} cells, more than max_cells = {max_cells}; \
         crop or scale the map, or raise max_cells",
        path.display(), u128::from(*width) * u128::from(*height)
    )]
    TooLarge {
        /// The picture.
        path: PathBuf,
        /// Columns its header says.
        width: u64,
        /// Lines its header says.
        height: u64,
        /// The limit in force.
        max_cells: u64,
    },
    /// A file could not be written.
    #[error("{}: cannot write the map: {source}; choose a folder that exists and can be written", path.display())]
    Unwritable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// No shade stands for the value of some cells.
    #[error(
        "{}: in mode {mode} no shade of this picture is read as {}, the value of {n_cells} cells; nothing was written; \
         save as PNG, in mode raw, or with other thresholds",
        path.display(), said(*occupancy)
    )]
    Unsayable {
        /// The picture.
        path: PathBuf,
        /// The value, in percent.
        occupancy: i8,
        /// Cells that have it.
        n_cells: usize,
        /// The mode asked for.
        mode: &'static str,
    },
    /// The grid in memory does not hold as many cells as it says.
    #[error("the grid says {width} x {height} cells and holds {found}; nothing was written")]
    Inconsistent {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Cells in the array.
        found: usize,
    },
}

fn said(occupancy: i8) -> String {
    if occupancy < 0 { "unknown".to_owned() } else { format!("{occupancy} percent") }
}
