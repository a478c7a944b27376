//! The layers beside the grid: wall lines, landmarks, voxels.

use crate::boundary::Buffer;

/// A straight piece of wall. Who goes from its one end to the other has the free side on the right and the wall on the left.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Line {
    /// One end in the map's frame, meters.
    pub from: [f64; 2],
    /// The other end.
    pub to: [f64; 2],
    /// Covariance of the normal form, with the normal into the wall: distance along it (m², the distance may be negative),
    /// distance and angle (m·rad), angle (rad²).
    pub covariance: [f64; 3],
}

/// All lines.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lines {
    /// In no particular order.
    pub lines: Buffer<Line>,
}

/// A point that can be recognized.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Landmark {
    /// Which one it is.
    pub identity: u32,
    /// What kind of thing it is; the plugin that wrote it says what the number means.
    pub kind: u32,
    /// Where it is in the map's frame, meters.
    pub position: [f64; 2],
    /// Covariance xx, xy, yy, m².
    pub covariance: [f64; 3],
}

/// All landmarks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Landmarks {
    /// In no particular order.
    pub landmarks: Buffer<Landmark>,
}

/// A cube of 16 x 16 x 16 voxels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VoxelChunk {
    /// Which cube, counted in cubes from the origin along x, y, z.
    pub index: [i32; 3],
    /// Log-odds, x fastest, then y, then z.
    pub log_odds: Buffer<f32>,
}

/// Occupancy in space, only where something was seen.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Voxels {
    /// Edge of a voxel, meters.
    pub resolution_m: f64,
    /// Lower corner of voxel (0, 0, 0) in the map's frame, meters.
    pub origin: [f64; 3],
    /// The cubes that exist.
    pub chunks: Vec<VoxelChunk>,
}
