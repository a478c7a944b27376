//! Pictures to look at.

use std::path::Path;

use image::{ImageResult, Rgb, RgbImage};
use rumbo_core::frames::Point2;
use rumbo_core::map::{Cell, CellClass, Grid};
use rumbo_kit::depth_file::DepthPicture;

/// Near things are red, far ones blue, no reading is black; `marked` is a pixel with a cross.
pub fn depth(path: &Path, picture: &DepthPicture, most: u16, marked: Option<[usize; 2]>) -> ImageResult<()> {
    let mut image = RgbImage::new(picture.width, picture.height);
    for (pixel, count) in image.pixels_mut().zip(&picture.counts) {
        if *count > 0 {
            let far = (f32::from(*count) / f32::from(most)).min(1.0);
            let ramp = |middle: f32| (255.0 * (1.0 - 2.2 * (far - middle).abs()).clamp(0.0, 1.0)) as u8;
            *pixel = Rgb([ramp(0.1), ramp(0.5), ramp(0.9)]);
        }
    }
    if let Some([column, row]) = marked {
        cross(&mut image, column as u32, row as u32, 12);
    }
    image.save(path)
}

/// What is known of the grid from above: occupied black, free white, unknown gray; places are red.
pub fn grid(path: &Path, grid: &Grid, places_m: &[[f64; 2]], scale: u32) -> ImageResult<()> {
    let known = (0..grid.height())
        .flat_map(|row| (0..grid.width()).map(move |col| Cell { col, row }))
        .filter(|cell| grid.class(*cell) != CellClass::Unknown);
    let places = places_m.iter().filter_map(|[x_m, y_m]| grid.cell_at(Point2::new(*x_m, *y_m)));
    let shown = known.chain(places.clone());
    let (mut low, mut high) = (Cell { col: u32::MAX, row: u32::MAX }, Cell { col: 0, row: 0 });
    for Cell { col, row } in shown {
        low = Cell { col: low.col.min(col), row: low.row.min(row) };
        high = Cell { col: high.col.max(col), row: high.row.max(row) };
    }
    let (width, height) = (high.col.saturating_sub(low.col) + 1, high.row.saturating_sub(low.row) + 1);
    let mut image = RgbImage::from_fn(width * scale, height * scale, |x, y| {
        match grid.class(Cell { col: low.col + x / scale, row: high.row - y / scale }) {
            CellClass::Occupied => Rgb([0; 3]),
            CellClass::Free => Rgb([255; 3]),
            CellClass::Unknown => Rgb([170; 3]),
        }
    });
    for cell in places {
        cross(&mut image, (cell.col - low.col) * scale, (high.row - cell.row) * scale, 1);
    }
    image.save(path)
}

fn cross(image: &mut RgbImage, column: u32, row: u32, arm: u32) {
    let red = Rgb([230, 20, 20]);
    let around = |middle: u32| middle.saturating_sub(arm)..=middle + arm;
    let across = around(column).map(|x| (x, row)).chain(around(row).map(|y| (column, y)));
    for (x, y) in across {
        if let Some(pixel) = image.get_pixel_mut_checked(x, y) {
            *pixel = red;
        }
    }
}
