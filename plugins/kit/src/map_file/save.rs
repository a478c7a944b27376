//! Writes a grid as a map_server YAML file and a picture beside it.

use std::path::Path;

use image::ImageEncoder as _;

use super::{MapFileError, MapImage, UNKNOWN};

/// What the written file keeps of the occupancy.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SavedAs {
    /// Occupied, free, unknown: what every tool reads (above 65 percent occupied, below 20 free).
    Trinary,
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

/// Writes `yaml` and a picture of the same name beside it; the pair loads back to the same grid.
///
/// # Errors
/// [`MapFileError::Unwritable`], or [`MapFileError::Inconsistent`] when the grid is not `width * height` cells.
pub fn save_map(
    yaml: &Path,
    map: &MapImage,
    saved_as: SavedAs,
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
    let mode = match saved_as {
        SavedAs::Trinary => "trinary",
        SavedAs::Raw => "raw",
    };
    let name = picture.file_name().unwrap_or_default().to_string_lossy();
    let [x, y, yaw] = map.origin;
    // {:?} prints the shortest text that reads back to the same number.
    let header = format!(
        "image: {name}\nmode: {mode}\nresolution: {:?}\norigin: [{x:?}, {y:?}, {yaw:?}]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        map.resolution_m
    );
    let rows = map.cells.chunks_exact(map.width).rev();
    let pixels: Vec<u8> = rows.flatten().map(|&cell| pixel(cell, saved_as)).collect();
    let bytes = match format {
        PictureFormat::Pgm => {
            [format!("P5\n{} {}\n255\n", map.width, map.height).as_bytes(), &pixels].concat()
        }
        PictureFormat::Png => {
            let mut bytes = Vec::new();
            let (width, height) = (map.width as u32, map.height as u32);
            image::codecs::png::PngEncoder::new(&mut bytes)
                .write_image(&pixels, width, height, image::ExtendedColorType::L8)
                .map_err(|error| MapFileError::Unwritable {
                    path: picture.clone(),
                    source: std::io::Error::other(error),
                })?;
            bytes
        }
    };
    for (path, content) in [(picture.as_path(), bytes.as_slice()), (yaml, header.as_bytes())] {
        std::fs::write(path, content)
            .map_err(|source| MapFileError::Unwritable { path: path.to_path_buf(), source })?;
    }
    Ok(())
}

/// The three grays of ROS `map_saver`: 0, 254 and 205.
fn pixel(cell: i8, saved_as: SavedAs) -> u8 {
    match (saved_as, cell) {
        (SavedAs::Raw, UNKNOWN) => 255,
        (SavedAs::Raw, percent) => percent.clamp(0, 100).unsigned_abs(),
        (SavedAs::Trinary, 66..) => 0,
        (SavedAs::Trinary, 0..20) => 254,
        (SavedAs::Trinary, _) => 205,
    }
}
