//! The host's map, taken out for one call and put back at its end: whoever writes a layer holds its only reference.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{CArray, Hold, chunk_from, give_chunk, give_grid, grid_from};
use super::host;
use crate::map::{Grid, Landmarks, Lines, Map, VoxelChunk, Voxels};
use std::mem::MaybeUninit;

/// Runs `body` on the host's map.
///
/// # Safety
/// `handle` is the map of the present call. `body` does not panic.
pub(super) unsafe fn with_map(handle: *mut rumbo_map_mut, body: impl FnOnce(&mut Map) -> i32) -> i32 {
    let Some(host) = host().filter(|_| !handle.is_null()) else { return RUMBO_ERROR };
    // SAFETY: as promised by the caller.
    let mut map = unsafe { take(host, handle) };
    let code = body(&mut map);
    // SAFETY: as promised by the caller.
    unsafe { put(host, handle, map) };
    code
}

/// What a function of the host that hands something out gives.
fn taken<T>(take: impl FnOnce(*mut T) -> i32) -> Option<T> {
    let mut to = MaybeUninit::<T>::uninit();
    // SAFETY: the host writes before it says that it has.
    (take(to.as_mut_ptr()) == RUMBO_OK).then(|| unsafe { to.assume_init() })
}

/// # Safety
/// `handle` is the map of the present call.
unsafe fn take(host: &rumbo_host, handle: *mut rumbo_map_mut) -> Map {
    // SAFETY: for all blocks below: as promised by the caller; what is taken comes with its reference.
    let grid = |level| {
        let view = taken(|to| unsafe { (host.map_take_grid)(handle, level, to) })?;
        unsafe { grid_from(&raw const view, Hold::Given) }.ok()
    };
    let mut coarse_grids: Vec<Grid> = std::iter::from_fn(|| grid(1)).collect();
    // The last is taken first.
    coarse_grids.reverse();
    let lines = taken(|to| unsafe { (host.map_take_lines)(handle, to) });
    let landmarks = taken(|to| unsafe { (host.map_take_landmarks)(handle, to) });
    Map {
        version: unsafe { (host.map_version)(handle) },
        grid: grid(0),
        coarse_grids,
        lines: lines.and_then(|l| unsafe { l.take(Hold::Given) }.ok()).map(|lines| Lines { lines }),
        landmarks: landmarks
            .and_then(|l| unsafe { l.take(Hold::Given) }.ok())
            .map(|landmarks| Landmarks { landmarks }),
        voxels: unsafe { take_voxels(host, handle) },
    }
}

/// # Safety
/// `handle` is the map of the present call.
unsafe fn take_voxels(host: &rumbo_host, handle: *mut rumbo_map_mut) -> Option<Voxels> {
    let (mut resolution_m, mut origin, mut n_chunks) = (0.0, [0.0; 3], 0usize);
    // SAFETY: for all blocks below: as promised by the caller.
    let code =
        unsafe { (host.map_voxels)(handle, &raw mut resolution_m, origin.as_mut_ptr(), &raw mut n_chunks) };
    if code != RUMBO_OK {
        return None;
    }
    let next = || {
        let view = taken(|to| unsafe { (host.map_take_chunk)(handle, to) })?;
        unsafe { chunk_from(&view, Hold::Given) }.ok()
    };
    let mut chunks: Vec<VoxelChunk> = std::iter::from_fn(next).take(n_chunks).collect();
    chunks.reverse();
    Some(Voxels { resolution_m, origin, chunks })
}

/// # Safety
/// `handle` is the map of the present call.
unsafe fn put(host: &rumbo_host, handle: *mut rumbo_map_mut, map: Map) {
    // SAFETY: for the whole block: as promised by the caller; what is put is given with its reference.
    unsafe {
        match map.grid {
            None => (host.map_remove)(handle, RUMBO_LAYER_GRID),
            Some(grid) => {
                let view = give_grid(grid);
                (host.map_put_grid)(handle, 0, &raw const view);
            }
        }
        for grid in map.coarse_grids {
            let view = give_grid(grid);
            (host.map_put_grid)(handle, 1, &raw const view);
        }
        match map.lines {
            None => (host.map_remove)(handle, RUMBO_LAYER_LINES),
            Some(lines) => {
                let view: rumbo_line_array = CArray::give(lines.lines);
                (host.map_put_lines)(handle, &raw const view);
            }
        }
        match map.landmarks {
            None => (host.map_remove)(handle, RUMBO_LAYER_LANDMARKS),
            Some(landmarks) => {
                let view: rumbo_landmark_array = CArray::give(landmarks.landmarks);
                (host.map_put_landmarks)(handle, &raw const view);
            }
        }
        match map.voxels {
            None => (host.map_remove)(handle, RUMBO_LAYER_VOXELS),
            Some(voxels) => {
                (host.map_new_voxels)(handle, voxels.resolution_m, voxels.origin.as_ptr());
                for chunk in voxels.chunks {
                    let view = give_chunk(chunk);
                    (host.map_put_chunk)(handle, &raw const view);
                }
            }
        }
        (host.map_set_version)(handle, map.version);
    }
}
