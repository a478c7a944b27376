//! The map for writing: layers are taken out, changed where they are, and put back.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{
    BadView, CArray, Hold, chunk_from, give_chunk, give_grid, grid_from, layers_from,
};
use crate::map::{Landmarks, Lines, Map, Voxels};
use std::ffi::c_void;

/// The map during one call.
pub(super) struct MapHandle<'a> {
    map: &'a mut Map,
    /// Layers that were taken and neither put back nor removed.
    out: u32,
}

impl<'a> MapHandle<'a> {
    /// For one call.
    pub fn new(map: &'a mut Map) -> MapHandle<'a> {
        MapHandle { map, out: 0 }
    }

    /// The handle; holds as long as this is borrowed.
    pub fn lend(&mut self) -> *mut rumbo_map_mut {
        std::ptr::from_mut(self).cast::<c_void>().cast()
    }

    /// Whether everything that was taken is back.
    pub fn end(self) -> Result<(), BadView> {
        let layers = layers_from(self.out);
        let Some(layer) = layers.first() else { return Ok(()) };
        Err(BadView::new(format!("the layer {} was taken out of the map and not put back", layer.name())))
    }
}

/// # Safety
/// `map` is null or came from `lend` of the present call.
unsafe fn of<'a>(map: *mut rumbo_map_mut) -> Option<&'a mut MapHandle<'a>> {
    // SAFETY: as promised by the caller.
    unsafe { map.cast::<c_void>().cast::<MapHandle<'a>>().as_mut() }
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
    unsafe { of(map.cast_mut()) }.map_or(0, |of| of.map.version)
}

pub(super) unsafe extern "C" fn set_version(map: *mut rumbo_map_mut, version: u64) {
    // SAFETY: the map of the present call.
    if let Some(of) = unsafe { of(map) } {
        of.map.version = version;
    }
}

pub(super) unsafe extern "C" fn n_coarse(map: *const rumbo_map_mut) -> usize {
    // SAFETY: the map of the present call.
    unsafe { of(map.cast_mut()) }.map_or(0, |of| of.map.coarse_grids.len())
}

pub(super) unsafe extern "C" fn take_grid(map: *mut rumbo_map_mut, level: u32, out: *mut rumbo_grid) -> i32 {
    // SAFETY: the map of the present call.
    let Some(of) = (unsafe { of(map) }).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
    let grid = if level == 0 { of.map.grid.take() } else { of.map.coarse_grids.pop() };
    if level == 0 && grid.is_some() {
        of.out |= RUMBO_LAYER_GRID;
    }
    // SAFETY: the plugin's own variable.
    unsafe { hand_out(grid.map(give_grid), out) }
}

pub(super) unsafe extern "C" fn put_grid(
    map: *mut rumbo_map_mut,
    level: u32,
    grid: *const rumbo_grid,
) -> i32 {
    // SAFETY: the map of the present call, and a grid whose reference is given.
    let (Some(of), Ok(grid)) = (unsafe { (of(map), grid_from(grid, Hold::Given)) }) else {
        return RUMBO_BAD_NUMBER;
    };
    match level {
        0 => {
            of.map.grid = Some(grid);
            of.out &= !RUMBO_LAYER_GRID;
        }
        _ => of.map.coarse_grids.push(grid),
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn take_lines(map: *mut rumbo_map_mut, out: *mut rumbo_line_array) -> i32 {
    // SAFETY: the map of the present call, and the plugin's own variable.
    unsafe {
        let Some(of) = of(map).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
        if of.map.lines.is_some() {
            of.out |= RUMBO_LAYER_LINES;
        }
        hand_out(of.map.lines.take().map(|lines| CArray::give(lines.lines)), out)
    }
}

pub(super) unsafe extern "C" fn put_lines(map: *mut rumbo_map_mut, lines: *const rumbo_line_array) -> i32 {
    // SAFETY: the map of the present call, and an array whose reference is given.
    unsafe {
        let (Some(of), Some(Ok(lines))) = (of(map), lines.as_ref().map(|lines| lines.take(Hold::Given)))
        else {
            return RUMBO_BAD_NUMBER;
        };
        of.map.lines = Some(Lines { lines });
        of.out &= !RUMBO_LAYER_LINES;
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn take_landmarks(
    map: *mut rumbo_map_mut,
    out: *mut rumbo_landmark_array,
) -> i32 {
    // SAFETY: the map of the present call, and the plugin's own variable.
    unsafe {
        let Some(of) = of(map).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
        if of.map.landmarks.is_some() {
            of.out |= RUMBO_LAYER_LANDMARKS;
        }
        hand_out(of.map.landmarks.take().map(|landmarks| CArray::give(landmarks.landmarks)), out)
    }
}

pub(super) unsafe extern "C" fn put_landmarks(
    map: *mut rumbo_map_mut,
    landmarks: *const rumbo_landmark_array,
) -> i32 {
    // SAFETY: the map of the present call, and an array whose reference is given.
    unsafe {
        let taken = landmarks.as_ref().map(|landmarks| landmarks.take(Hold::Given));
        let (Some(of), Some(Ok(landmarks))) = (of(map), taken) else { return RUMBO_BAD_NUMBER };
        of.map.landmarks = Some(Landmarks { landmarks });
        of.out &= !RUMBO_LAYER_LANDMARKS;
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
    let Some(voxels) = (unsafe { of(map.cast_mut()) }).and_then(|of| of.map.voxels.as_ref()) else {
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
        let Some(of) = of(map).filter(|_| !out.is_null()) else { return RUMBO_MISSING };
        hand_out(of.map.voxels.as_mut().and_then(|voxels| voxels.chunks.pop()).map(give_chunk), out)
    }
}

pub(super) unsafe extern "C" fn new_voxels(
    map: *mut rumbo_map_mut,
    resolution_m: f64,
    origin: *const f64,
) -> i32 {
    // SAFETY: the map of the present call, and three numbers of the plugin.
    unsafe {
        let Some(of) = of(map).filter(|_| !origin.is_null()) else { return RUMBO_ERROR };
        let origin = origin.cast::<[f64; 3]>().read();
        of.map.voxels = Some(Voxels { resolution_m, origin, chunks: Vec::new() });
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn put_chunk(map: *mut rumbo_map_mut, chunk: *const rumbo_voxel_chunk) -> i32 {
    // SAFETY: the map of the present call, and an array whose reference is given.
    unsafe {
        let chunk = chunk.as_ref().map(|chunk| chunk_from(chunk, Hold::Given));
        let voxels = of(map).and_then(|of| of.map.voxels.as_mut());
        let (Some(voxels), Some(Ok(chunk))) = (voxels, chunk) else { return RUMBO_BAD_NUMBER };
        voxels.chunks.push(chunk);
    }
    RUMBO_OK
}

pub(super) unsafe extern "C" fn remove(map: *mut rumbo_map_mut, layer: u32) {
    // SAFETY: the map of the present call.
    let Some(MapHandle { map, out }) = (unsafe { of(map) }) else { return };
    *out &= !layer;
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
