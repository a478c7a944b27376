//! What earlier visits saw that is not as the map has it, and what of it became part of the map.

use super::evidence::Verdict;
use super::raster::Raster;
use rumbo_core::map::{CellClass, Grid};
use std::collections::BTreeMap;

/// What is remembered of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CellMemory {
    /// What it became by what was learned; none where the map is as it was made.
    pub learned: Option<Verdict>,
    /// Visits in a row that saw something stand where the map has nothing.
    pub occupied_visits: u8,
    /// Visits in a row that saw through what the map has there.
    pub free_visits: u8,
}

/// What visits to one map left.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Memory {
    /// How many there were.
    pub n_visits: u32,
    /// Cells of which something is remembered, by their index in the raster.
    pub cells: BTreeMap<usize, CellMemory>,
    /// Of each cell, whether a laser ever met there what the map shows.
    pub was_met: Vec<bool>,
}

impl Verdict {
    /// As a class of a map.
    pub fn class(self) -> CellClass {
        match self {
            Verdict::Occupied => CellClass::Occupied,
            Verdict::Free => CellClass::Free,
        }
    }

    /// Log-odds of a cell that is surely so.
    pub fn log_odds(self) -> f32 {
        match self {
            Verdict::Occupied => Grid::CERTAIN,
            Verdict::Free => -Grid::CERTAIN,
        }
    }
}

impl Memory {
    /// Of a raster that nobody has visited.
    pub fn blank(n_cells: usize) -> Memory {
        Memory { n_visits: 0, cells: BTreeMap::new(), was_met: vec![false; n_cells] }
    }

    /// What is remembered of a cell.
    pub fn cell(&self, index: usize) -> CellMemory {
        self.cells.get(&index).copied().unwrap_or_default()
    }

    /// Cells that were changed by what was learned.
    pub fn learned(&self) -> impl Iterator<Item = (usize, Verdict)> + '_ {
        self.cells.iter().filter_map(|(index, cell)| Some((*index, cell.learned?)))
    }

    /// Cells that differ from the map since the last visits, but not in enough of them.
    pub fn unconfirmed(&self) -> impl Iterator<Item = (usize, Verdict)> + '_ {
        self.cells.iter().filter_map(|(index, cell)| match (cell.occupied_visits, cell.free_visits) {
            (0, 0) => None,
            (0, _) => Some((*index, Verdict::Free)),
            _ => Some((*index, Verdict::Occupied)),
        })
    }

    /// Makes the raster as what was learned says; does nothing to one that was saved with it.
    pub fn apply(&self, raster: &mut Raster) {
        for (index, learned) in self.learned() {
            if let Some(class) = raster.classes.get_mut(index) {
                *class = learned.class();
            }
        }
    }
}
