//! The map as it crosses.

use super::basic::{rumbo_block, rumbo_f32_array};

/// A grid of log-odds in rows, row 0 at the bottom.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_grid {
    /// Bytes of this struct.
    pub size: usize,
    /// Cells along x.
    pub width: u32,
    /// Cells along y.
    pub height: u32,
    /// Edge of a cell, meters.
    pub resolution_m: f64,
    /// The lower left corner in the map's frame: x and y in meters, turn in radians.
    pub origin: [f64; 3],
    /// A cell with more log-odds than this is occupied.
    pub occupied_above: f32,
    /// A cell with less log-odds than this is free; between the two it is unknown.
    pub free_below: f32,
    /// `width` times `height` cells.
    pub cells: rumbo_f32_array,
}

/// A straight piece of wall.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_line {
    /// One end in the map's frame, meters.
    pub from: [f64; 2],
    /// The other end.
    pub to: [f64; 2],
    /// Covariance of the normal form: distance (m²), distance and angle (m·rad), angle (rad²).
    pub covariance: [f64; 3],
}

/// A shared array of lines, as `rumbo_f32_array`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_line_array {
    /// The block that holds the elements; null for none.
    pub block: *mut rumbo_block,
    /// Number of lines.
    pub len: usize,
    /// The lines.
    pub data: *const rumbo_line,
}

/// A point that can be recognized.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_landmark {
    /// Which one it is.
    pub identity: u32,
    /// What kind of thing it is.
    pub kind: u32,
    /// Where it is in the map's frame, meters.
    pub position: [f64; 2],
    /// Covariance xx, xy, yy, m².
    pub covariance: [f64; 3],
}

/// A shared array of landmarks, as `rumbo_f32_array`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_landmark_array {
    /// The block that holds the elements; null for none.
    pub block: *mut rumbo_block,
    /// Number of landmarks.
    pub len: usize,
    /// The landmarks.
    pub data: *const rumbo_landmark,
}

/// A cube of 16 x 16 x 16 voxels.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_voxel_chunk {
    /// Which cube, counted in cubes from the origin.
    pub index: [i32; 3],
    /// 0.
    pub reserved: i32,
    /// Log-odds, x fastest, then y, then z.
    pub log_odds: rumbo_f32_array,
}

/// Occupancy in space.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_voxels {
    /// Bytes of this struct.
    pub size: usize,
    /// Edge of a voxel, meters.
    pub resolution_m: f64,
    /// Lower corner of voxel (0, 0, 0) in the map's frame, meters.
    pub origin: [f64; 3],
    /// Number of cubes.
    pub n_chunks: usize,
    /// The cubes.
    pub chunks: *const rumbo_voxel_chunk,
}

/// The map, to be read. Layers that are not there are null.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_map {
    /// Bytes of this struct.
    pub size: usize,
    /// Goes up with every change.
    pub version: u64,
    /// Occupancy of cells.
    pub grid: *const rumbo_grid,
    /// Number of coarser grids.
    pub n_coarse: usize,
    /// Bytes from one coarser grid to the next.
    pub coarse_stride: usize,
    /// The same area at twice, four times, ... the cell's edge.
    pub coarse: *const rumbo_grid,
    /// Wall lines.
    pub lines: *const rumbo_line_array,
    /// Points that can be recognized.
    pub landmarks: *const rumbo_landmark_array,
    /// Occupancy in space.
    pub voxels: *const rumbo_voxels,
}

/// The map, to be written: the host's own, through `map_take_...` and `map_put_...` of the host table. Take a layer,
/// change it, put it back; what is taken and not put back is gone.
#[repr(C)]
pub struct rumbo_map_mut {
    _private: [u8; 0],
}
