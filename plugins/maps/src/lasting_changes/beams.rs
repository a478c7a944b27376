//! The beams of a scan on a raster, and the cells that a beam sees through.

use rumbo_core::frames::{Pose2, Pose3, lift};
use rumbo_core::messages::LaserScan;

/// A beam, in cells of a raster.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// The scanner.
    pub from: [f64; 2],
    /// Where it ends: at something, or where its place becomes too unsure.
    pub to: [f64; 2],
    /// It ends at something.
    pub is_hit: bool,
}

impl Beam {
    /// The point so many cells behind its end.
    pub fn behind_end(&self, cells: f64) -> [f64; 2] {
        let way = [self.to[0] - self.from[0], self.to[1] - self.from[1]];
        let length = way[0].hypot(way[1]);
        let part = if length > 0.0 { cells / length } else { 0.0 };
        [self.to[0] + part * way[0], self.to[1] + part * way[1]]
    }
}

/// The beams of one scan. Kept between scans, so that a warm one allocates nothing.
#[derive(Debug, Clone, Default)]
pub struct BeamFan {
    /// Those that say something.
    pub beams: Vec<Beam>,
}

impl BeamFan {
    /// Places a scan: `grid_from_base` in meters, ends as `to_raster` makes them of the grid's cells. Beams are cut at
    /// `reach_m`. One without an end says nothing: glass and black look like that as well.
    pub fn place(
        &mut self,
        scan: &LaserScan,
        grid_from_base: &Pose2,
        base_from_sensor: &Pose3,
        resolution_m: f64,
        reach_m: f64,
        to_raster: impl Fn([f64; 2]) -> [f64; 2],
    ) {
        let grid_from_sensor = lift(grid_from_base) * base_from_sensor;
        let axes = grid_from_sensor.rotation.to_rotation_matrix();
        let origin = grid_from_sensor.translation;
        let from = to_raster([origin.x / resolution_m, origin.y / resolution_m]);
        self.beams.clear();
        self.beams.extend(scan.hits().map(|(bearing_rad, range_m)| {
            let (sine, cosine) = bearing_rad.sin_cos();
            let seen_m = range_m.min(reach_m);
            let along = [0, 1].map(|axis| axes[(axis, 0)] * cosine + axes[(axis, 1)] * sine);
            let to = [0, 1].map(|axis| from[axis] + along[axis] * seen_m / resolution_m);
            Beam { from, to, is_hit: range_m <= reach_m }
        }));
    }
}

/// Visits every cell on the way from one point to another with the lengths along it, in cells, at which the way enters and
/// leaves it. Amanatides and Woo, "A fast voxel traversal algorithm for ray tracing" (1987); each crossing is computed from
/// the start, so that errors do not add up.
pub fn cells_on(from: [f64; 2], to: [f64; 2], mut visit: impl FnMut([i64; 2], f64, f64)) {
    let way = [to[0] - from[0], to[1] - from[1]];
    let length = way[0].hypot(way[1]);
    if !length.is_finite() || length == 0.0 {
        return;
    }
    let direction = way.map(|part| part / length);
    let mut cell = from.map(|part| part.floor() as i64);
    let step = direction.map(|part| if part < 0.0 { -1i64 } else { 1 });
    let crossing = |cell: [i64; 2], axis: usize| {
        if direction[axis] == 0.0 {
            return f64::INFINITY;
        }
        let edge = if step[axis] > 0 { cell[axis] + 1 } else { cell[axis] };
        (edge as f64 - from[axis]) / direction[axis]
    };
    let mut entered = 0.0;
    while entered < length {
        let (to_x, to_y) = (crossing(cell, 0), crossing(cell, 1));
        let left = to_x.min(to_y).min(length).max(entered);
        visit(cell, entered, left);
        let axis = usize::from(to_y < to_x);
        cell[axis] += step[axis];
        entered = to_x.min(to_y).max(entered);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// By many small steps along the way.
    fn sampled(from: [f64; 2], to: [f64; 2]) -> BTreeMap<[i64; 2], f64> {
        const N: usize = 200_000;
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let mut lengths = BTreeMap::new();
        for k in 0..N {
            let share = (k as f64 + 0.5) / N as f64;
            let at = [0, 1].map(|axis| (from[axis] + share * (to[axis] - from[axis])).floor() as i64);
            *lengths.entry(at).or_insert(0.0) += length / N as f64;
        }
        lengths
    }

    #[test]
    fn every_cell_of_a_way_is_visited_over_the_length_that_small_steps_say() {
        let ways = [
            ([0.3, 0.2], [17.9, 5.1]),
            ([9.7, 8.1], [-3.2, 8.3]),
            ([2.5, 9.5], [2.5, -4.2]),
            ([4.4, 4.6], [-2.1, -9.9]),
            ([1.2, 7.7], [1.3, 7.9]),
        ];
        for (from, to) in ways {
            let mut found = BTreeMap::new();
            cells_on(from, to, |cell, enter, leave| {
                *found.entry(cell).or_insert(0.0) += leave - enter;
            });
            for (cell, length) in sampled(from, to) {
                let visited = found.remove(&cell).unwrap_or(-1.0);
                assert!((visited - length).abs() < 1e-3, "{from:?} to {to:?}: {cell:?} {visited} {length}");
            }
            assert!(found.values().all(|length| *length < 1e-3), "{found:?}");
        }
    }

    #[test]
    fn a_way_of_no_length_or_without_numbers_visits_nothing() {
        for to in [[1.0, 1.0], [f64::NAN, 2.0], [f64::INFINITY, 2.0]] {
            cells_on([1.0, 1.0], to, |cell, _, _| panic!("{cell:?}"));
        }
    }
}
