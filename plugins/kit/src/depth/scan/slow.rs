//! The scan by its definition, pixel by pixel in double precision.

use nalgebra::{UnitQuaternion, Vector3};

use super::super::{Depths, Rays};
use super::{Beams, ScanError, ScanLimits};

/// Bearings (radians) and ranges (meters) of the scan that [`VirtualScan`](super::VirtualScan) makes.
pub fn scan_slowly(
    rays: &Rays,
    depths: Depths<'_>,
    (level_from_camera, camera_m): (&UnitQuaternion<f64>, f64),
    limits: &ScanLimits,
    beams: &Beams,
) -> Result<Vec<(f64, f64)>, ScanError> {
    let bearings_rad = beams.bearings_rad(rays)?;
    let rows = limits.rows.clone().unwrap_or(0..rays.n_rows());
    let [lowest_m, highest_m] = limits.heights_m;
    let mut between: Vec<Vec<f64>> = vec![Vec::new(); bearings_rad.len()];
    for pixel in rows.start * rays.n_columns()..rows.end * rays.n_columns() {
        let (row, column) = (pixel / rays.n_columns(), pixel % rays.n_columns());
        let Some(depth_m) = depths.get(pixel, f32::INFINITY) else { continue };
        let Some(in_camera) = rays.point(column, row, depth_m.into()) else { continue };
        let point = level_from_camera * Vector3::from(in_camera);
        let height_m = point.z + camera_m;
        let beam = beams.beam_at(point.y.atan2(point.x), &bearings_rad);
        if (lowest_m..=highest_m).contains(&height_m)
            && let Some(ranges_m) = between.get_mut(usize::from(beam))
        {
            ranges_m.push(point.x.hypot(point.y));
        }
    }
    let [least_m, most_m] = limits.ranges_m;
    let range_m = |ranges_m: &Vec<f64>| {
        let accepted = ranges_m.iter().copied().filter(|range_m| (least_m..=most_m).contains(range_m));
        let nearest_m = accepted.fold(f64::INFINITY, f64::min);
        if nearest_m < f64::INFINITY {
            nearest_m
        } else if ranges_m.iter().any(|range_m| *range_m < least_m) {
            f64::NEG_INFINITY
        } else if ranges_m.iter().any(|range_m| *range_m > most_m) {
            f64::INFINITY
        } else {
            f64::NAN
        }
    };
    Ok(bearings_rad.iter().copied().zip(between.iter().map(range_m)).collect())
}
