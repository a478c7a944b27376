//! The map for writing: layers are taken out, changed where they are, and put back.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{CArray, Hold, chunk_from, give_chunk, give_grid, grid_from};
use crate::map::{Landmarks, Lines, Map, Voxels};

/// Hands the map over for one call.
pub(super) fn lend_mut(map: &mut Map) -> *mut rumbo_map_mut {
    std::ptr::from_mut(map).cast()
}

/// # Safety
/// `map` is null or the map of the present call.
unsafe fn of<'a>(map: *mut rumbo_map_mut) -> Option<&'a mut Map> {
    // SAFETY: as promised by the caller.
    unsafe { map.cast::<Map>().as_mut() }
}

/// Gives something out, or says that it is not there.
///
/// # Safety
/// `out` is null or points to a variable of the plugin.
unsafe fn hand_out<T>(found: Option<T>, out: *mut T) -> i32 {
    match found {
        Some(found) if !out.is_null() => {
            // SAFETY: as promised by the caller.
            unsafe { out.write(found) };
            RUMBO_OK
        }
        _ => RUMBO_MISSING,
    }
}

pub(super) unsafe extern "C" fn version(map: *const rumbo_map_mut) -> u64 {
    // SAFETY: the map of the present call.
    unsafe { of(map.cast_mut()) }.map_or(0, |map| map.version)
}

pub(super) unsafe extern "C" fn set_version(map: *mut rumbo_map_mut, version: u64) {
    // SAFETY: the map of the present call.
    if let Some(map) = unsafe { of(map) } {
        map.version = version;
    }
}

pub(super) unsafe extern "C" fn n_coarse(map: *const rumbo_map_mut) -> usize {
    // SAFETY: the map of the present call.
    unsafe { of(map.cast_mut()) }.map_or(0, |map| map.coarse_grids.len())
}

pub(super) unsafe extern "C" fn take_grid(map: *mut rumbo_map_mut, level: u32, out: *mut rumbo_grid) -> i32 {
    // SAFETY: the map of the present call.
    let Some(map) = (unsafe { of(map) }).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
    let grid = if level == 0 { map.grid.take() } else { map.coarse_grids.pop() };
    // SAFETY: the plugin's own variable.
    unsafe { hand_out(grid.map(give_grid), out) }
}

pub(super) unsafe extern "C" fn put_grid(
    map: *mut rumbo_map_mut,
    level: u32,
    grid: *const rumbo_grid,
) -> i32 {
    // SAFETY: the map of the present call, and a grid whose reference is given.
    let (Some(map), Ok(grid)) = (unsafe { (of(map), grid_from(grid, Hold::Given)) }) else {
        return RUMBO_BAD_NUMBER;
    };
    match level {
        0 => map.grid = Some(grid),
        _ => map.coarse_grids.push(grid),
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn take_lines(map: *mut rumbo_map_mut, out: *mut rumbo_line_array) -> i32 {
    // SAFETY: the map of the present call, and the plugin's own variable.
    unsafe {
        let Some(map) = of(map).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
        hand_out(map.lines.take().map(|lines| CArray::give(lines.lines)), out)
    }
}

pub(super) unsafe extern "C" fn put_lines(map: *mut rumbo_map_mut, lines: *const rumbo_line_array) -> i32 {
    // SAFETY: the map of the present call, and an array whose reference is given.
    unsafe {
        let (Some(map), Some(Ok(lines))) = (of(map), lines.as_ref().map(|lines| lines.take(Hold::Given)))
        else {
            return RUMBO_BAD_NUMBER;
        };
        map.lines = Some(Lines { lines });
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn take_landmarks(
    map: *mut rumbo_map_mut,
    out: *mut rumbo_landmark_array,
) -> i32 {
    // SAFETY: the map of the present call, and the plugin's own variable.
    unsafe {
        let Some(map) = of(map).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
        hand_out(map.landmarks.take().map(|landmarks| CArray::give(landmarks.landmarks)), out)
    }
}

pub(super) unsafe extern "C" fn put_landmarks(
    map: *mut rumbo_map_mut,
    landmarks: *const rumbo_landmark_array,
) -> i32 {
    // SAFETY: the map of the present call, and an array whose reference is given.
    unsafe {
        let taken = landmarks.as_ref().map(|landmarks| landmarks.take(Hold::Given));
        let (Some(map), Some(Ok(landmarks))) = (of(map), taken) else { return RUMBO_BAD_NUMBER };
        map.landmarks = Some(Landmarks { landmarks });
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn voxels(
    map: *const rumbo_map_mut,
    resolution_m: *mut f64,
    origin: *mut f64,
    n_chunks: *mut usize,
) -> i32 {
    // SAFETY: the map of the present call.
    let Some(voxels) = (unsafe { of(map.cast_mut()) }).and_then(|map| map.voxels.as_ref()) else {
        return RUMBO_MISSING;
    };
    if resolution_m.is_null() || origin.is_null() || n_chunks.is_null() {
        return RUMBO_ERROR;
    }
    // SAFETY: the plugin's own variables; the origin has three numbers.
    unsafe {
        resolution_m.write(voxels.resolution_m);
        origin.cast::<[f64; 3]>().write(voxels.origin);
        n_chunks.write(voxels.chunks.len());
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn take_chunk(map: *mut rumbo_map_mut, out: *mut rumbo_voxel_chunk) -> i32 {
    // SAFETY: the map of the present call, and the plugin's own variable.
    unsafe {
        let Some(map) = of(map).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
        hand_out(map.voxels.as_mut().and_then(|voxels| voxels.chunks.pop()).map(give_chunk), out)
    }
}

pub(super) unsafe extern "C" fn new_voxels(
    map: *mut rumbo_map_mut,
    resolution_m: f64,
    origin: *const f64,
) -> i32 {
    // SAFETY: the map of the present call, and three numbers of the plugin.
    unsafe {
        let Some(map) = of(map).filter(|_| !origin.is_null()) else { return RUMBO_ERROR };
        let origin = origin.cast::<[f64; 3]>().read();
        map.voxels = Some(Voxels { resolution_m, origin, chunks: Vec::new() });
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn put_chunk(map: *mut rumbo_map_mut, chunk: *const rumbo_voxel_chunk) -> i32 {
    // SAFETY: the map of the present call, and an array whose reference is given.
    unsafe {
        let chunk = chunk.as_ref().map(|chunk| chunk_from(chunk, Hold::Given));
        let voxels = of(map).and_then(|map| map.voxels.as_mut());
        let (Some(voxels), Some(Ok(chunk))) = (voxels, chunk) else { return RUMBO_BAD_NUMBER };
        voxels.chunks.push(chunk);
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn remove(map: *mut rumbo_map_mut, layer: u32) {
    // SAFETY: the map of the present call.
    let Some(map) = (unsafe { of(map) }) else { return };
    match layer {
        RUMBO_LAYER_GRID => {
            map.grid = None;
            map.coarse_grids.clear();
        }
        RUMBO_LAYER_LINES => map.lines = None,
        RUMBO_LAYER_LANDMARKS => map.landmarks = None,
        RUMBO_LAYER_VOXELS => map.voxels = None,
        _ => {}
    }
}
