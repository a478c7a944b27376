//! Surfaces that are laid on each other, as points and as a table.

use super::surface::SurfacePoint;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_kit::GridSize;
use rumbo_kit::correlative::FitTable;

/// Edge of the cells that are laid on each other, meters.
pub const RESOLUTION_M: f64 = 0.1;
/// How near a point must lie to fit, meters.
const SIGMA_M: f64 = 0.12;
const N_LEVELS: usize = 8;
/// One point a cell is enough to recognize a place by, meters.
const THINNED_TO_M: f32 = 0.15;

/// One point a small square.
pub fn thinned(points: impl Iterator<Item = SurfacePoint>) -> Vec<SurfacePoint> {
    let mut by_square: Vec<([i32; 2], SurfacePoint)> =
        points.map(|point| (point.at.map(|v| (v / THINNED_TO_M).floor() as i32), point)).collect();
    by_square.sort_by_key(|(square, _)| *square);
    by_square.dedup_by_key(|(square, _)| *square);
    by_square.into_iter().map(|(_, point)| point).collect()
}

/// Places alone.
pub fn points_of(surface: &[SurfacePoint]) -> Vec<Point2> {
    surface.iter().map(|point| Point2::new(point.at[0].into(), point.at[1].into())).collect()
}

/// A table around the points, and where its grid lies.
pub fn table_of(points: &[SurfacePoint]) -> Option<(FitTable, Pose2)> {
    let mut bounds: Option<([f64; 2], [f64; 2])> = None;
    for point in points {
        let at = point.at.map(f64::from);
        let (low, high) = bounds.get_or_insert((at, at));
        for axis in 0..2 {
            low[axis] = low[axis].min(at[axis]);
            high[axis] = high[axis].max(at[axis]);
        }
    }
    let (low, high) = bounds?;
    let corner = low.map(|v| v - 0.5);
    let cells = |axis: usize| ((high[axis] + 0.5 - corner[axis]) / RESOLUTION_M) as usize + 1;
    let size = GridSize::new(cells(0), cells(1));
    let mut marks = vec![0; size.n_cells()];
    for point in points {
        let at = [0, 1].map(|axis| ((f64::from(point.at[axis]) - corner[axis]) / RESOLUTION_M) as usize);
        marks.iter_mut().skip(size.index(at[0], at[1])).take(1).for_each(|mark| *mark = 1);
    }
    let table = FitTable::around_marks(size, RESOLUTION_M, &marks, SIGMA_M, N_LEVELS);
    Some((table, pose2(-corner[0], -corner[1], 0.0)))
}
