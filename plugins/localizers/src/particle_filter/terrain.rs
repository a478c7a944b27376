//! The map as the filter sees it: what scans can hit, where a robot can be.

use super::beams::ScanBeams;
use super::free_space::FreeSpace;
use super::measurement::{MeasurementModel, Obstacles, ScanLikelihood};
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::map::{CellClass, Grid};
use rumbo_kit::GridSize;
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::occupancy::line_cells;

/// Everything that is computed once for a version of the map.
pub struct Terrain {
    /// Version of the map that it was made of.
    pub version: u64,
    /// Places for particles that may be anywhere.
    pub free: FreeSpace,
    /// The measurement model on this map.
    pub likelihood: Box<dyn ScanLikelihood>,
    /// Some cell is occupied: without any, scans say nothing.
    pub has_obstacles: bool,
    size: GridSize,
    grid_from_map: Pose2,
    resolution_m: f64,
    /// Log-weight that being in each cell costs.
    penalties: Vec<f32>,
    outside_penalty: f32,
    /// Free cells far from everything on the map.
    bare: Vec<bool>,
}

/// Log-weights that impossible places cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Penalties {
    /// In an occupied cell or off the map.
    pub occupied: f64,
    /// In a cell that nobody has seen.
    pub unknown: f64,
}

/// A beam may end this far behind an obstacle and still have met it: its place is known to some centimeters, and walls
/// that it grazes are met far from where they were expected.
const LEAST_SLACK_M: f64 = 0.5;
/// The same as a share of the range.
const SLACK_SHARE: f64 = 0.2;

/// How far from where the map lets expect it a beam may end and still have met the same wall, meters.
pub fn slack_m(range_m: f64) -> f64 {
    LEAST_SLACK_M.max(SLACK_SHARE * range_m)
}

impl Terrain {
    /// Prepares a map.
    pub fn new(
        version: u64,
        grid: &Grid,
        model: &dyn MeasurementModel,
        clearance_m: f64,
        bare_beyond_m: f64,
        penalties: Penalties,
    ) -> Terrain {
        let size = GridSize::new(grid.width() as usize, grid.height() as usize);
        let occupied: Vec<u8> =
            grid.cells.iter().map(|v| u8::from(grid.class_of(*v) == CellClass::Occupied)).collect();
        let obstacles = Obstacles { size, resolution_m: grid.resolution_m(), occupied: &occupied };
        let penalty = |log_odds: &f32| match grid.class_of(*log_odds) {
            CellClass::Free => 0.0,
            CellClass::Occupied => penalties.occupied as f32,
            CellClass::Unknown => penalties.unknown as f32,
        };
        let reach = (bare_beyond_m / grid.resolution_m()).powi(2);
        let is_bare = |(distance2, cell): (u32, &f32)| {
            bare_beyond_m > 0.0 && f64::from(distance2) > reach && grid.class_of(*cell) == CellClass::Free
        };
        let bare =
            squared_distance_field(size, &occupied).into_iter().zip(grid.cells.iter()).map(is_bare).collect();
        Terrain {
            version,
            free: FreeSpace::of(grid, clearance_m),
            likelihood: model.on_map(&obstacles),
            has_obstacles: occupied.contains(&1),
            size,
            grid_from_map: grid.grid_from_map(),
            resolution_m: grid.resolution_m(),
            penalties: grid.cells.iter().map(penalty).collect(),
            outside_penalty: penalties.occupied as f32,
            bare,
        }
    }

    /// x and y in cells and heading in the grid's own frame of a pose in the map.
    #[inline]
    pub fn in_grid(&self, [x_m, y_m, yaw_rad]: [f64; 3]) -> [f64; 3] {
        let place = self.grid_from_map * Point2::new(x_m, y_m) / self.resolution_m;
        [place.x, place.y, yaw_rad + self.grid_from_map.rotation.angle()]
    }

    /// Log-weight that being at a place (in cells) costs.
    #[inline]
    pub fn penalty(&self, x: f32, y: f32) -> f64 {
        let (width, height) = (self.size.width as f32, self.size.height as f32);
        let is_inside = x >= 0.0 && y >= 0.0 && x < width && y < height;
        let cell = if is_inside { self.penalties.get(self.size.index(x as usize, y as usize)) } else { None };
        f64::from(*cell.unwrap_or(&self.outside_penalty))
    }

    /// Share of the beams of all scans that would pass through an obstacle of the map on their way; none if no beam hit
    /// anything. Whatever the map does not show makes beams shorter, never longer: only a wrong place makes many of them
    /// pass through walls.
    pub fn contradicted(&self, scans: &[ScanBeams], map_from_base: &Pose2) -> Option<f64> {
        let (mut n_through, mut n_hits) = (0, 0);
        for scan in scans {
            let sensor = map_from_base * Point2::from(scan.origin);
            for (direction, range_m) in scan.hits(scan.max_range_m) {
                n_hits += 1;
                let ahead = map_from_base.rotation * nalgebra::Vector2::from(direction);
                n_through +=
                    usize::from(self.is_blocked(sensor, sensor + ahead * (range_m - slack_m(range_m))));
            }
        }
        (n_hits > 0).then(|| n_through as f64 / n_hits as f64)
    }

    /// Whether a point of the map is on free floor, and nothing on the map is near.
    pub fn is_bare(&self, point: Point2) -> bool {
        let [x, y, _] = self.in_grid([point.x, point.y, 0.0]);
        let is_inside = x >= 0.0 && y >= 0.0 && x < self.size.width as f64 && y < self.size.height as f64;
        is_inside && self.bare.get(self.size.index(x as usize, y as usize)).is_some_and(|is_bare| *is_bare)
    }

    /// Whether an occupied cell lies between two points of the map.
    pub fn is_blocked(&self, from: Point2, to: Point2) -> bool {
        let cell = |point: Point2| {
            let [x, y, _] = self.in_grid([point.x, point.y, 0.0]);
            [x.floor() as i32, y.floor() as i32]
        };
        let mut is_blocked = false;
        line_cells(self.size, cell(from), cell(to), |index| {
            is_blocked |= self.penalties.get(index).is_some_and(|penalty| *penalty >= self.outside_penalty);
        });
        is_blocked
    }

    /// Share of the beams of all scans that the map explains from a pose; none if no beam says anything.
    pub fn explained(&self, scans: &[ScanBeams], map_from_base: &Pose2) -> Option<f64> {
        let place = map_from_base.translation.vector;
        let pose = self.in_grid([place.x, place.y, map_from_base.rotation.angle()]);
        let count = |[near, all]: [usize; 2], scan: &ScanBeams| {
            let [n, of] = self.likelihood.explained(scan, pose);
            [near + n, all + of]
        };
        let [near, all] = scans.iter().fold([0, 0], count);
        (all > 0).then(|| near as f64 / all as f64)
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::particle_filter::measurement::FieldModel;
    use rumbo_core::frames::pose2;

    /// A room of 4 m by 4 m with walls of one cell, from (0, 0).
    fn room() -> Terrain {
        room_with(|_, _| false)
    }

    /// That room with more walls, by column and row.
    pub fn room_with(is_wall_too: fn(usize, usize) -> bool) -> Terrain {
        let mut grid = Grid::unknown(40, 40, 0.1).unwrap();
        for (index, cell) in grid.cells.make_mut().iter_mut().enumerate() {
            let (col, row) = (index % 40, index / 40);
            let is_wall = [col, row].iter().any(|place| *place == 0 || *place == 39) || is_wall_too(col, row);
            *cell = if is_wall { Grid::CERTAIN } else { -Grid::CERTAIN };
        }
        let penalties = Penalties { occupied: 50.0, unknown: 5.0 };
        Terrain::new(1, &grid, &FieldModel::default(), 0.2, 0.2, penalties)
    }

    fn beams(ranges_m: [f64; 4]) -> [ScanBeams; 1] {
        let directions = vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        [ScanBeams { origin: [0.0, 0.0], directions, ranges_m: ranges_m.to_vec(), max_range_m: 8.0 }]
    }

    #[test]
    fn only_beams_that_pass_through_walls_contradict_a_place() {
        let (terrain, middle) = (room(), pose2(2.0, 2.0, 0.0));
        let contradicted = |ranges_m| terrain.contradicted(&beams(ranges_m), &middle);
        assert_eq!(contradicted([1.9; 4]), Some(0.0));
        assert_eq!(contradicted([0.4, 0.8, 1.2, 1.9]), Some(0.0), "somebody stands before the walls");
        assert_eq!(contradicted([2.2; 4]), Some(0.0), "the place is known to some centimeters");
        assert_eq!(contradicted([3.5, 1.9, 1.9, 1.9]), Some(0.25));
        assert_eq!(contradicted([f64::INFINITY; 4]), None);
        let elsewhere = terrain.contradicted(&beams([1.9; 4]), &pose2(3.0, 1.0, 0.0));
        assert_eq!(elsewhere, Some(0.5));
    }
}
