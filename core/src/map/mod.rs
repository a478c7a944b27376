//! The map: a version and optional layers, each a plain header and a shared buffer.
//!
//! A clone of a map copies no cells: it is a snapshot whose layers are shared until somebody writes.

mod features;
mod grid;

pub use features::{Landmark, Landmarks, Line, Lines, VoxelChunk, Voxels};
pub use grid::{Cell, CellClass, Grid, GridFault, GridHeader};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The layers a map may have.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Layer {
    /// Occupancy of cells.
    Grid,
    /// Wall lines.
    Lines,
    /// Points that can be recognized.
    Landmarks,
    /// Occupancy in space.
    Voxels,
}

impl Layer {
    /// The word used in messages and files.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Grid => "grid",
            Layer::Lines => "lines",
            Layer::Landmarks => "landmarks",
            Layer::Voxels => "voxels",
        }
    }
}

/// What the robot knows of its surroundings, in the frame `map`.
#[doc(alias = "nav_msgs/OccupancyGrid")]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Map {
    /// Goes up with every change, so that a stage can tell that what it computed from the map is stale.
    pub version: u64,
    /// Occupancy of cells.
    pub grid: Option<Grid>,
    /// The same area at twice, four times, ... the edge of `grid`'s cells, each made from the scans themselves, for
    /// matching from coarse to fine; empty where no builder makes them.
    pub coarse_grids: Vec<Grid>,
    /// Wall lines.
    pub lines: Option<Lines>,
    /// Points that can be recognized.
    pub landmarks: Option<Landmarks>,
    /// Occupancy in space.
    pub voxels: Option<Voxels>,
}

impl Map {
    /// This layer is there.
    pub fn has(&self, layer: Layer) -> bool {
        match layer {
            Layer::Grid => self.grid.is_some(),
            Layer::Lines => self.lines.is_some(),
            Layer::Landmarks => self.landmarks.is_some(),
            Layer::Voxels => self.voxels.is_some(),
        }
    }

    /// Says that a layer changed.
    pub fn touch(&mut self) {
        self.version += 1;
    }
}
