//! The map as a gray image: occupied dark, free white, unknown in between.

use base64::Engine as _;
use image::ImageEncoder as _;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::map::{CellClass, Grid};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A map as an image, cut to what is known and made small enough for a page.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Packed", into = "Packed")]
pub struct MapImage {
    /// Pixels along x.
    pub width: u32,
    /// Pixels along y.
    pub height: u32,
    /// Edge of a pixel on the floor, meters.
    pub pixel_m: f64,
    /// The lower left corner in the map's frame: x and y in meters, turn in radians.
    pub origin: [f64; 3],
    /// One gray a pixel, row by row from the top.
    pub gray: Arc<[u8]>,
}

/// Gray of an occupied cell.
pub const OCCUPIED: u8 = 0x22;
/// Gray of a cell that nobody knows.
pub const UNKNOWN: u8 = 0xd4;
/// Gray of a free cell.
pub const FREE: u8 = 0xff;

/// The longer side has at most so many pixels.
const MOST_PIXELS: u32 = 1600;

impl MapImage {
    /// The image of a grid; none where no cell is known.
    pub fn of(grid: &Grid) -> Option<MapImage> {
        let (cols, rows) = grid.known_extent()?;
        let longest = (cols.end - cols.start).max(rows.end - rows.start);
        let factor = longest.div_ceil(MOST_PIXELS).max(1);
        let (width, height) =
            ((cols.end - cols.start).div_ceil(factor), (rows.end - rows.start).div_ceil(factor));
        let mut gray = Vec::with_capacity(width as usize * height as usize);
        for down in 0..height {
            let row0 = rows.start + (height - 1 - down) * factor;
            for right in 0..width {
                let col0 = cols.start + right * factor;
                gray.push(darkest(
                    grid,
                    (col0, (col0 + factor).min(cols.end)),
                    (row0, (row0 + factor).min(rows.end)),
                ));
            }
        }
        let resolution_m = grid.resolution_m();
        let corner = Point2::new(f64::from(cols.start), f64::from(rows.start)) * resolution_m;
        let map_from_corner = grid.map_from_grid() * corner;
        let origin = [map_from_corner.x, map_from_corner.y, grid.map_from_grid().rotation.angle()];
        Some(MapImage { width, height, pixel_m: resolution_m * f64::from(factor), origin, gray: gray.into() })
    }

    /// The image's own frame: origin at the lower left corner, meters.
    pub fn map_from_image(&self) -> Pose2 {
        let [x, y, yaw] = self.origin;
        pose2(x, y, yaw)
    }

    /// The corners in the map's frame.
    pub fn corners(&self) -> [Point2; 4] {
        let (w, h) = (f64::from(self.width) * self.pixel_m, f64::from(self.height) * self.pixel_m);
        [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(|[x, y]| self.map_from_image() * Point2::new(x, y))
    }

    /// The image as a PNG file.
    pub fn png(&self) -> Result<Vec<u8>, image::ImageError> {
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new_with_quality(
            &mut bytes,
            image::codecs::png::CompressionType::Best,
            image::codecs::png::FilterType::NoFilter,
        );
        encoder.write_image(&self.gray, self.width, self.height, image::ExtendedColorType::L8)?;
        Ok(bytes)
    }
}

/// Walls stay visible when cells are joined: the darkest class of a block, but known before unknown.
fn darkest(grid: &Grid, cols: (u32, u32), rows: (u32, u32)) -> u8 {
    let mut gray = UNKNOWN;
    for row in rows.0..rows.1 {
        let start = row as usize * grid.width() as usize;
        let cells = grid.cells.get(start + cols.0 as usize..start + cols.1 as usize).unwrap_or_default();
        for value in cells {
            match grid.class_of(*value) {
                CellClass::Occupied => return OCCUPIED,
                CellClass::Free => gray = FREE,
                CellClass::Unknown => {}
            }
        }
    }
    gray
}

/// How a [`MapImage`] is kept in a saved run: a PNG as text.
#[derive(Serialize, Deserialize)]
struct Packed {
    pixel_m: f64,
    origin: [f64; 3],
    png_base64: String,
}

impl From<MapImage> for Packed {
    fn from(map: MapImage) -> Packed {
        // An image that cannot be packed leaves a saved run without a map, which its picture shows.
        let png = map.png().unwrap_or_default();
        let png_base64 = base64::engine::general_purpose::STANDARD.encode(png);
        Packed { pixel_m: map.pixel_m, origin: map.origin, png_base64 }
    }
}

impl TryFrom<Packed> for MapImage {
    type Error = String;

    fn try_from(packed: Packed) -> Result<MapImage, String> {
        let png = base64::engine::general_purpose::STANDARD.decode(&packed.png_base64);
        let png = png.map_err(|error| format!("the map is not base64: {error}"))?;
        let image = image::load_from_memory_with_format(&png, image::ImageFormat::Png);
        let image = image.map_err(|error| format!("the map is not a PNG image: {error}"))?.into_luma8();
        let numbers_are_fine =
            packed.pixel_m > 0.0 && packed.pixel_m.is_finite() && packed.origin.iter().all(|v| v.is_finite());
        if !numbers_are_fine {
            return Err("the map's `pixel_m` and `origin` must be finite, `pixel_m` above zero".into());
        }
        let (width, height) = image.dimensions();
        Ok(MapImage {
            width,
            height,
            pixel_m: packed.pixel_m,
            origin: packed.origin,
            gray: image.into_raw().into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::map::Cell;

    fn grid_with(width: u32, height: u32, cells: &[(u32, u32, f32)]) -> Grid {
        let mut grid = Grid::unknown(width, height, 0.5).unwrap();
        for (col, row, value) in cells {
            let index = grid.index_of(Cell { col: *col, row: *row });
            grid.cells.make_mut()[index] = *value;
        }
        grid
    }

    #[test]
    fn the_image_is_cut_to_the_known_cells_with_the_top_row_first() {
        let grid = grid_with(10, 10, &[(2, 3, 5.0), (4, 4, -5.0)]);
        let image = MapImage::of(&grid).unwrap();
        assert_eq!((image.width, image.height, image.origin), (3, 2, [1.0, 1.5, 0.0]));
        assert_eq!(*image.gray, [UNKNOWN, UNKNOWN, FREE, OCCUPIED, UNKNOWN, UNKNOWN]);
        assert_eq!(MapImage::of(&grid_with(3, 3, &[])), None);
    }

    #[test]
    fn a_thin_wall_survives_in_a_map_that_is_made_smaller() {
        let wide = MOST_PIXELS * 2 + 1;
        let grid = grid_with(wide, 2, &[(0, 0, -5.0), (wide - 1, 1, -5.0), (9, 1, 5.0)]);
        let image = MapImage::of(&grid).unwrap();
        assert_eq!((image.width, image.height, image.pixel_m), (wide.div_ceil(3), 1, 1.5));
        assert_eq!(image.gray[3], OCCUPIED);
    }

    #[test]
    fn a_packed_map_comes_back_and_a_damaged_one_is_refused() {
        let image = MapImage::of(&grid_with(10, 10, &[(2, 3, 5.0), (4, 4, -5.0)])).unwrap();
        let mut packed = serde_json::to_value(&image).unwrap();
        assert_eq!(serde_json::from_value::<MapImage>(packed.clone()).unwrap(), image);
        packed["png_base64"] = "AAAA".into();
        assert!(serde_json::from_value::<MapImage>(packed).unwrap_err().to_string().contains("PNG"));
    }
}
