//! Netpbm's PGM of 16 bits: "P5", width, height, largest value, one white space, then the counts, high byte first.

use std::io::{BufRead, Read};
use std::path::Path;

use super::DepthFileError;
use super::picture::{DepthPicture, checked_size};
use crate::map_file::pixels::next_number;

/// Reads a picture from the start of its file.
pub(super) fn read(path: &Path, file: &mut impl BufRead) -> Result<DepthPicture, DepthFileError> {
    let unreadable = |source| DepthFileError::Unreadable { path: path.to_owned(), source };
    let broken = |reason: String| DepthFileError::Broken { path: path.to_owned(), reason };
    file.read_exact(&mut [0; 2]).map_err(unreadable)?;
    let mut number = |what: &str| match next_number(file) {
        Ok(Some(number)) => Ok(number),
        Ok(None) => Err(broken(format!("the PGM header ends before its {what}"))),
        Err(found) => Err(broken(format!("the {what} of the PGM header is {found:?}, expected a number"))),
    };
    let (width, height) = (number("width")?, number("height")?);
    let (width, height) = checked_size(path, width, height)?;
    let most = match u16::try_from(number("largest value")?) {
        Ok(most @ 256..) => most,
        found => {
            let found = found.map_or("more than 65535".to_owned(), |most| most.to_string());
            let found = format!("a PGM whose largest value is {found}");
            let expected = "256 to 65535: two bytes a pixel";
            return Err(DepthFileError::Kind { path: path.to_owned(), found, expected });
        }
    };
    let n_pixels = u64::from(width) * u64::from(height);
    let mut bytes = Vec::new();
    file.take(2 * n_pixels).read_to_end(&mut bytes).map_err(unreadable)?;
    let counts: Vec<u16> =
        bytes.as_chunks().0.iter().map(|pair: &[u8; 2]| u16::from_be_bytes(*pair)).collect();
    if (counts.len() as u64) < n_pixels {
        let (found, expected) = (counts.len() as u64, n_pixels);
        return Err(DepthFileError::Truncated { path: path.to_owned(), found, expected });
    }
    if let Some((idx, found)) = counts.iter().enumerate().find(|(_, count)| **count > most) {
        let (column, row) = (idx % width as usize, idx / width as usize);
        let (path, found, what) = (path.to_owned(), *found, "the count");
        return Err(DepthFileError::Count { path, column, row, what, found, most });
    }
    Ok(DepthPicture { width, height, counts })
}
