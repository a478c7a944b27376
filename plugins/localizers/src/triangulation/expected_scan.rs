//! What a scanner would see at a pose on the map.

use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::map::{CellClass, Grid};
use rumbo_kit::GridSize;
use rumbo_kit::landmarks::BeamFan;
use rumbo_kit::ray::RayGrid;

/// A map prepared for tracing rays; keeps its memory.
#[derive(Debug, Default)]
pub struct ExpectedScan {
    version: Option<u64>,
    rays: Option<RayGrid>,
    directions: Vec<[f64; 2]>,
    ranges: Vec<f64>,
}

/// A ray that stopped at the edge of a cell lies in it this much farther on, cells.
const INTO_CELL: f64 = 1e-6;

impl ExpectedScan {
    /// Ranges of all beams in meters: infinite where nothing is met, not-a-number where a beam ends at what nobody knows.
    pub fn trace(
        &mut self,
        (version, grid): (u64, &Grid),
        map_from_sensor: &Pose2,
        fan: &BeamFan,
        n_beams: usize,
    ) -> &[f64] {
        if self.version != Some(version) {
            let size = GridSize::new(grid.width() as usize, grid.height() as usize);
            let is_shut = |cell: &f32| u8::from(grid.class_of(*cell) != CellClass::Free);
            let occupied: Vec<u8> = grid.cells.iter().map(is_shut).collect();
            self.rays = Some(RayGrid::new(size, &occupied));
            self.version = Some(version);
        }
        let direction = |k: usize| {
            let (sin, cos) = (fan.first_bearing_rad + fan.bearing_step_rad * k as f64).sin_cos();
            [cos, sin]
        };
        self.directions.clear();
        self.directions.extend((0..n_beams).map(direction));
        self.ranges.clear();
        self.ranges.resize(n_beams, f64::NAN);
        let cell_m = grid.resolution_m();
        let grid_from_sensor = grid.grid_from_map() * map_from_sensor;
        let origin = [grid_from_sensor.translation.x / cell_m, grid_from_sensor.translation.y / cell_m];
        let heading = grid_from_sensor.rotation.angle();
        let reach = fan.max_range_m / cell_m;
        let Some(rays) = &self.rays else { return &self.ranges };
        rays.cast_fan(origin, heading, &self.directions, reach, &mut self.ranges);
        for (range, [x, y]) in self.ranges.iter_mut().zip(&self.directions) {
            if *range >= reach {
                *range = f64::INFINITY;
                continue;
            }
            let ahead_m = (*range + INTO_CELL) * cell_m;
            let end = map_from_sensor * Point2::new(x * ahead_m, y * ahead_m);
            let is_wall = grid.cell_at(end).is_some_and(|cell| grid.class(cell) == CellClass::Occupied);
            *range = if is_wall { *range * cell_m } else { f64::NAN };
        }
        &self.ranges
    }
}
