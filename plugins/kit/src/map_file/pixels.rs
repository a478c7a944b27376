//! The picture half: gray PGM (P2, P5) and PNG, with the size checked before anything of that size is allocated.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek};
use std::path::Path;

use image::{DynamicImage, ImageDecoder, codecs::png::PngDecoder};

use super::MapFileError;

/// A picture as shades from 0 (black) to 1 (white), line 0 at the top.
pub(super) struct Shades {
    pub width: usize,
    pub height: usize,
    pub shade: Vec<f32>,
    /// False where the picture is transparent; `None` for a picture without an alpha channel.
    pub opaque: Option<Vec<bool>>,
}

pub(super) fn load(path: &Path, max_cells: u64) -> Result<Shades, MapFileError> {
    let unreadable = |source| MapFileError::ImageUnreadable { path: path.to_path_buf(), source };
    let mut file = BufReader::new(File::open(path).map_err(unreadable)?);
    let start = file.fill_buf().map_err(unreadable)?;
    match start {
        [b'P', b'2', ..] => load_pgm(path, &mut file, max_cells, false),
        [b'P', b'5', ..] => load_pgm(path, &mut file, max_cells, true),
        [0x89, b'P', b'N', b'G', ..] => load_png(path, file, max_cells),
        _ => {
            let found = String::from_utf8_lossy(&start[..start.len().min(4)]).into_owned();
            Err(MapFileError::ImageFormat { path: path.to_path_buf(), found })
        }
    }
}

fn check_size(path: &Path, width: u64, height: u64, max_cells: u64) -> Result<(), MapFileError> {
    let path = path.to_path_buf();
    if width == 0 || height == 0 {
        return Err(MapFileError::ImageEmpty { path, width, height });
    }
    match width.checked_mul(height) {
        Some(cells) if cells <= max_cells => Ok(()),
        _ => Err(MapFileError::TooLarge { path, width, height, max_cells }),
    }
}

/// Netpbm's PGM: "P5" or "P2", width, height, largest value, one white space, then the samples.
fn load_pgm(
    path: &Path,
    file: &mut impl BufRead,
    max_cells: u64,
    binary: bool,
) -> Result<Shades, MapFileError> {
    let broken = |message: String| MapFileError::ImageBroken { path: path.to_path_buf(), message };
    let mut magic = [0; 2];
    file.read_exact(&mut magic).map_err(|error| broken(error.to_string()))?;
    let mut number = |what: &str| match next_number(file) {
        Ok(Some(number)) => Ok(number),
        Ok(None) => Err(broken(format!("the PGM header ends before its {what}"))),
        Err(found) => Err(broken(format!("the {what} of the PGM header is {found:?}, expected a number"))),
    };
    let (width, height) = (number("width")?, number("height")?);
    check_size(path, width, height, max_cells)?;
    let largest = number("largest value")?;
    if !(1..=65535).contains(&largest) {
        return Err(broken(format!("the largest value of the PGM header is {largest}, expected 1 to 65535")));
    }
    let n_cells = width * height;
    let truncated =
        |found| MapFileError::ImageTruncated { path: path.to_path_buf(), found, expected: n_cells };
    let mut shade = Vec::new();
    if binary {
        let bytes_per_cell = if largest > 255 { 2 } else { 1 };
        let mut bytes = Vec::new();
        let read = file.take(n_cells * bytes_per_cell).read_to_end(&mut bytes);
        read.map_err(|source| MapFileError::ImageUnreadable { path: path.to_path_buf(), source })?;
        if (bytes.len() as u64) < n_cells * bytes_per_cell {
            return Err(truncated(bytes.len() as u64 / bytes_per_cell));
        }
        let scale = 1.0 / largest as f32;
        match bytes_per_cell {
            1 => shade.extend(bytes.iter().map(|&value| f32::from(value) * scale)),
            _ => shade.extend(
                bytes.chunks_exact(2).map(|pair| f32::from(u16::from_be_bytes([pair[0], pair[1]])) * scale),
            ),
        }
    } else {
        for found in 0..n_cells {
            match next_number(file) {
                Ok(Some(value)) => shade.push(value.min(largest) as f32 / largest as f32),
                Ok(None) => return Err(truncated(found)),
                Err(token) => return Err(broken(format!("value {found} of the picture is {token:?}"))),
            }
        }
    }
    Ok(Shades { width: width as usize, height: height as usize, shade, opaque: None })
}

/// The next number of a Netpbm header, past white space and `#` comments; consumes one byte after it.
/// `Ok(None)` at the end of the file, `Err` with the text when it is no number.
pub(crate) fn next_number(file: &mut impl BufRead) -> Result<Option<u64>, String> {
    let mut token = String::new();
    let mut in_comment = false;
    while let Some(byte) = next_byte(file) {
        match byte {
            b'\n' | b'\r' if in_comment => in_comment = false,
            _ if in_comment => {}
            b'#' if token.is_empty() => in_comment = true,
            _ if byte.is_ascii_whitespace() && token.is_empty() => {}
            _ if byte.is_ascii_whitespace() => break,
            // Longer than any number, so binary rubbish is not collected to its end.
            _ if token.len() > 20 => return Err(token),
            _ => token.push(char::from(byte)),
        }
    }
    if token.is_empty() { Ok(None) } else { token.parse().map(Some).map_err(|_| token) }
}

fn next_byte(file: &mut impl BufRead) -> Option<u8> {
    let byte = *file.fill_buf().ok()?.first()?;
    file.consume(1);
    Some(byte)
}

fn load_png(path: &Path, file: impl BufRead + Seek, max_cells: u64) -> Result<Shades, MapFileError> {
    let broken = |error: image::ImageError| MapFileError::ImageBroken {
        path: path.to_path_buf(),
        message: error.to_string(),
    };
    let decoder = PngDecoder::new(file).map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(path, u64::from(width), u64::from(height), max_cells)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let color = picture.color();
    let opaque = color
        .has_alpha()
        .then(|| picture.to_rgba8().pixels().map(|pixel| pixel.0[3] == u8::MAX).collect::<Vec<_>>());
    let shade = if color.bytes_per_pixel() > 4 || color == image::ColorType::L16 {
        gray(picture.to_rgb16().pixels().map(|pixel| pixel.0.map(|channel| f32::from(channel) / 65535.0)))
    } else {
        gray(picture.to_rgb8().pixels().map(|pixel| pixel.0.map(|channel| f32::from(channel) / 255.0)))
    };
    Ok(Shades { width: width as usize, height: height as usize, shade, opaque })
}

/// map_server averages the channels; it does not weigh them by brightness.
fn gray(pixels: impl Iterator<Item = [f32; 3]>) -> Vec<f32> {
    pixels
        .map(
            |[red, green, blue]| if red == green && green == blue { red } else { (red + green + blue) / 3.0 },
        )
        .collect()
}
