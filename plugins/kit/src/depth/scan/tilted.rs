//! A camera that is tilted or rolled: each pixel has a bearing of its own.

use std::ops::Range;

use nalgebra::{Matrix3, UnitQuaternion};

use super::super::Rays;
use super::super::depths::{FARTHEST_M, Pixel};
use super::beams::{Beams, uniform_beam};
use super::{FARTHER, Found, NEARER, Thresholds};
use crate::simd::{Kernel, Vectors, widest};

/// What each pixel of a turned camera means. A pixel's bearing does not depend on its depth, so that all this stays as
/// long as the camera keeps its attitude.
#[derive(Debug, Clone, Default)]
pub(super) struct Tilted {
    level_from_camera: Option<UnitQuaternion<f64>>,
    /// The beam of each pixel, or one past the last.
    beams: Vec<u16>,
    /// Range over the floor of a depth of one meter.
    lengths: Vec<f32>,
    /// Rise of a depth of one meter.
    rises: Vec<f32>,
}

impl Tilted {
    /// Turns the camera.
    pub fn turn(
        &mut self,
        level_from_camera: &UnitQuaternion<f64>,
        rays: &Rays,
        beams: &Beams,
        bearings_rad: &[f64],
    ) {
        if self.level_from_camera == Some(*level_from_camera) {
            return;
        }
        self.level_from_camera = Some(*level_from_camera);
        let level_from_camera = level_from_camera.to_rotation_matrix().into_inner();
        let n_pixels = rays.n_pixels();
        self.beams.resize(n_pixels, 0);
        self.lengths.resize(n_pixels, 0.0);
        self.rises.resize(n_pixels, 0.0);
        let pixels = self.lengths.iter_mut().zip(&mut self.rises).zip(&mut self.beams);
        match *beams {
            Beams::Uniform { first_bearing_rad, bearing_step_rad, n_beams } => widest(Turn {
                rays,
                level_from_camera,
                first_bearing_rad,
                beams_per_rad: 1.0 / bearing_step_rad,
                n_beams: n_beams as f64,
                tilted: self,
            }),
            Beams::PerColumn => {
                for (pixel, ((length, rise), beam)) in pixels.enumerate() {
                    let (row, column) = (pixel / rays.n_columns(), pixel % rays.n_columns());
                    let [x, y, z] = direction(&level_from_camera, rays.left()[column], rays.up()[row]);
                    (*length, *rise) = (x.hypot(y) as f32, z as f32);
                    *beam = beams.beam_at(y.atan2(x), bearings_rad);
                }
            }
        }
    }
}

/// Where a pixel looks, in the level frame, for a depth of one meter.
#[inline(always)]
fn direction(level_from_camera: &Matrix3<f64>, left: f64, up: f64) -> [f64; 3] {
    let m = level_from_camera;
    [0, 1, 2].map(|axis| m[(axis, 0)] + m[(axis, 1)] * left + m[(axis, 2)] * up)
}

/// Works out all pixels for evenly spaced beams.
struct Turn<'a> {
    rays: &'a Rays,
    level_from_camera: Matrix3<f64>,
    first_bearing_rad: f64,
    beams_per_rad: f64,
    n_beams: f64,
    tilted: &'a mut Tilted,
}

impl Kernel for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let Turn { rays, level_from_camera, first_bearing_rad, beams_per_rad, n_beams, tilted } = self;
        let n_columns = rays.n_columns();
        let of_left = [0, 1, 2].map(|axis| level_from_camera[(axis, 1)]);
        let rows = tilted
            .lengths
            .chunks_exact_mut(n_columns)
            .zip(tilted.rises.chunks_exact_mut(n_columns))
            .zip(tilted.beams.chunks_exact_mut(n_columns))
            .zip(rays.up());
        for (((lengths, rises), beams), up) in rows {
            let of_row = direction(&level_from_camera, 0.0, *up);
            let chunks = lengths
                .chunks_mut(LANES)
                .zip(rises.chunks_mut(LANES))
                .zip(beams.chunks_mut(LANES))
                .zip(rays.left().chunks(LANES));
            for (((lengths, rises), beams), lefts) in chunks {
                // Two loops where one would do: beams are narrow numbers, and would keep the rest from going abreast.
                let mut bearings_rad = [0.0; LANES];
                let pixels = lengths.iter_mut().zip(rises).zip(&mut bearings_rad).zip(lefts);
                for (((length, rise), bearing_rad), left) in pixels {
                    let [x, y, z] = [0, 1, 2].map(|axis| of_row[axis] + of_left[axis] * left);
                    let square = (x * x + y * y) as f32;
                    (*length, *rise) = (square.sqrt(), z as f32);
                    *bearing_rad = angle_rad(y, x);
                }
                for (beam, bearing_rad) in beams.iter_mut().zip(&bearings_rad) {
                    let place = uniform_beam(*bearing_rad, first_bearing_rad, beams_per_rad, n_beams);
                    // Beams are at most `Beams::MOST`; through a signed number it is one instruction.
                    *beam = place as i32 as u16;
                }
            }
        }
    }
}

/// The angle of (x, y), as `y.atan2(x)` to 1e-10 rad, in operations that vectors have: the arc tangent of a number from 0
/// to 1 is that of one below tan(pi/8), whose series converges quickly, or pi/4 more.
#[inline(always)]
pub(super) fn angle_rad(y: f64, x: f64) -> f64 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    /// tan(pi/8).
    const SPLIT: f64 = std::f64::consts::SQRT_2 - 1.0;
    let (across, along) = (y.abs(), x.abs());
    let (least, most) = if across < along { (across, along) } else { (along, across) };
    let is_steep = least > SPLIT * most;
    let (offset, above, below) =
        if is_steep { (FRAC_PI_4, least - most, least + most) } else { (0.0, least, most) };
    let t = if below > 0.0 { above / below } else { 0.0 };
    let t2 = t * t;
    let mut series = 0.0;
    for power in (0..12).rev() {
        let term = 1.0 / f64::from(2 * power + 1);
        series = if power % 2 == 0 { term } else { -term } + t2 * series;
    }
    let below_45 = offset + t * series;
    let below_90 = if across > along { FRAC_PI_2 - below_45 } else { below_45 };
    let angle = if x < 0.0 { PI - below_90 } else { below_90 };
    if y < 0.0 { -angle } else { angle }
}

/// Looks at all rows.
pub(super) struct Look<'a, P> {
    pub tilted: &'a Tilted,
    pub rays: &'a Rays,
    pub rows: Range<usize>,
    pub pixels: &'a [P],
    pub unit_m: f32,
    pub limits: Thresholds,
    pub found: &'a mut Found,
}

/// Pixels that are looked at together.
const LANES: usize = 64;

impl<P: Pixel> Kernel for Look<'_, P> {
    type Output = usize;

    #[inline(always)]
    fn run<V: Vectors>(self) -> usize {
        let Look { tilted, rays, rows, pixels, unit_m, limits, found } = self;
        let Thresholds { rises_m: [lowest_m, highest_m], ranges_m: [least_m, most_m] } = limits;
        let n_columns = rays.n_columns();
        let span = rows.start * n_columns..rows.end * n_columns;
        let mut n_valid = 0;
        let chunks = pixels[span.clone()]
            .chunks(LANES)
            .zip(tilted.lengths[span.clone()].chunks(LANES))
            .zip(tilted.rises[span.clone()].chunks(LANES))
            .zip(tilted.beams[span].chunks(LANES));
        for (((pixels, lengths), rises), beams) in chunks {
            let mut ranges_m = [f32::NAN; LANES];
            let mut n_chunk = 0_u32;
            for (((pixel, length), rise), range_m) in pixels.iter().zip(lengths).zip(rises).zip(&mut ranges_m)
            {
                let depth_m = pixel.meters(unit_m);
                let is_valid = depth_m > 0.0 && depth_m <= FARTHEST_M;
                let rise_m = depth_m * rise;
                let is_between = is_valid & (rise_m >= lowest_m) & (rise_m <= highest_m);
                *range_m = if is_between { depth_m * length } else { f32::NAN };
                n_chunk += u32::from(is_valid);
            }
            n_valid += n_chunk as usize;
            for (range_m, beam) in ranges_m.into_iter().zip(beams) {
                if range_m.is_nan() {
                    continue;
                }
                let beam = usize::from(*beam);
                if range_m < least_m {
                    found.beyond[beam] |= NEARER;
                } else if range_m > most_m {
                    found.beyond[beam] |= FARTHER;
                } else if range_m < found.nearest_m[beam] {
                    found.nearest_m[beam] = range_m;
                }
            }
        }
        n_valid
    }
}

#[cfg(test)]
mod tests {
    use super::angle_rad;

    #[test]
    fn the_angle_is_that_of_the_standard_library() {
        for turn in 0..100_000 {
            let (y, x) = (f64::from(turn) * 1e-4).sin_cos();
            for length in [1e-3, 1.0, 70.0] {
                let off_rad = angle_rad(y * length, x * length) - (y * length).atan2(x * length);
                assert!(off_rad.abs() < 1e-10, "{y} {x}: {off_rad}");
            }
        }
        assert_eq!(angle_rad(0.0, 0.0), 0.0);
    }
}
