//! Maps: headers by value, cells by reference.
#![allow(unsafe_code)]

use super::BadView;
use super::array::{CArray, Hold};
use super::basic::read;
use super::observation::slice;
use crate::boundary::abi::*;
use crate::map::{Grid, GridHeader, Landmarks, Lines, Map, VoxelChunk, Voxels};

/// Storage for the view of a map, kept from call to call.
#[derive(Default)]
pub(crate) struct MapLoan {
    grids: Vec<rumbo_grid>,
    lines: Option<rumbo_line_array>,
    landmarks: Option<rumbo_landmark_array>,
    chunks: Vec<rumbo_voxel_chunk>,
    voxels: Option<rumbo_voxels>,
}

// SAFETY: the raw pointers are read only while the map that they were lent from is borrowed.
unsafe impl Send for MapLoan {}

impl MapLoan {
    /// A view that holds until the next call, and as long as the map is not changed.
    pub fn lend(&mut self, map: &Map) -> rumbo_map {
        self.grids.clear();
        self.grids.extend(map.grid.iter().chain(&map.coarse_grids).map(grid_of));
        self.lines = map.lines.as_ref().map(|lines| CArray::lend(&lines.lines));
        self.landmarks = map.landmarks.as_ref().map(|landmarks| CArray::lend(&landmarks.landmarks));
        self.chunks.clear();
        self.voxels = map.voxels.as_ref().map(|voxels| {
            self.chunks.extend(voxels.chunks.iter().map(chunk_of));
            rumbo_voxels {
                size: size_of::<rumbo_voxels>(),
                resolution_m: voxels.resolution_m,
                origin: voxels.origin,
                n_chunks: self.chunks.len(),
                chunks: self.chunks.as_ptr(),
            }
        });
        let n_fine = usize::from(map.grid.is_some());
        rumbo_map {
            size: size_of::<rumbo_map>(),
            version: map.version,
            grid: map.grid.as_ref().map_or(std::ptr::null(), |_| self.grids.as_ptr()),
            n_coarse: self.grids.len() - n_fine,
            coarse_stride: size_of::<rumbo_grid>(),
            coarse: self.grids.as_ptr().wrapping_add(n_fine),
            lines: pointer_to(&self.lines),
            landmarks: pointer_to(&self.landmarks),
            voxels: pointer_to(&self.voxels),
        }
    }
}

/// Where an optional part lies; null where there is none.
pub(crate) fn pointer_to<T>(part: &Option<T>) -> *const T {
    part.as_ref().map_or(std::ptr::null(), std::ptr::from_ref)
}

/// A view of a grid.
pub(crate) fn grid_of(grid: &Grid) -> rumbo_grid {
    grid_view(grid.header(), CArray::lend(&grid.cells))
}

fn grid_view(header: &GridHeader, cells: rumbo_f32_array) -> rumbo_grid {
    let GridHeader { width, height, resolution_m, origin, occupied_above, free_below } = *header;
    let size = size_of::<rumbo_grid>();
    rumbo_grid { size, width, height, resolution_m, origin, occupied_above, free_below, cells }
}

/// Hands a grid over.
pub(crate) fn give_grid(grid: Grid) -> rumbo_grid {
    let header = *grid.header();
    grid_view(&header, CArray::give(grid.cells))
}

/// The grid behind a view.
///
/// # Safety
/// `view` points to a view whose cells are alive.
pub(crate) unsafe fn grid_from(view: *const rumbo_grid, hold: Hold) -> Result<Grid, BadView> {
    // SAFETY: as promised by the caller.
    let view = unsafe { read(view) }.ok_or_else(|| BadView::new("a grid points nowhere"))?;
    // SAFETY: as promised by the caller.
    let cells = unsafe { view.cells.take(hold) }.map_err(|bad| BadView::new(bad.to_string()))?;
    let rumbo_grid { width, height, resolution_m, origin, occupied_above, free_below, .. } = view;
    let header = GridHeader { width, height, resolution_m, origin, occupied_above, free_below };
    Grid::new(header, cells).map_err(|fault| BadView::new(fault.to_string()))
}

/// The grid that is lent behind a view; none where the view is null.
///
/// # Safety
/// `view` is null or points to a view whose cells are alive.
pub(crate) unsafe fn optional_grid_from(view: *const rumbo_grid) -> Result<Option<Grid>, BadView> {
    // SAFETY: as promised by the caller.
    (!view.is_null()).then(|| unsafe { grid_from(view, Hold::Lent) }).transpose()
}

fn chunk_of(chunk: &VoxelChunk) -> rumbo_voxel_chunk {
    rumbo_voxel_chunk { index: chunk.index, reserved: 0, log_odds: CArray::lend(&chunk.log_odds) }
}

/// Hands a cube over.
pub(crate) fn give_chunk(chunk: VoxelChunk) -> rumbo_voxel_chunk {
    rumbo_voxel_chunk { index: chunk.index, reserved: 0, log_odds: CArray::give(chunk.log_odds) }
}

/// The cube behind a view.
///
/// # Safety
/// The view's array is alive.
pub(crate) unsafe fn chunk_from(view: &rumbo_voxel_chunk, hold: Hold) -> Result<VoxelChunk, BadView> {
    // SAFETY: as promised by the caller.
    let log_odds = unsafe { view.log_odds.take(hold) }.map_err(|bad| BadView::new(bad.to_string()))?;
    Ok(VoxelChunk { index: view.index, log_odds })
}

/// The map behind a view; its arrays are shared.
///
/// # Safety
/// `view` points to a view whose parts are alive.
pub(crate) unsafe fn map_from(view: *const rumbo_map) -> Result<Map, BadView> {
    // SAFETY: for all blocks below: as promised by the caller.
    let view = unsafe { read(view) }.ok_or_else(|| BadView::new("the map points nowhere"))?;
    let grid = unsafe { optional_grid_from(view.grid)? };
    let mut map = Map { version: view.version, grid, ..Map::default() };
    for idx in 0..view.n_coarse {
        let at = view.coarse.cast::<u8>().wrapping_add(idx * view.coarse_stride).cast::<rumbo_grid>();
        map.coarse_grids.push(unsafe { grid_from(at, Hold::Lent)? });
    }
    let bad = |bad: super::BadArray| BadView::new(bad.to_string());
    if let Some(lines) = unsafe { view.lines.as_ref() } {
        map.lines = Some(Lines { lines: unsafe { lines.take(Hold::Lent) }.map_err(bad)? });
    }
    if let Some(landmarks) = unsafe { view.landmarks.as_ref() } {
        map.landmarks = Some(Landmarks { landmarks: unsafe { landmarks.take(Hold::Lent) }.map_err(bad)? });
    }
    if let Some(voxels) = unsafe { read(view.voxels) } {
        let chunks = unsafe { slice(voxels.chunks, voxels.n_chunks)? };
        let chunks = chunks.iter().map(|chunk| unsafe { chunk_from(chunk, Hold::Lent) });
        let chunks = chunks.collect::<Result<_, _>>()?;
        map.voxels = Some(Voxels { resolution_m: voxels.resolution_m, origin: voxels.origin, chunks });
    }
    Ok(map)
}
