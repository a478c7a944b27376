//! Pictures to look at.

use std::path::Path;

use image::{ImageResult, Rgb, RgbImage};
use rumbo_core::map::{CellClass, Grid, Cell};
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

/// The grid from above: occupied black, free white, unknown gray; places with a red dot.
pub fn grid(path: &Path, grid: &Grid, places_m: &[[f64; 2]], scale: u32) -> ImageResult<()> {
    let (width, height) = (grid.width(), grid.height());
    let mut image = RgbImage::from_fn(width * scale, height * scale, |x, y| {
        let cell = Cell { col: x / scale, row: height - 1 - y / scale };
        match grid.class(cell) {
            CellClass::Occupied => Rgb([0; 3]),
            CellClass::Free => Rgb([255; 3]),
            CellClass::Unknown => Rgb([170; 3]),
        }
    });
    for [x_m, y_m] in places_m {
        if let Some(cell) = grid.cell_at(rumbo_core::frames::Point2::new(*x_m, *y_m)) {
            cross(&mut image, cell.col * scale, (height - 1 - cell.row) * scale, 1);
        }
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
