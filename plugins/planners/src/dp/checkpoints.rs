//! Checkpoints of a path, and fewer of them: Hernández Alamilla (2005), section 3.2.4 and algorithm 3.3.

use super::cost_map::keeps;
use rumbo_kit::GridSize;
use rumbo_kit::proximity::{CellKind, ProximityMap};
use rumbo_kit::segment::all_cells_crossed;

/// A point in cells: the center of cell (0, 0) is (0.5, 0.5).
pub type Point = [f64; 2];

/// Center of a cell.
pub fn center_of(size: GridSize, cell: usize) -> Point {
    let (col, row) = size.col_row(cell);
    [col as f64 + 0.5, row as f64 + 0.5]
}

/// Where the robot must turn: its true position, the center of every cell where the path changes direction, the goal.
pub fn checkpoints(size: GridSize, path: &[usize], start: Point) -> Vec<Point> {
    let mut points = vec![start];
    let step = |a: usize, b: usize| b as i64 - a as i64;
    let turns = path.windows(3).filter(|w| step(w[0], w[1]) != step(w[1], w[2]));
    points.extend(turns.map(|w| center_of(size, w[1])));
    points.extend(path.last().map(|&goal| center_of(size, goal)));
    points
}

/// When a straight segment may replace a piece of the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShortCut {
    /// `D_pref`, in cells.
    pub preferred: f64,
    /// `d_min`, in cells.
    pub minimum: f64,
    /// Where the path itself comes nearer than `D_pref`, a segment that comes no nearer is clear, too. In narrow places
    /// the source's test can never be met and all the turns of a staircase stay.
    pub no_nearer_than_path: bool,
    /// A segment may run exactly through a corner of a closed cell.
    pub corner_cutting: bool,
}

impl ShortCut {
    /// Drops the checkpoints that are not needed. `give_up` is asked once for each that stays.
    pub fn refine(
        &self,
        proximity: &ProximityMap,
        checkpoints: &[Point],
        mut give_up: impl FnMut() -> bool,
    ) -> Option<Vec<Point>> {
        let legs: Vec<f64> = checkpoints.windows(2).map(|w| clearance(proximity, w[0], w[1])).collect();
        let mut refined = Vec::with_capacity(checkpoints.len());
        let mut i = 0;
        while i < checkpoints.len() {
            if give_up() {
                return None;
            }
            refined.push(checkpoints[i]);
            i = self.farthest_clear(proximity, checkpoints, &legs, i).unwrap_or(i + 1);
        }
        Some(refined)
    }

    /// The last checkpoint, at least two on, that a clear segment leads to.
    fn farthest_clear(
        &self,
        proximity: &ProximityMap,
        checkpoints: &[Point],
        legs: &[f64],
        i: usize,
    ) -> Option<usize> {
        let mut along = f64::INFINITY;
        let mut needed = Vec::with_capacity(legs.len() - i.min(legs.len()));
        for leg in legs.get(i..).unwrap_or_default() {
            along = along.min(*leg);
            let lowered = if self.no_nearer_than_path { along.min(self.preferred) } else { self.preferred };
            needed.push(lowered.max(self.minimum));
        }
        let candidates = (i + 2..checkpoints.len()).rev();
        candidates
            .into_iter()
            .find(|&j| self.is_clear(proximity, checkpoints[i], checkpoints[j], needed[j - i - 1]))
    }

    fn is_clear(&self, proximity: &ProximityMap, a: Point, b: Point, needed: f64) -> bool {
        let mut before = None;
        all_cells_crossed(a, b, |col, row| {
            let squeezes = before.is_some_and(|(c, r): (i64, i64)| {
                let is_diagonal = c.abs_diff(col) == 1 && r.abs_diff(row) == 1;
                is_diagonal && !(is_free(proximity, c, row) && is_free(proximity, col, r))
            });
            before = Some((col, row));
            distance_at(proximity, col, row).is_some_and(|d| keeps(d, needed))
                && (self.corner_cutting || !squeezes)
        })
    }
}

/// Smallest distance to an obstacle of the cells that a segment crosses; below zero where one is not free.
fn clearance(proximity: &ProximityMap, a: Point, b: Point) -> f64 {
    let mut least = f64::INFINITY;
    all_cells_crossed(a, b, |col, row| {
        least = least.min(distance_at(proximity, col, row).unwrap_or(-1.0));
        true
    });
    least
}

fn is_free(proximity: &ProximityMap, col: i64, row: i64) -> bool {
    distance_at(proximity, col, row).is_some()
}

/// Distance of a free cell to the nearest obstacle.
pub fn distance_at(proximity: &ProximityMap, col: i64, row: i64) -> Option<f64> {
    let size = proximity.size();
    let (col, row) = (usize::try_from(col).ok()?, usize::try_from(row).ok()?);
    if col >= size.width || row >= size.height {
        return None;
    }
    let cell = size.index(col, row);
    (proximity.kinds()[cell] == CellKind::Free).then(|| proximity.distances()[cell])
}

/// Length of a polyline.
pub fn length(points: &[Point]) -> f64 {
    points.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum()
}

/// Smallest distance to an obstacle of the cells that a polyline crosses; below zero where one is not free.
pub fn least_clearance(proximity: &ProximityMap, points: &[Point]) -> f64 {
    points.windows(2).map(|w| clearance(proximity, w[0], w[1])).fold(f64::INFINITY, f64::min)
}
