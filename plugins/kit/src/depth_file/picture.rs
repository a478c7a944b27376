//! A picture in memory, and which reader a file needs.

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::DepthFileError;
use super::{pgm, png};

/// How depth stands in the pixels of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DepthEncoding {
    /// One channel of 16 bits: PNG, or binary PGM (P5).
    #[default]
    Gray16,
    /// PNG with 13 bits in two channels of 8: 256 times the red one (at most 31) plus the green one; blue says nothing.
    TwoChannel,
}

/// A depth picture, row 0 on top.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct DepthPicture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Counts, row by row; 0 is no reading.
    pub counts: Vec<u16>,
}

/// No depth camera has more pixels; a header that says so is damage.
pub(super) const MOST_PIXELS: u64 = 1 << 24;

/// Reads a depth picture; nothing of the size that the header says is allocated before that size was looked at.
///
/// # Errors
/// [`DepthFileError`], which names the file, what was found and what was expected.
pub fn read_depth(path: &Path, encoding: DepthEncoding) -> Result<DepthPicture, DepthFileError> {
    let unreadable = |source| DepthFileError::Unreadable { path: path.to_owned(), source };
    let file = File::open(path).map_err(unreadable)?;
    if !file.metadata().map_err(unreadable)?.is_file() {
        return Err(unreadable(std::io::Error::other("this is not a file")));
    }
    let mut file = BufReader::new(file);
    let start = file.fill_buf().map_err(unreadable)?;
    match start {
        [] => Err(DepthFileError::Empty { path: path.to_owned() }),
        [0x89, b'P', b'N', b'G', ..] => png::read(path, file, encoding),
        [b'P', b'5', ..] if encoding == DepthEncoding::Gray16 => pgm::read(path, &mut file),
        [b'P', b'5', ..] => Err(DepthFileError::Kind {
            path: path.to_owned(),
            found: "a PGM, which has one channel".to_owned(),
            expected: "a PNG with a red and a green channel of 8 bits",
        }),
        _ => {
            let found = String::from_utf8_lossy(start.get(..4).unwrap_or(start)).into_owned();
            Err(DepthFileError::Format { path: path.to_owned(), found })
        }
    }
}

/// The size of a picture, if it can be one.
pub(super) fn checked_size(path: &Path, width: u64, height: u64) -> Result<(u32, u32), DepthFileError> {
    let n_pixels = width.checked_mul(height).filter(|n| (1..=MOST_PIXELS).contains(n));
    let sides = n_pixels.and_then(|_| Some((u32::try_from(width).ok()?, u32::try_from(height).ok()?)));
    sides.ok_or_else(|| DepthFileError::Size { path: path.to_owned(), width, height, most: MOST_PIXELS })
}
