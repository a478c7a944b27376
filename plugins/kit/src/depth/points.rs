//! A depth picture as points.

use super::depths::{FARTHEST_M, Pixel};
use super::{Depths, HeightBand, Rays, SizeMismatch};
use crate::simd::{Kernel, Vectors, widest};

/// What a picture held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counted {
    /// Pixels with a reading.
    pub n_valid: usize,
    /// Those of them whose points are in the band of heights; all without a band.
    pub n_kept: usize,
}

/// Points of all pixels in the camera's frame, meters: not-a-number in all three where there is no reading up to `max_m`,
/// or outside of the band. Counts tell a camera that is blind from one that sees free space.
pub fn points(
    rays: &Rays,
    depths: Depths<'_>,
    max_m: f32,
    band: Option<&HeightBand>,
    out: &mut [[f32; 3]],
) -> Result<Counted, SizeMismatch> {
    depths.check(rays)?;
    SizeMismatch::check("a row of points", out.len(), rays.n_pixels())?;
    let max_m = max_m.min(FARTHEST_M);
    Ok(match depths {
        Depths::Counts { counts, unit_m } => {
            with_band(Picture { rays, pixels: counts, unit_m, max_m, out }, band)
        }
        Depths::Meters(pixels) => with_band(Picture { rays, pixels, unit_m: 1.0, max_m, out }, band),
    })
}

fn with_band<P: Pixel>(picture: Picture<'_, P>, band: Option<&HeightBand>) -> Counted {
    match band {
        None => widest(All(picture)),
        Some(band) => widest(Banded { picture, band }),
    }
}

/// The point of one pixel by the formulas, in double precision; none where [`points`] gives not-a-number.
pub fn point_slowly(
    rays: &Rays,
    depths: Depths<'_>,
    max_m: f32,
    band: Option<&HeightBand>,
    pixel: usize,
) -> Option<[f64; 3]> {
    let depth_m = f64::from(depths.get(pixel, max_m)?);
    let point_m = rays.point(pixel % rays.n_columns(), pixel / rays.n_columns(), depth_m)?;
    band.is_none_or(|band| band.has(point_m)).then_some(point_m)
}

struct Picture<'a, P> {
    rays: &'a Rays,
    pixels: &'a [P],
    unit_m: f32,
    max_m: f32,
    out: &'a mut [[f32; 3]],
}

struct All<'a, P>(Picture<'a, P>);

struct Banded<'a, P> {
    picture: Picture<'a, P>,
    band: &'a HeightBand,
}

impl<P: Pixel> Kernel for All<'_, P> {
    type Output = Counted;

    #[inline(always)]
    fn run<V: Vectors>(self) -> Counted {
        let Picture { rays, pixels, unit_m, max_m, out } = self.0;
        let n_columns = rays.n_columns();
        let mut n_valid = 0;
        let rows = pixels.chunks_exact(n_columns).zip(out.chunks_exact_mut(n_columns)).zip(&rays.up_f32);
        for ((pixels, out), up) in rows {
            let mut n_row = 0_u32;
            for ((pixel, left), point) in pixels.iter().zip(&rays.left_f32).zip(out) {
                let depth_m = pixel.meters(unit_m);
                let is_valid = depth_m > 0.0 && depth_m <= max_m;
                let x = if is_valid { depth_m } else { f32::NAN };
                n_row += u32::from(is_valid);
                *point = [x, x * left, x * up];
            }
            n_valid += n_row as usize;
        }
        Counted { n_valid, n_kept: n_valid }
    }
}

impl<P: Pixel> Kernel for Banded<'_, P> {
    type Output = Counted;

    #[inline(always)]
    fn run<V: Vectors>(self) -> Counted {
        let Picture { rays, pixels, unit_m, max_m, out } = self.picture;
        let [rise_x, rise_y, rise_z] = self.band.rise.map(|rise| rise as f32);
        let camera_m = self.band.camera_m as f32;
        let [lowest_m, highest_m] = self.band.heights_m.map(|height_m| height_m as f32 - camera_m);
        let n_columns = rays.n_columns();
        let mut counted = Counted::default();
        let rows = pixels.chunks_exact(n_columns).zip(out.chunks_exact_mut(n_columns)).zip(&rays.up_f32);
        for ((pixels, out), up) in rows {
            let (mut n_valid, mut n_kept) = (0_u32, 0_u32);
            let rise_of_row = rise_x + rise_z * up;
            for ((pixel, left), point) in pixels.iter().zip(&rays.left_f32).zip(out) {
                let depth_m = pixel.meters(unit_m);
                let is_valid = depth_m > 0.0 && depth_m <= max_m;
                let rise_m = depth_m * (rise_of_row + rise_y * left);
                let is_kept = is_valid & (rise_m >= lowest_m) & (rise_m <= highest_m);
                let x = if is_kept { depth_m } else { f32::NAN };
                n_valid += u32::from(is_valid);
                n_kept += u32::from(is_kept);
                *point = [x, x * left, x * up];
            }
            counted.n_valid += n_valid as usize;
            counted.n_kept += n_kept as usize;
        }
        counted
    }
}
