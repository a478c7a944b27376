//! What some steps saw, as points and as a table.

use crate::graph_slam::surface::{SurfaceLimits, SurfacePoint, Turn, surface_of};
use crate::rbpf_slam::archive::Archive;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_kit::GridSize;
use rumbo_kit::correlative::FitTable;

/// Edge of the cells that are laid on each other, meters.
pub(super) const CELL_M: f64 = 0.1;
/// How near a point must lie to fit, meters.
const SIGMA_M: f64 = 0.12;
/// One point is enough so far around, meters.
const THINNED_TO_M: f32 = 0.15;
const N_LEVELS: usize = 8;

/// The surfaces that some steps saw, seen from one of them.
pub(super) fn surfaces(
    archive: &Archive,
    way: &[Pose2],
    steps: impl Iterator<Item = usize>,
    seen_from: usize,
    limits: &SurfaceLimits,
) -> Vec<SurfacePoint> {
    let Some(here) = way.get(seen_from).map(Pose2::inverse) else { return Vec::new() };
    let mut points = Vec::new();
    for step in steps {
        let (Some(taken), Some(pose)) = (archive.taken.get(step), way.get(step)) else { continue };
        if taken.is_drawn {
            let turn = Turn::new(&(here * pose));
            let surface = surface_of(&taken.scan, &taken.base_from_sensor, limits);
            points.extend(surface.iter().map(|point| point.seen_from(&turn)));
        }
    }
    points
}

/// One point a small square.
pub(super) fn thinned(points: &[SurfacePoint]) -> Vec<SurfacePoint> {
    let square = |point: &SurfacePoint| point.at.map(|v| (v / THINNED_TO_M).floor() as i32);
    let mut by_square: Vec<([i32; 2], SurfacePoint)> =
        points.iter().map(|point| (square(point), *point)).collect();
    by_square.sort_by_key(|(square, _)| *square);
    by_square.dedup_by_key(|(square, _)| *square);
    by_square.into_iter().map(|(_, point)| point).collect()
}

/// A table around the points, and where its grid lies.
pub(super) fn table_of(points: &[SurfacePoint]) -> Option<(FitTable, Pose2)> {
    let (mut low, mut high) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for (axis, (low, high)) in low.iter_mut().zip(&mut high).enumerate() {
        for point in points {
            (*low, *high) = (low.min(point.at[axis]), high.max(point.at[axis]));
        }
    }
    if low[0] > high[0] {
        return None;
    }
    let corner = low.map(|v| f64::from(v) - 0.5);
    let cells = |axis: usize| ((f64::from(high[axis]) + 0.5 - corner[axis]) / CELL_M) as usize + 1;
    let size = GridSize::new(cells(0), cells(1));
    let mut marks = vec![0; size.n_cells()];
    for point in points {
        let at = [0, 1].map(|axis| ((f64::from(point.at[axis]) - corner[axis]) / CELL_M) as usize);
        marks.iter_mut().skip(size.index(at[0], at[1])).take(1).for_each(|mark| *mark = 1);
    }
    let table = FitTable::around_marks(size, CELL_M, &marks, SIGMA_M, N_LEVELS);
    Some((table, pose2(-corner[0], -corner[1], 0.0)))
}
