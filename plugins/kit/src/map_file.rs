//! ROS map_server files: a YAML header beside a PGM or PNG picture.
//!
//! Format: ROS wiki *map_server*, section "Map format"; Nav2's `map_io` reads the same files.
//! Sizes are checked on the picture's header, so a file that claims a huge map costs nothing.

use std::path::Path;

mod error;
mod header;
mod ink;
mod of_grid;
pub(crate) mod pixels;
mod save;
mod shade_reading;

pub use error::MapFileError;
pub use header::{MapHeader, MapMode, load_map_header};
pub use save::{PictureFormat, SavedAs, save_map, save_map_to_be_read};
pub use shade_reading::ShadeReading;

/// Largest map that is loaded unless the caller says otherwise: 64 million cells, a hall of 400 m by 400 m at 5 cm.
pub const DEFAULT_MAX_CELLS: u64 = 64_000_000;

/// Occupancy of a cell nobody has seen, as in ROS `OccupancyGrid`.
pub const UNKNOWN: i8 = -1;

/// An occupancy grid as a map file describes it: row 0 is at the bottom, values 0 to 100 percent, -1 unknown.
#[doc(alias = "OccupancyGrid")]
#[derive(Debug, Clone, PartialEq)]
pub struct MapImage {
    /// Number of columns (cells along the map's x axis).
    pub width: usize,
    /// Number of rows (cells along the map's y axis).
    pub height: usize,
    /// Edge of a cell.
    pub resolution_m: f64,
    /// Pose of the lower-left corner of cell (0, 0) in the map frame: x, y in meters, yaw in radians.
    pub origin: [f64; 3],
    /// Row-major occupancy in percent, index `row * width + col`; [`UNKNOWN`] where nobody looked.
    pub cells: Vec<i8>,
}

impl MapImage {
    /// Occupancy of a cell in percent, [`UNKNOWN`] outside the map as well.
    pub fn occupancy(&self, col: usize, row: usize) -> i8 {
        if col < self.width && row < self.height { self.cells[row * self.width + col] } else { UNKNOWN }
    }

    /// Whether a cell is more likely occupied than free; false for unknown cells.
    pub fn is_occupied(&self, col: usize, row: usize) -> bool {
        self.occupancy(col, row) > 50
    }
}

/// Loads a map_server YAML file and its picture, refusing more than `max_cells` cells before any is allocated.
///
/// # Errors
/// Every way a map file can be wrong is a variant of [`MapFileError`].
pub fn load_map(yaml: &Path, max_cells: u64) -> Result<MapImage, MapFileError> {
    let header = load_map_header(yaml)?;
    let reading = header.reading();
    let shades = pixels::load(&header.image, max_cells)?;
    let (width, height) = (shades.width, shades.height);
    let mut cells = vec![UNKNOWN; width * height];
    for (line, row) in (0..height).rev().enumerate() {
        for col in 0..width {
            let pixel = line * width + col;
            let opaque = shades.opaque.as_ref().is_none_or(|opaque| opaque[pixel]);
            if opaque {
                cells[row * width + col] = reading.occupancy(shades.shade[pixel]);
            }
        }
    }
    Ok(MapImage { width, height, resolution_m: header.resolution_m, origin: header.origin, cells })
}

#[cfg(test)]
mod tests;
