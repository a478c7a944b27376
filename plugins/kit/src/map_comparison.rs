//! How far two maps of the same place are apart: walls found, walls made up, walls displaced, and area of one opinion.
//!
//! Cells of one map are looked up in the other through the frame in which both lie, so that resolution, origin and turn
//! may differ. Distances are exact between centers of cells ([`crate::distance_field`]). Precision and recall with a
//! tolerance as they are usual for edges: Martin, Fowlkes and Malik, "Learning to detect natural image boundaries using
//! local brightness, color, and texture cues" (2004), without their one-to-one assignment.

mod sheet;

use rumbo_core::frames::Point2;
use serde::Serialize;
use thiserror::Error;

use crate::map_file::MapImage;
use crate::spread::quantile;
use sheet::{Opinion, Sheet, WallField};

/// What a map is worth beside a reference.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MapComparison {
    /// How near a wall of one map must be to a wall of the other.
    pub tolerance_m: f64,
    /// Occupied cells of the map.
    pub n_occupied: usize,
    /// Occupied cells of the reference.
    pub n_occupied_reference: usize,
    /// Share of the map's occupied cells that lie within the tolerance of one of the reference.
    pub precision: f64,
    /// Share of the reference's occupied cells that lie within the tolerance of one of the map.
    pub recall: f64,
    /// Harmonic mean of precision and recall.
    pub f1: f64,
    /// From each occupied cell of the map to the nearest one of the reference.
    pub map_to_reference: WallDistance,
    /// From each occupied cell of the reference to the nearest one of the map.
    pub reference_to_map: WallDistance,
    /// Share of the reference's known cells that the map knows, too.
    pub coverage: f64,
    /// Share of the cells known to both about which both say the same, free or occupied; none where there are no such
    /// cells.
    pub agreement: Option<f64>,
}

/// Distances between walls, meters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WallDistance {
    /// Their mean.
    pub mean_m: f64,
    /// What 95 percent of them do not exceed.
    pub p95_m: f64,
    /// The greatest.
    pub max_m: f64,
}

/// Why two maps cannot be compared.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MapComparisonError {
    /// A map without walls.
    #[error("{which} has no occupied cell; are its thresholds and `negate` right?")]
    NoWalls {
        /// The map or the reference.
        which: &'static str,
    },
    /// One field over both would be too large.
    #[error(
        "the maps lie too far apart or are too fine: one field over both has {width} x {height} cells, expected at most \
         {most} and {longest} a side; are both origins in the same frame?"
    )]
    TooFarApart {
        /// Columns of the field.
        width: f64,
        /// Rows of the field.
        height: f64,
        /// The most cells that are taken.
        most: usize,
        /// The longest side.
        longest: usize,
    },
}

/// The tolerance that is usual: two cells of the coarser map, which is what two rasters of the same wall may differ by.
pub fn usual_tolerance_m(map: &MapImage, reference: &MapImage) -> f64 {
    2.0 * map.resolution_m.max(reference.resolution_m)
}

/// Compares a map with a reference.
///
/// # Errors
/// [`MapComparisonError`] where one of them has no walls or where they lie too far apart.
pub fn compare_maps(
    map: &MapImage,
    reference: &MapImage,
    tolerance_m: f64,
) -> Result<MapComparison, MapComparisonError> {
    let (map, reference) = (Sheet::of(map), Sheet::of(reference));
    let (walls, true_walls) = (map.walls(), reference.walls());
    for (which, walls) in [("the map", &walls), ("the reference", &true_walls)] {
        if walls.is_empty() {
            return Err(MapComparisonError::NoWalls { which });
        }
    }
    let found = distances(&walls, &WallField::over(&reference, &map)?);
    let missed = distances(&true_walls, &WallField::over(&map, &reference)?);
    let (precision, recall) = (share_within(&found, tolerance_m), share_within(&missed, tolerance_m));
    let both = precision + recall;
    let (coverage, agreement) = opinions(&map, &reference);
    Ok(MapComparison {
        tolerance_m,
        n_occupied: walls.len(),
        n_occupied_reference: true_walls.len(),
        precision,
        recall,
        f1: if both > 0.0 { 2.0 * precision * recall / both } else { 0.0 },
        map_to_reference: summary(&found),
        reference_to_map: summary(&missed),
        coverage,
        agreement,
    })
}

/// Distance of each point to the nearest wall, sorted.
fn distances(points: &[Point2], field: &WallField) -> Vec<f64> {
    let mut distances: Vec<f64> = points.iter().map(|point| field.distance_m(point)).collect();
    distances.sort_by(f64::total_cmp);
    distances
}

fn share_within(sorted_m: &[f64], tolerance_m: f64) -> f64 {
    /// A tolerance of two cells means two cells, whatever their size in binary.
    const ROUNDING: f64 = 1e-9;
    let n_within = sorted_m.partition_point(|distance_m| *distance_m <= tolerance_m * (1.0 + ROUNDING));
    n_within as f64 / sorted_m.len() as f64
}

fn summary(sorted_m: &[f64]) -> WallDistance {
    WallDistance {
        mean_m: sorted_m.iter().sum::<f64>() / sorted_m.len() as f64,
        p95_m: quantile(sorted_m, 0.95).unwrap_or(f64::NAN),
        max_m: sorted_m.last().copied().unwrap_or(f64::NAN),
    }
}

/// Coverage and agreement, over the known cells of the reference.
fn opinions(map: &Sheet<'_>, reference: &Sheet<'_>) -> (f64, Option<f64>) {
    let (mut n_known, mut n_both, mut n_same) = (0_usize, 0_usize, 0_usize);
    for (center, truth) in reference.cells() {
        if truth == Opinion::Unknown {
            continue;
        }
        n_known += 1;
        match map.opinion_at(&center) {
            Opinion::Unknown => {}
            opinion => {
                n_both += 1;
                n_same += usize::from(opinion == truth);
            }
        }
    }
    let agreement = (n_both > 0).then(|| n_same as f64 / n_both as f64);
    (n_both as f64 / n_known.max(1) as f64, agreement)
}

#[cfg(test)]
mod tests;
