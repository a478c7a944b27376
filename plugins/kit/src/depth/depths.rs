//! A depth picture as it comes: counts of the device, or meters.

use super::Rays;

/// No depth is larger, meters: squares of what is nearer are finite.
pub(super) const FARTHEST_M: f32 = 1e9;

/// Depths of a picture, row by row from the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Depths<'a> {
    /// Whole counts; 0 is no reading.
    Counts {
        /// One count a pixel.
        counts: &'a [u16],
        /// Meters of one count.
        unit_m: f32,
    },
    /// Meters; what is not a number above 0, or beyond a million kilometers, is no reading.
    Meters(&'a [f32]),
}

/// A picture that does not fit the camera, or an answer that does not fit the picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{what} of {found} elements where the camera has {expected}")]
pub struct SizeMismatch {
    /// What has the wrong size.
    pub what: &'static str,
    /// Its elements.
    pub found: usize,
    /// What the camera has.
    pub expected: usize,
}

impl SizeMismatch {
    pub(super) fn check(what: &'static str, found: usize, expected: usize) -> Result<(), SizeMismatch> {
        if found == expected { Ok(()) } else { Err(SizeMismatch { what, found, expected }) }
    }
}

impl Depths<'_> {
    /// Pixels of the picture.
    pub fn len(&self) -> usize {
        match self {
            Depths::Counts { counts, .. } => counts.len(),
            Depths::Meters(depths_m) => depths_m.len(),
        }
    }

    /// There are no pixels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Depth of a pixel, meters; none without a reading up to `max_m`.
    pub fn get(&self, pixel: usize, max_m: f32) -> Option<f32> {
        let depth_m = match self {
            Depths::Counts { counts, unit_m } => f32::from(*counts.get(pixel)?) * unit_m,
            Depths::Meters(depths_m) => *depths_m.get(pixel)?,
        };
        (depth_m > 0.0 && depth_m <= max_m.min(FARTHEST_M)).then_some(depth_m)
    }

    pub(super) fn check(&self, rays: &Rays) -> Result<(), SizeMismatch> {
        SizeMismatch::check("a depth picture", self.len(), rays.n_pixels())
    }
}

/// One pixel of either kind. Always inlined, for the loops that go over pictures.
pub(super) trait Pixel: Copy {
    /// Meters, and 0 or less or not-a-number where there is no reading.
    fn meters(self, unit_m: f32) -> f32;
}

impl Pixel for u16 {
    #[inline(always)]
    fn meters(self, unit_m: f32) -> f32 {
        f32::from(self) * unit_m
    }
}

impl Pixel for f32 {
    #[inline(always)]
    fn meters(self, _: f32) -> f32 {
        self
    }
}
