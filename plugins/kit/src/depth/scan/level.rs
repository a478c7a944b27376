//! A level camera: column by column.

use std::ops::Range;

use super::super::Rays;
use super::super::depths::{FARTHEST_M, Pixel};
use super::{FARTHER, Found, NEARER, Thresholds};
use crate::simd::{Kernel, Vectors};

/// Looks at all rows; each column has its own place in what is found.
pub(super) struct Look<'a, P> {
    pub rays: &'a Rays,
    pub rows: Range<usize>,
    pub pixels: &'a [P],
    pub unit_m: f32,
    pub limits: Thresholds,
    pub lengths: &'a [f32],
    pub found: &'a mut Found,
}

impl<P: Pixel> Kernel for Look<'_, P> {
    type Output = usize;

    #[inline(always)]
    fn run<V: Vectors>(self) -> usize {
        let Look { rays, rows, pixels, unit_m, limits, lengths, found } = self;
        let Thresholds { rises_m: [lowest_m, highest_m], ranges_m: [least_m, most_m] } = limits;
        let mut n_valid = 0;
        let all = pixels.chunks_exact(rays.n_columns()).zip(&rays.up_f32);
        for (pixels, up) in all.take(rows.end).skip(rows.start) {
            let mut n_row = 0_u32;
            let places = found.nearest_m.iter_mut().zip(&mut found.beyond);
            for ((pixel, length), (nearest_m, beyond)) in pixels.iter().zip(lengths).zip(places) {
                let depth_m = pixel.meters(unit_m);
                let is_valid = depth_m > 0.0 && depth_m <= FARTHEST_M;
                let (rise_m, range_m) = (depth_m * up, depth_m * length);
                let is_between = is_valid & (rise_m >= lowest_m) & (rise_m <= highest_m);
                let (is_nearer, is_farther) = (range_m < least_m, range_m > most_m);
                let counts = is_between & !is_nearer & !is_farther;
                let candidate_m = if counts { range_m } else { f32::INFINITY };
                *nearest_m = if candidate_m < *nearest_m { candidate_m } else { *nearest_m };
                let outside = (u32::from(is_nearer) * NEARER) | (u32::from(is_farther) * FARTHER);
                *beyond |= if is_between { outside } else { 0 };
                n_row += u32::from(is_valid);
            }
            n_valid += n_row as usize;
        }
        n_valid
    }
}
