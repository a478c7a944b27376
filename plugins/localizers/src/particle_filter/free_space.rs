//! Where a robot can be: places for particles that may be anywhere.

use rand::RngExt;
use rumbo_core::map::{Cell, CellClass, Grid};
use rumbo_core::rng::Rng;
use rumbo_kit::GridSize;
use rumbo_kit::distance_field::squared_distance_field;
use std::f64::consts::TAU;

/// The free cells of a map that keep a distance from what is occupied.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FreeSpace {
    cells: Vec<u32>,
}

impl FreeSpace {
    /// Free cells whose middle is at least this far from that of every occupied cell, meters; all free cells where none
    /// is.
    pub fn of(grid: &Grid, clearance_m: f64) -> FreeSpace {
        let size = GridSize::new(grid.width() as usize, grid.height() as usize);
        let is = |class: CellClass| move |log_odds: &f32| grid.class_of(*log_odds) == class;
        let occupied: Vec<u8> = grid.cells.iter().map(is(CellClass::Occupied)).map(u8::from).collect();
        let squared = squared_distance_field(size, &occupied);
        let reach = (clearance_m / grid.resolution_m()).powi(2);
        let free = || (0_u32..).zip(grid.cells.iter()).filter(|(_, cell)| is(CellClass::Free)(cell));
        let with_clearance = |(index, _): &(u32, &f32)| f64::from(squared[*index as usize]) >= reach;
        let mut cells: Vec<u32> = free().filter(with_clearance).map(|(index, _)| index).collect();
        if cells.is_empty() {
            cells = free().map(|(index, _)| index).collect();
        }
        FreeSpace { cells }
    }

    /// There is no place at all.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// x, y, yaw in the map: uniform over the free places and the full turn. None where nothing is free.
    pub fn draw(&self, grid: &Grid, rng: &mut Rng) -> Option<[f64; 3]> {
        if self.cells.is_empty() {
            return None;
        }
        let index = self.cells[rng.random_range(0..self.cells.len())];
        Some(pose_in(grid, index, rng.random::<f64>() * TAU, rng))
    }

    /// `n` poses that cover free places and headings evenly: every equal part of both gets its share, so that no
    /// corner is left out by bad luck. Cells at equal distances in the order of the map, headings by the golden ratio.
    pub fn spread(&self, grid: &Grid, n: usize, rng: &mut Rng) -> Vec<[f64; 3]> {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (first_cell, first_turn) = (rng.random::<f64>(), rng.random::<f64>());
        let pose = |k: usize| {
            let share = (k as f64 + first_cell) / n as f64;
            let cell = ((share * self.cells.len() as f64) as usize).min(self.cells.len() - 1);
            let turn = (first_turn + k as f64 * GOLDEN).fract();
            pose_in(grid, self.cells[cell], turn * TAU, rng)
        };
        if self.cells.is_empty() { Vec::new() } else { (0..n).map(pose).collect() }
    }
}

/// Anywhere in a cell.
fn pose_in(grid: &Grid, index: u32, yaw_rad: f64, rng: &mut Rng) -> [f64; 3] {
    let Cell { col, row } = grid.cell_of(index as usize);
    let in_grid = [col, row].map(|edge| (f64::from(edge) + rng.random::<f64>()) * grid.resolution_m());
    let place = grid.map_from_grid() * nalgebra::Point2::from(in_grid);
    [place.x, place.y, yaw_rad]
}
