//! A planar scan out of a depth picture: in every direction the nearest thing between two heights.
//!
//! Arroyo Sánchez (2013), section 5.3: a horizontal slice of the picture, published like a laser scan. Directions and
//! ranges are those over the floor, from the camera's own place; where the camera is tilted or rolled, columns of the
//! picture are no vertical planes, and its points are sorted by their bearings.

mod beams;
mod level;
mod slow;
mod tilted;

pub use beams::Beams;
pub use slow::scan_slowly;

use std::ops::Range;

use nalgebra::UnitQuaternion;

use super::depths::Pixel;
use super::{Depths, Rays, SizeMismatch};
use crate::simd::widest;
use tilted::Tilted;

/// Which pixels count.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanLimits {
    /// Lowest and highest point over the floor, meters.
    pub heights_m: [f64; 2],
    /// Nearest and farthest range over the floor, meters.
    pub ranges_m: [f64; 2],
    /// Rows of the picture that are looked at; none for all of them, where the heights do the selecting.
    pub rows: Option<Range<usize>>,
}

/// What became of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Scanned {
    /// Pixels with a reading, in the rows that are looked at.
    pub n_valid: usize,
    /// Beams with a range.
    pub n_seen: usize,
}

/// Why there is no such scan.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ScanError {
    /// Limits in the wrong order, or no numbers.
    #[error("{what} from {from} to {to}, expected numbers, the first below the second")]
    Limits {
        /// Which limits.
        what: &'static str,
        /// The lower one.
        from: f64,
        /// The upper one.
        to: f64,
    },
    /// Beams that are none, too many, or go around more than once.
    #[error("{n_beams} beams {step_rad} rad apart, expected 1 to {most} that go around at most once", most = Beams::MOST)]
    Beams {
        /// How many.
        n_beams: usize,
        /// From one to the next, radians.
        step_rad: f64,
    },
}

/// Turns depth pictures of one camera into scans.
///
/// A beam has the nearest range within the limits; `-inf` where only nearer things are between the heights, `+inf` where
/// only farther ones are, and not-a-number where nothing is known: no reading, or floor and ceiling only.
#[derive(Debug, Clone)]
pub struct VirtualScan {
    rays: Rays,
    limits: ScanLimits,
    beams: Beams,
    bearings_rad: Vec<f64>,
    camera_m: f64,
    facing: Facing,
    /// In columns of a level camera, or in beams.
    found: Found,
    /// What columns of a level camera add up to in even beams.
    merged: Found,
}

/// Where the camera looks.
#[derive(Debug, Clone)]
enum Facing {
    /// Along the floor: every column has one bearing, and one range for each depth.
    Level {
        /// Range of a depth of one meter.
        lengths: Vec<f32>,
        /// The beam of each column, or one past the last.
        beams: Vec<u16>,
    },
    /// Anywhere else.
    Tilted(Tilted),
}

/// What was found in each column or beam.
#[derive(Debug, Clone, Default)]
struct Found {
    /// Nearest range within the limits, infinite without.
    nearest_m: Vec<f32>,
    /// [`NEARER`] and [`FARTHER`].
    beyond: Vec<u32>,
}

/// Something nearer than the limits was between the heights.
const NEARER: u32 = 1;
/// Something farther than the limits was.
const FARTHER: u32 = 2;

impl Found {
    fn reset(&mut self, n: usize) {
        self.nearest_m.clear();
        self.nearest_m.resize(n, f32::INFINITY);
        self.beyond.clear();
        self.beyond.resize(n, 0);
    }

    /// Takes what was found in columns into their beams.
    fn take(&mut self, beams: &[u16], columns: &Found) {
        for (beam, (nearest_m, beyond)) in beams.iter().zip(columns.nearest_m.iter().zip(&columns.beyond)) {
            let beam = usize::from(*beam);
            if let (Some(least_m), Some(all)) = (self.nearest_m.get_mut(beam), self.beyond.get_mut(beam)) {
                *least_m = least_m.min(*nearest_m);
                *all |= beyond;
            }
        }
    }

    fn range_m(nearest_m: f32, beyond: u32) -> f32 {
        if nearest_m < f32::INFINITY {
            nearest_m
        } else if beyond & NEARER != 0 {
            f32::NEG_INFINITY
        } else if beyond & FARTHER != 0 {
            f32::INFINITY
        } else {
            f32::NAN
        }
    }
}

/// What pixels are measured against, in single precision.
#[derive(Debug, Clone, Copy)]
struct Thresholds {
    /// Lowest and highest point over the camera's height.
    rises_m: [f32; 2],
    ranges_m: [f32; 2],
}

impl VirtualScan {
    /// A scanner for a level camera on the floor; [`face`](Self::face) says where it really is.
    pub fn new(rays: Rays, limits: ScanLimits, beams: Beams) -> Result<VirtualScan, ScanError> {
        for (what, [from, to]) in [("heights", limits.heights_m), ("ranges", limits.ranges_m)] {
            // Also not-a-number is refused.
            if !(from < to && to.is_finite() && from.is_finite()) || (what == "ranges" && from < 0.0) {
                return Err(ScanError::Limits { what, from, to });
            }
        }
        if let Some(rows) = &limits.rows
            && !(rows.start < rows.end && rows.end <= rays.n_rows())
        {
            let [from, to] = [rows.start, rows.end].map(|row| row as f64);
            return Err(ScanError::Limits { what: "rows", from, to });
        }
        let bearings_rad = beams.bearings_rad(&rays)?;
        let facing = Facing::Level { lengths: Vec::new(), beams: Vec::new() };
        let (found, merged) = (Found::default(), Found::default());
        let mut scan =
            VirtualScan { rays, limits, beams, bearings_rad, camera_m: 0.0, facing, found, merged };
        scan.face(&UnitQuaternion::identity(), 0.0);
        Ok(scan)
    }

    /// Where the camera looks from now on: the frame of the scan is level, `level_from_camera` turns into it, and the
    /// camera is this high over the floor, meters. The same direction again costs nothing.
    pub fn face(&mut self, level_from_camera: &UnitQuaternion<f64>, camera_m: f64) {
        self.camera_m = camera_m;
        if *level_from_camera == UnitQuaternion::identity() {
            let lengths = self.rays.left().iter().map(|left| left.hypot(1.0) as f32).collect();
            let beams =
                self.rays.left().iter().map(|left| self.beams.beam_at(left.atan(), &self.bearings_rad));
            self.facing = Facing::Level { lengths, beams: beams.collect() };
            return;
        }
        match &mut self.facing {
            Facing::Tilted(tilted) => {
                tilted.turn(level_from_camera, &self.rays, &self.beams, &self.bearings_rad)
            }
            Facing::Level { .. } => {
                let mut tilted = Tilted::default();
                tilted.turn(level_from_camera, &self.rays, &self.beams, &self.bearings_rad);
                self.facing = Facing::Tilted(tilted);
            }
        }
    }

    /// Bearing of each beam in the level frame, radians.
    pub fn bearings_rad(&self) -> &[f64] {
        &self.bearings_rad
    }

    /// Which pixels count.
    pub fn limits(&self) -> &ScanLimits {
        &self.limits
    }

    /// The directions of the camera's pixels.
    pub fn rays(&self) -> &Rays {
        &self.rays
    }

    /// Scans a picture into one range a beam, meters.
    pub fn scan(&mut self, depths: Depths<'_>, ranges_m: &mut [f32]) -> Result<Scanned, SizeMismatch> {
        depths.check(&self.rays)?;
        SizeMismatch::check("a scan", ranges_m.len(), self.bearings_rad.len())?;
        let n_valid = match depths {
            Depths::Counts { counts, unit_m } => self.find(counts, unit_m),
            Depths::Meters(depths_m) => self.find(depths_m, 1.0),
        };
        self.tell(ranges_m);
        let n_seen = ranges_m.iter().filter(|range_m| range_m.is_finite()).count();
        Ok(Scanned { n_valid, n_seen })
    }

    /// Looks at all pixels and gives the number of those with a reading.
    fn find<P: Pixel>(&mut self, pixels: &[P], unit_m: f32) -> usize {
        let camera_m = self.camera_m;
        let limits = Thresholds {
            rises_m: self.limits.heights_m.map(|height_m| (height_m - camera_m) as f32),
            ranges_m: self.limits.ranges_m.map(|range_m| range_m as f32),
        };
        let rows = self.limits.rows.clone().unwrap_or(0..self.rays.n_rows());
        let (rays, found) = (&self.rays, &mut self.found);
        match &self.facing {
            Facing::Level { lengths, .. } => {
                found.reset(rays.n_columns());
                widest(level::Look { rays, rows, pixels, unit_m, limits, lengths, found })
            }
            Facing::Tilted(tilted) => {
                // One more for pixels without a beam.
                found.reset(self.bearings_rad.len() + 1);
                widest(tilted::Look { tilted, rays, rows, pixels, unit_m, limits, found })
            }
        }
    }

    /// Ranges of the beams out of what was found.
    fn tell(&mut self, ranges_m: &mut [f32]) {
        let mut found = &self.found;
        if let (Facing::Level { beams, .. }, Beams::Uniform { .. }) = (&self.facing, &self.beams) {
            self.merged.reset(ranges_m.len());
            self.merged.take(beams, found);
            found = &self.merged;
        }
        for (range_m, (nearest_m, beyond)) in
            ranges_m.iter_mut().zip(found.nearest_m.iter().zip(&found.beyond))
        {
            *range_m = Found::range_m(*nearest_m, *beyond);
        }
    }
}
