//! The host table: what plugins may call back.
//!
//! These functions run on the plugin's threads and must not panic: a panic may not leave a C function.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::buffer::{allocate_here, release_block, retain_block};
use super::super::convert::{CArray, Hold, read, slice, str_from, string_from, text_of};
use super::super::words::intern;
use super::config::Values;
use super::{log, map_mut, world};
use crate::frames::Point2;
use crate::rng::Rng;
use crate::stages::GiveUp;
use crate::trace::{Drawing, Trace};
use rand::Rng as _;
use rand_distr::Distribution as _;
use std::sync::Arc;

/// The table that every plugin gets.
pub(super) static HOST: rumbo_host = rumbo_host {
    size: size_of::<rumbo_host>(),
    abi_major: RUMBO_ABI_MAJOR,
    abi_minor: RUMBO_ABI_MINOR,
    log: log_message,
    block_new,
    block_retain,
    block_release,
    make_mut_f32,
    config_f64,
    config_i64,
    config_bool,
    config_str,
    config_len,
    random_u64,
    random_uniform,
    random_normal,
    give_up_is_raised,
    give_up_retain,
    give_up_release,
    draw_polyline,
    draw_points,
    count,
    world_now_ns: world::now_ns,
    world_is_real_time: world::is_real_time,
    probe: world::probe,
    lend_f32: world::lend_f32,
    lend_u16: world::lend_u16,
    lend_point3: world::lend_point3,
    observe: world::observe,
    map_version: map_mut::version,
    map_set_version: map_mut::set_version,
    map_n_coarse: map_mut::n_coarse,
    map_take_grid: map_mut::take_grid,
    map_put_grid: map_mut::put_grid,
    map_take_lines: map_mut::take_lines,
    map_put_lines: map_mut::put_lines,
    map_take_landmarks: map_mut::take_landmarks,
    map_put_landmarks: map_mut::put_landmarks,
    map_voxels: map_mut::voxels,
    map_take_chunk: map_mut::take_chunk,
    map_new_voxels: map_mut::new_voxels,
    map_put_chunk: map_mut::put_chunk,
    map_remove: map_mut::remove,
};

unsafe extern "C" fn log_message(level: u32, target: rumbo_str, message: rumbo_str) {
    // SAFETY: views of the caller, alive during the call.
    let (target, message) = unsafe { (string_from(target), string_from(message)) };
    log::say(level, target, message);
}

unsafe extern "C" fn block_new(bytes: usize) -> *mut rumbo_block {
    allocate_here(bytes)
}

unsafe extern "C" fn block_retain(block: *mut rumbo_block) {
    // SAFETY: the caller holds a reference.
    unsafe { retain_block(block) };
}

unsafe extern "C" fn block_release(block: *mut rumbo_block) {
    // SAFETY: the caller gives up a reference.
    unsafe { release_block(block) };
}

unsafe extern "C" fn make_mut_f32(array: *mut rumbo_f32_array) -> *mut f32 {
    // SAFETY: the caller owns the array and its reference.
    let Some(array) = (unsafe { array.as_mut() }) else { return std::ptr::null_mut() };
    // SAFETY: as above.
    let Ok(mut buffer) = (unsafe { array.take(Hold::Given) }) else { return std::ptr::null_mut() };
    let elements = buffer.make_mut().as_mut_ptr();
    *array = CArray::give(buffer);
    elements
}

/// # Safety
/// `config` is the one that the host handed over.
unsafe fn value(config: *const rumbo_config, path: rumbo_str) -> Option<&'static toml::Value> {
    // SAFETY: the values live as long as the call that handed them over; the caller does not keep them longer.
    unsafe {
        let config = read(config)?;
        let values = config.values.cast::<Values>().as_ref()?;
        values.at(str_from(path)?)
    }
}

/// Writes what `pick` makes of a value.
///
/// # Safety
/// `config` is the one that the host handed over, and `out` null or a variable of the plugin.
unsafe fn pick<T>(
    config: *const rumbo_config,
    path: rumbo_str,
    out: *mut T,
    pick: impl FnOnce(&'static toml::Value) -> Option<T>,
) -> i32 {
    // SAFETY: as promised by the plugin.
    let Some(value) = (unsafe { value(config, path) }) else { return RUMBO_MISSING };
    match pick(value) {
        Some(picked) if !out.is_null() => {
            // SAFETY: the plugin's own variable.
            unsafe { out.write(picked) };
            RUMBO_OK
        }
        _ => RUMBO_BAD_CONFIG,
    }
}

unsafe extern "C" fn config_f64(config: *const rumbo_config, path: rumbo_str, out: *mut f64) -> i32 {
    let number = |v: &toml::Value| v.as_float().or_else(|| v.as_integer().map(|i| i as f64));
    // SAFETY: handed over by the plugin.
    unsafe { pick(config, path, out, number) }
}

unsafe extern "C" fn config_i64(config: *const rumbo_config, path: rumbo_str, out: *mut i64) -> i32 {
    // SAFETY: handed over by the plugin.
    unsafe { pick(config, path, out, toml::Value::as_integer) }
}

unsafe extern "C" fn config_bool(config: *const rumbo_config, path: rumbo_str, out: *mut u32) -> i32 {
    // SAFETY: handed over by the plugin.
    unsafe { pick(config, path, out, |v| v.as_bool().map(u32::from)) }
}

unsafe extern "C" fn config_str(config: *const rumbo_config, path: rumbo_str, out: *mut rumbo_str) -> i32 {
    // SAFETY: handed over by the plugin.
    unsafe { pick(config, path, out, |v| v.as_str().map(text_of)) }
}

unsafe extern "C" fn config_len(config: *const rumbo_config, path: rumbo_str, out: *mut usize) -> i32 {
    // SAFETY: handed over by the plugin.
    unsafe { pick(config, path, out, |v| v.as_array().map(Vec::len)) }
}

/// # Safety
/// `rng` is null or the instance's stream, used by one thread at a time.
unsafe fn stream<'a>(rng: *mut rumbo_rng) -> Option<&'a mut Rng> {
    // SAFETY: as promised by the caller.
    unsafe { rng.cast::<Rng>().as_mut() }
}

unsafe extern "C" fn random_u64(rng: *mut rumbo_rng) -> u64 {
    // SAFETY: handed over by the plugin.
    unsafe { stream(rng) }.map_or(0, |rng| rng.next_u64())
}

unsafe extern "C" fn random_uniform(rng: *mut rumbo_rng) -> f64 {
    // SAFETY: handed over by the plugin.
    unsafe { stream(rng) }.map_or(0.0, |rng| rand_distr::StandardUniform.sample(rng))
}

unsafe extern "C" fn random_normal(rng: *mut rumbo_rng) -> f64 {
    // SAFETY: handed over by the plugin.
    unsafe { stream(rng) }.map_or(0.0, |rng| rand_distr::StandardNormal.sample(rng))
}

/// Hands a flag over; the plugin that keeps it retains it.
pub(super) fn lend_flag(flag: &Arc<GiveUp>) -> *const rumbo_give_up {
    Arc::as_ptr(flag).cast()
}

unsafe extern "C" fn give_up_is_raised(flag: *const rumbo_give_up) -> u32 {
    // SAFETY: the flag of a call, or one that was kept.
    unsafe { flag.cast::<GiveUp>().as_ref() }.is_some_and(GiveUp::is_raised).into()
}

unsafe extern "C" fn give_up_retain(flag: *const rumbo_give_up) {
    if !flag.is_null() {
        // SAFETY: every flag that is handed over sits in an `Arc`.
        unsafe { Arc::increment_strong_count(flag.cast::<GiveUp>()) };
    }
}

unsafe extern "C" fn give_up_release(flag: *const rumbo_give_up) {
    if !flag.is_null() {
        // SAFETY: the caller gives up a reference that it took.
        unsafe { Arc::decrement_strong_count(flag.cast::<GiveUp>()) };
    }
}

/// # Safety
/// `trace` is null or the trace of the present call.
unsafe fn draw(
    trace: *mut rumbo_trace,
    name: rumbo_str,
    points: *const rumbo_point,
    len: usize,
    drawing: fn(&'static str, Vec<Point2>) -> Drawing,
) {
    // SAFETY: as promised by the caller.
    unsafe {
        let (Some(trace), Some(name)) = (trace.cast::<Trace>().as_ref(), str_from(name)) else { return };
        let Ok(points) = slice(points, len) else { return };
        let points = || points.iter().map(|p| Point2::new(p.x_m, p.y_m)).collect();
        trace.draw(|| drawing(intern(name), points()));
    }
}

unsafe extern "C" fn draw_polyline(t: *mut rumbo_trace, name: rumbo_str, p: *const rumbo_point, len: usize) {
    // SAFETY: handed over by the plugin.
    unsafe { draw(t, name, p, len, |name, points| Drawing::Polyline { name, points }) };
}

unsafe extern "C" fn draw_points(t: *mut rumbo_trace, name: rumbo_str, p: *const rumbo_point, len: usize) {
    // SAFETY: handed over by the plugin.
    unsafe { draw(t, name, p, len, |name, points| Drawing::Points { name, points }) };
}

unsafe extern "C" fn count(trace: *mut rumbo_trace, name: rumbo_str, value: f64) {
    // SAFETY: handed over by the plugin.
    unsafe {
        if let (Some(trace), Some(name)) = (trace.cast::<Trace>().as_ref(), str_from(name)) {
            trace.count(intern(name), value);
        }
    }
}
