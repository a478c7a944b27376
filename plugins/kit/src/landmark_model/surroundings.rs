//! Scans on a map, and the landmarks in them.

use super::look::Look;
use crate::GridSize;
use crate::landmarks::{Extractor, Landmark, LandmarkSettings, Reading};
use crate::ray::RayGrid;
use rumbo_core::map::{CellClass, Grid};
use std::f64::consts::TAU;

/// How a model is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelSettings {
    /// Rays all around from each cell.
    pub n_rays: usize,
    /// Reach of a ray, meters.
    pub range_m: f64,
    /// When something is a landmark.
    pub landmarks: LandmarkSettings,
}

impl ModelSettings {
    /// From one ray to the next, radians.
    pub fn step_rad(&self) -> f64 {
        TAU / self.n_rays.max(1) as f64
    }
}

/// A map prepared for scans: what is not free stops a ray, and only what is occupied is a reading.
#[derive(Debug, Clone)]
pub struct Surroundings {
    rays: RayGrid,
    size: GridSize,
    cell_m: f64,
    is_occupied: Vec<u8>,
}

/// A ray that stopped at the edge of a cell lies in it this much farther on, cells.
const INTO_CELL: f64 = 1e-6;

impl Surroundings {
    /// The surroundings that a map shows.
    pub fn new(grid: &Grid) -> Surroundings {
        let size = GridSize::new(grid.width() as usize, grid.height() as usize);
        let class = |cell: &f32| grid.class_of(*cell);
        let is_shut: Vec<u8> =
            grid.cells.iter().map(|cell| u8::from(class(cell) != CellClass::Free)).collect();
        let is_occupied =
            grid.cells.iter().map(|cell| u8::from(class(cell) == CellClass::Occupied)).collect();
        Surroundings { rays: RayGrid::new(size, &is_shut), size, cell_m: grid.resolution_m(), is_occupied }
    }

    /// Columns and rows.
    pub fn size(&self) -> GridSize {
        self.size
    }

    /// Edge of a cell, meters.
    pub fn cell_m(&self) -> f64 {
        self.cell_m
    }

    /// Whether a robot may stand in this cell.
    pub fn is_free(&self, cell: usize) -> bool {
        let (col, row) = self.size.col_row(cell);
        cell < self.size.n_cells() && !self.rays.is_occupied(col as i64, row as i64)
    }

    /// Ranges from a place (in cells) along unit vectors turned by `heading_rad`, all in the grid's frame, meters: infinite
    /// where nothing is met within `reach_m`, not-a-number where a ray ends at what nobody knows.
    pub fn scan(
        &self,
        origin: [f64; 2],
        heading_rad: f64,
        directions: &[[f64; 2]],
        reach_m: f64,
        ranges_m: &mut Vec<f64>,
    ) {
        let reach = reach_m / self.cell_m;
        ranges_m.clear();
        ranges_m.resize(directions.len(), f64::NAN);
        self.rays.cast_fan(origin, heading_rad, directions, reach, ranges_m);
        let (sin, cos) = heading_rad.sin_cos();
        for (range, [x, y]) in ranges_m.iter_mut().zip(directions) {
            *range = if *range >= reach {
                f64::INFINITY
            } else if self.ends_at_wall(origin, [cos * x - sin * y, sin * x + cos * y], *range) {
                *range * self.cell_m
            } else {
                f64::NAN
            };
        }
    }

    /// A ray through a corner of cells ends at the cell beside it: then the cell behind the corner says nothing.
    fn ends_at_wall(&self, [x, y]: [f64; 2], [along_x, along_y]: [f64; 2], range: f64) -> bool {
        let (x, y) = (x + (range + INTO_CELL) * along_x, y + (range + INTO_CELL) * along_y);
        let back = 2.0 * INTO_CELL;
        let places = [[x, y], [x, y - back * along_y.signum()], [x - back * along_x.signum(), y]];
        let stopped_by = places.into_iter().map(|[x, y]| [x.floor() as i64, y.floor() as i64]);
        let mut shut = stopped_by.filter(|[col, row]| self.rays.is_occupied(*col, *row));
        let Some([col, row]) = shut.next() else { return false };
        let cell = self.size.index(col as usize, row as usize);
        self.is_occupied.get(cell).is_some_and(|cell| *cell != 0)
    }
}

/// Traces the landmarks of cells, in memory that is kept.
#[derive(Debug, Clone)]
pub struct Tracer {
    settings: ModelSettings,
    directions: Vec<[f64; 2]>,
    ranges_m: Vec<f64>,
    extractor: Extractor,
}

impl Tracer {
    /// A tracer with these settings.
    pub fn new(settings: ModelSettings) -> Tracer {
        let direction = |k: usize| {
            let (sin, cos) = (settings.step_rad() * k as f64).sin_cos();
            [cos, sin]
        };
        Tracer {
            settings,
            directions: (0..settings.n_rays).map(direction).collect(),
            ranges_m: Vec::new(),
            extractor: Extractor::new(settings.landmarks),
        }
    }

    /// All landmarks that are seen from the middle of a cell; bearings are in the grid's frame.
    pub fn landmarks_of(&mut self, surroundings: &Surroundings, cell: usize) -> &[Landmark] {
        let (col, row) = surroundings.size.col_row(cell);
        let origin = [col as f64 + 0.5, row as f64 + 0.5];
        let reach_m = self.settings.range_m;
        surroundings.scan(origin, 0.0, &self.directions, reach_m, &mut self.ranges_m);
        let readings = self.ranges_m.iter().zip(&self.directions).map(|(range_m, [x, y])| {
            if range_m.is_finite() {
                Reading { place: [range_m * x, range_m * y], range_m: *range_m }
            } else {
                Reading { place: [0.0; 2], range_m: f64::NAN }
            }
        });
        self.extractor.extract_circular(readings, self.settings.step_rad(), reach_m)
    }

    /// What they look like, without corners, counter-clockwise.
    pub fn looks_of(&mut self, surroundings: &Surroundings, cell: usize) -> impl Iterator<Item = Look> {
        Look::around(self.landmarks_of(surroundings, cell)).into_iter()
    }
}
