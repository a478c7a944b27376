//! Writing depth pictures.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

use super::DepthFileError;
use super::picture::{DepthEncoding, DepthPicture, MOST_PIXELS};
use super::png::MOST_RED;

/// Writes a picture: PGM where the name ends in `.pgm`, else PNG.
///
/// # Errors
/// [`DepthFileError::Inconsistent`] for counts that are not as many as the size says, do not fit the encoding, or are more
/// than [`read_depth`](super::read_depth) would read; [`DepthFileError::Unwritable`] for what the system says.
pub fn write_depth(
    path: &Path,
    encoding: DepthEncoding,
    picture: &DepthPicture,
) -> Result<(), DepthFileError> {
    let inconsistent = |reason: String| DepthFileError::Inconsistent { path: path.to_owned(), reason };
    let DepthPicture { width, height, counts } = picture;
    let n_pixels = u64::from(*width) * u64::from(*height);
    if counts.len() as u64 != n_pixels || !(1..=MOST_PIXELS).contains(&n_pixels) {
        return Err(inconsistent(format!("{width} x {height} pixels, but {} counts", counts.len())));
    }
    let is_pgm = path.extension().is_some_and(|ending| ending == "pgm");
    let most = u16::from_be_bytes([MOST_RED, u8::MAX]);
    let too_large = counts.iter().find(|count| encoding == DepthEncoding::TwoChannel && **count > most);
    if let Some(count) = too_large {
        return Err(inconsistent(format!("a count is {count}, two channels hold at most {most}")));
    }
    if is_pgm && encoding == DepthEncoding::TwoChannel {
        return Err(inconsistent("a PGM has one channel only".to_owned()));
    }
    let unwritable = |reason: String| DepthFileError::Unwritable { path: path.to_owned(), reason };
    let file = File::create(path).map_err(|error| unwritable(error.to_string()))?;
    let mut file = BufWriter::new(file);
    if is_pgm {
        let written = write!(file, "P5\n{width} {height}\n65535\n")
            .and_then(|()| counts.iter().try_for_each(|count| file.write_all(&count.to_be_bytes())));
        written.map_err(|error| unwritable(error.to_string()))?;
    } else {
        let (bytes, color): (Vec<u8>, _) = match encoding {
            // The encoder takes the order of this machine and writes that of PNG.
            DepthEncoding::Gray16 => {
                (counts.iter().flat_map(|count| count.to_ne_bytes()).collect(), ExtendedColorType::L16)
            }
            DepthEncoding::TwoChannel => {
                let pixel = |count: &u16| {
                    let [red, green] = count.to_be_bytes();
                    [red, green, 0]
                };
                (counts.iter().flat_map(pixel).collect(), ExtendedColorType::Rgb8)
            }
        };
        let encoder = PngEncoder::new_with_quality(&mut file, CompressionType::Best, FilterType::Adaptive);
        let written = encoder.write_image(&bytes, *width, *height, color);
        written.map_err(|error| unwritable(error.to_string()))?;
    }
    file.flush().map_err(|error| unwritable(error.to_string()))
}
