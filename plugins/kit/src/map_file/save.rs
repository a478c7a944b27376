//! Writes a grid as a map_server YAML file and a picture beside it.

use std::path::Path;

use image::ImageEncoder as _;

use super::ink::{Ink, palette, place};
use super::{MapFileError, MapImage, MapMode, ShadeReading};

/// What the written file keeps of the occupancy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SavedAs {
    /// Occupied, free, unknown: what every tool reads (above 65 percent occupied, below 20 free).
    Trinary,
    /// Every percent, in map_server's `scale` mode. Unknown cells are transparent there, which only PNG can say.
    Scale,
    /// Every percent, in map_server's `raw` mode.
    Raw,
}

/// Format of the written picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFormat {
    /// What every tool reads.
    Pgm,
    /// A hundredth of the size.
    Png,
}

impl SavedAs {
    /// The keys that are written. The threshold of `scale` is itself a gray: only a shade exactly there is read as 99
    /// percent.
    fn reading(self) -> ShadeReading {
        const GRAY_OF_99_PERCENT: f64 = 166.0 / 255.0;
        match self {
            SavedAs::Trinary => ShadeReading::usual(MapMode::Trinary),
            SavedAs::Raw => ShadeReading::usual(MapMode::Raw),
            SavedAs::Scale => {
                ShadeReading { occupied_thresh: GRAY_OF_99_PERCENT, ..ShadeReading::usual(MapMode::Scale) }
            }
        }
    }

    /// What is kept of a cell.
    fn kept(self, cell: i8) -> i8 {
        match (self, cell) {
            (SavedAs::Trinary, 66..) => 100,
            (SavedAs::Trinary, 0..20) => 0,
            (SavedAs::Trinary, _) => super::UNKNOWN,
            (SavedAs::Scale | SavedAs::Raw, _) => cell,
        }
    }
}

/// Writes `yaml` and a picture of the same name beside it; the pair loads back to the same grid.
///
/// # Errors
/// [`MapFileError::Unwritable`]; [`MapFileError::Inconsistent`] when the grid is not `width * height` cells;
/// [`MapFileError::Unsayable`] for unknown cells in `scale` mode as PGM.
pub fn save_map(
    yaml: &Path,
    map: &MapImage,
    saved_as: SavedAs,
    format: PictureFormat,
) -> Result<(), MapFileError> {
    let cells = map.cells.iter().map(|cell| saved_as.kept(*cell)).collect();
    save_map_to_be_read(yaml, &MapImage { cells, ..*map }, &saved_as.reading(), format)
}

/// [`save_map`] with keys of the caller's choice, such as those of the file that the map came from.
///
/// # Errors
/// As [`save_map`]; [`MapFileError::Unsayable`] when no shade is read as the value of some cell.
pub fn save_map_to_be_read(
    yaml: &Path,
    map: &MapImage,
    reading: &ShadeReading,
    format: PictureFormat,
) -> Result<(), MapFileError> {
    if map.cells.len() != map.width * map.height || map.cells.is_empty() {
        return Err(MapFileError::Inconsistent {
            width: map.width,
            height: map.height,
            found: map.cells.len(),
        });
    }
    let picture = yaml.with_extension(match format {
        PictureFormat::Pgm => "pgm",
        PictureFormat::Png => "png",
    });
    let pixels = pixels(map, reading, format, &picture)?;
    let bytes = match format {
        PictureFormat::Pgm => pgm(map, &pixels),
        PictureFormat::Png => png(map, &pixels).map_err(|error| MapFileError::Unwritable {
            path: picture.clone(),
            source: std::io::Error::other(error),
        })?,
    };
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    let header = header(&name, map, reading);
    for (path, content) in [(picture.as_path(), bytes.as_slice()), (yaml, header.as_bytes())] {
        std::fs::write(path, content)
            .map_err(|source| MapFileError::Unwritable { path: path.to_path_buf(), source })?;
    }
    Ok(())
}

fn header(image: &str, map: &MapImage, reading: &ShadeReading) -> String {
    let [x, y, yaw] = map.origin;
    let mode = reading.mode.name();
    let &ShadeReading { negate, occupied_thresh, free_thresh, .. } = reading;
    // {:?} prints the shortest text that reads back to the same number.
    format!(
        "image: {image}\nmode: {mode}\nresolution: {:?}\norigin: [{x:?}, {y:?}, {yaw:?}]\nnegate: {}\n\
         occupied_thresh: {occupied_thresh:?}\nfree_thresh: {free_thresh:?}\n",
        map.resolution_m,
        u8::from(negate)
    )
}

/// The picture's pixels, its top line first.
fn pixels(
    map: &MapImage,
    reading: &ShadeReading,
    format: PictureFormat,
    picture: &Path,
) -> Result<Vec<Ink>, MapFileError> {
    let palette = palette(reading, format == PictureFormat::Png);
    let unsayable = |cell: i8| MapFileError::Unsayable {
        path: picture.to_path_buf(),
        occupancy: cell,
        n_cells: map.cells.iter().filter(|other| place(**other) == place(cell)).count(),
        mode: reading.mode.name(),
    };
    let rows = map.cells.chunks_exact(map.width).rev();
    let ink = |cell: &i8| palette.get(place(*cell)).copied().flatten().ok_or_else(|| unsayable(*cell));
    rows.flatten().map(ink).collect()
}

fn pgm(map: &MapImage, pixels: &[Ink]) -> Vec<u8> {
    let mut bytes = format!("P5\n{} {}\n255\n", map.width, map.height).into_bytes();
    bytes.extend(pixels.iter().map(|ink| ink.gray));
    bytes
}

fn png(map: &MapImage, pixels: &[Ink]) -> Result<Vec<u8>, image::ImageError> {
    let (samples, color): (Vec<u8>, _) = if pixels.iter().all(|ink| ink.is_opaque) {
        (pixels.iter().map(|ink| ink.gray).collect(), image::ExtendedColorType::L8)
    } else {
        let alpha = |ink: &Ink| if ink.is_opaque { u8::MAX } else { 0 };
        (pixels.iter().flat_map(|ink| [ink.gray, alpha(ink)]).collect(), image::ExtendedColorType::La8)
    };
    let mut bytes = Vec::new();
    image::codecs::png::PngEncoder::new(&mut bytes).write_image(
        &samples,
        map.width as u32,
        map.height as u32,
        color,
    )?;
    Ok(bytes)
}
