//! PNG of 16 bits, and PNG with 13 bits in two channels.

use std::io::{BufRead, Seek};
use std::path::Path;

use image::codecs::png::PngDecoder;
use image::{ColorType, DynamicImage, ImageDecoder};

use super::DepthFileError;
use super::picture::{DepthEncoding, DepthPicture, checked_size};

/// Five bits in the red channel.
pub(super) const MOST_RED: u8 = 31;

/// Reads a picture from the start of its file.
pub(super) fn read(
    path: &Path,
    file: impl BufRead + Seek,
    encoding: DepthEncoding,
) -> Result<DepthPicture, DepthFileError> {
    let broken = |error: image::ImageError| DepthFileError::Broken {
        path: path.to_owned(),
        reason: error.to_string(),
    };
    let decoder = PngDecoder::new(file).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = checked_size(path, width.into(), height.into())?;
    let color = decoder.color_type();
    let fits = match encoding {
        DepthEncoding::Gray16 => color == ColorType::L16,
        DepthEncoding::TwoChannel => matches!(color, ColorType::Rgb8 | ColorType::Rgba8),
    };
    if !fits {
        return Err(wrong_kind(path, color, encoding));
    }
    let counts = match DynamicImage::from_decoder(decoder).map_err(broken)? {
        DynamicImage::ImageLuma16(picture) => picture.into_raw(),
        picture => {
            let picture = picture.into_rgb8();
            let counts: Result<Vec<u16>, DepthFileError> =
                picture.enumerate_pixels().map(|(x, y, pixel)| joined(path, x, y, pixel.0)).collect();
            counts?
        }
    };
    Ok(DepthPicture { width, height, counts })
}

/// Equation 5.1 of the source: raw = 256 red + green.
fn joined(path: &Path, x: u32, y: u32, [red, green, _]: [u8; 3]) -> Result<u16, DepthFileError> {
    if red <= MOST_RED {
        return Ok(u16::from_be_bytes([red, green]));
    }
    let (column, row, what) = (x as usize, y as usize, "the red channel");
    let (path, found, most) = (path.to_owned(), red.into(), MOST_RED.into());
    Err(DepthFileError::Count { path, column, row, what, found, most })
}

fn wrong_kind(path: &Path, color: ColorType, encoding: DepthEncoding) -> DepthFileError {
    let n_channels = color.channel_count();
    let n_bits = color.bits_per_pixel() / u16::from(n_channels);
    let channels = if n_channels == 1 { "one channel".to_owned() } else { format!("{n_channels} channels") };
    DepthFileError::Kind {
        path: path.to_owned(),
        found: format!("a PNG with {channels} of {n_bits} bits"),
        expected: match encoding {
            DepthEncoding::Gray16 => "one channel of 16 bits (encoding gray16)",
            DepthEncoding::TwoChannel => "red and green channels of 8 bits (encoding two_channel)",
        },
    }
}
