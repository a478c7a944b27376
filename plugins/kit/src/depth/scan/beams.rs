//! Directions of a virtual scan's beams.

use super::super::Rays;
use super::ScanError;

/// Which beams a scan has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Beams {
    /// One for each column of the picture, where a level camera has it; from left to right.
    PerColumn,
    /// Evenly spaced; each has what lies within half a step of it.
    Uniform {
        /// Bearing of the first, radians.
        first_bearing_rad: f64,
        /// From one to the next, counter-clockwise, radians.
        bearing_step_rad: f64,
        /// How many.
        n_beams: usize,
    },
}

impl Beams {
    /// Most beams of a scan.
    pub const MOST: usize = 32_768;

    /// Evenly spaced beams over the camera's columns, symmetric around its axis as far as the columns are: as many as leave
    /// none of them without a column, when the camera is level.
    pub fn over(rays: &Rays) -> Beams {
        let bearings_rad: Vec<f64> = rays.left().iter().map(|left| left.atan()).collect();
        let widest_rad = bearings_rad.windows(2).map(|pair| pair[0] - pair[1]).fold(0.0, f64::max);
        let leftmost_rad = bearings_rad.first().copied().unwrap_or_default();
        let rightmost_rad = bearings_rad.last().copied().unwrap_or_default();
        let spread_rad = leftmost_rad - rightmost_rad;
        if widest_rad <= 0.0 {
            return Beams::Uniform { first_bearing_rad: leftmost_rad, bearing_step_rad: 1e-3, n_beams: 1 };
        }
        // A beam is as wide as the widest gap between columns, so that no beam falls into it.
        let n_beams = ((spread_rad / widest_rad * (1.0 + 1e-9)).floor() as usize + 1).min(Self::MOST);
        let bearing_step_rad = if n_beams > 1 { spread_rad / (n_beams - 1) as f64 } else { widest_rad };
        let middle_rad = (leftmost_rad + rightmost_rad) / 2.0;
        let first_bearing_rad = middle_rad - bearing_step_rad * (n_beams - 1) as f64 / 2.0;
        Beams::Uniform { first_bearing_rad, bearing_step_rad, n_beams }
    }

    pub(super) fn bearings_rad(&self, rays: &Rays) -> Result<Vec<f64>, ScanError> {
        match *self {
            Beams::PerColumn => Ok(rays.left().iter().map(|left| left.atan()).collect()),
            Beams::Uniform { first_bearing_rad, bearing_step_rad, n_beams } => {
                let around_rad = bearing_step_rad * n_beams as f64;
                let is_sound = (1..=Self::MOST).contains(&n_beams)
                    && first_bearing_rad.abs() <= std::f64::consts::PI
                    && bearing_step_rad > 1e-9
                    && around_rad <= std::f64::consts::TAU * (1.0 + 1e-9);
                if !is_sound {
                    return Err(ScanError::Beams { n_beams, step_rad: bearing_step_rad });
                }
                Ok((0..n_beams).map(|beam| first_bearing_rad + bearing_step_rad * beam as f64).collect())
            }
        }
    }

    /// The beam that a bearing (from -pi to pi) belongs to; one past the last where it belongs to none.
    pub(super) fn beam_at(&self, bearing_rad: f64, bearings_rad: &[f64]) -> u16 {
        let none = bearings_rad.len() as u16;
        match *self {
            Beams::PerColumn => column_at(bearing_rad, bearings_rad).map_or(none, |column| column as u16),
            Beams::Uniform { first_bearing_rad, bearing_step_rad, n_beams } => {
                uniform_beam(bearing_rad, first_bearing_rad, 1.0 / bearing_step_rad, n_beams as f64) as u16
            }
        }
    }
}

/// The evenly spaced beam nearest to a bearing, with a fraction that counts for nothing, or `n_beams` where none is within
/// half a step; also of bearings a turn below the first beam's.
#[inline(always)]
pub(super) fn uniform_beam(bearing_rad: f64, first_rad: f64, beams_per_rad: f64, n_beams: f64) -> f64 {
    let place = (bearing_rad - first_rad) * beams_per_rad + 0.5;
    let turned = place + std::f64::consts::TAU * beams_per_rad;
    let place = if place < 0.0 { turned } else { place };
    if place >= 0.0 && place < n_beams { place } else { n_beams }
}

/// The column whose bearing is nearest, if it is not farther off than the columns from one another.
fn column_at(bearing_rad: f64, bearings_rad: &[f64]) -> Option<usize> {
    let after = bearings_rad.partition_point(|column_rad| *column_rad > bearing_rad);
    let off_rad = |column: &usize| (bearings_rad[*column] - bearing_rad).abs();
    let beside = [after.checked_sub(1), (after < bearings_rad.len()).then_some(after)];
    let nearest = beside.into_iter().flatten().min_by(|a, b| off_rad(a).total_cmp(&off_rad(b)))?;
    let neighbor = if nearest == 0 { 1 } else { nearest - 1 };
    let reach_rad = bearings_rad
        .get(neighbor)
        .map_or(f64::EPSILON, |column_rad| (column_rad - bearings_rad[nearest]).abs() / 2.0);
    (off_rad(&nearest) <= reach_rad * (1.0 + 1e-9)).then_some(nearest)
}
