//! Words, poses, and structs that may have another size than ours.
#![allow(unsafe_code)]

use super::BadView;
use crate::boundary::abi::{rumbo_pose2, rumbo_pose3, rumbo_str, rumbo_twist};
use crate::frames::{Pose2, Pose3, Twist};
use nalgebra::{Complex, Quaternion, Translation2, Translation3, UnitComplex, UnitQuaternion};
use std::ffi::c_char;
use std::mem::MaybeUninit;

/// A struct of the ABI that starts with its size.
///
/// # Safety
/// `repr(C)`, first field `size: usize`, and all zeros is a valid value.
pub(crate) unsafe trait Sized1: Copy {}

macro_rules! sized {
    ($($name:ident),* $(,)?) => { $(
        // SAFETY: `repr(C)` with `size` in front; all fields are numbers, raw pointers or optional functions.
        unsafe impl Sized1 for crate::boundary::abi::$name {}
    )* };
}
sized!(
    rumbo_observation,
    rumbo_seen,
    rumbo_odometry,
    rumbo_wheel_speeds,
    rumbo_steering_angle,
    rumbo_laser_scan,
    rumbo_range_ring,
    rumbo_bumpers,
    rumbo_depth_image,
    rumbo_point_cloud,
    rumbo_imu,
    rumbo_position_fix,
    rumbo_marks,
    rumbo_custom,
    rumbo_grid,
    rumbo_voxels,
    rumbo_map,
    rumbo_call,
    rumbo_estimate,
    rumbo_path,
    rumbo_plan_request,
    rumbo_avoid_input,
    rumbo_steering,
    rumbo_prior,
    rumbo_path_out,
    rumbo_obstacle_out,
    rumbo_candidate_out,
    rumbo_trajectory_out,
    rumbo_bytes_out,
    rumbo_fault_out,
    rumbo_probe,
    rumbo_answer,
    rumbo_config,
    rumbo_manifest,
    rumbo_robot,
    rumbo_context,
    rumbo_entry,
    rumbo_planner_table,
    rumbo_avoider_table,
    rumbo_localizer_table,
    rumbo_map_builder_table,
    rumbo_slam_table,
    rumbo_sensor_table,
);

/// A copy of the struct at `from` as far as its writer's `size` and ours go; fields that it does not have are zero.
///
/// # Safety
/// `from` is null or points to a struct of this kind, of the size that it says.
pub(crate) unsafe fn read<T: Sized1>(from: *const T) -> Option<T> {
    if from.is_null() || !from.is_aligned() {
        return None;
    }
    // SAFETY: every such struct starts with its size.
    let size = unsafe { from.cast::<usize>().read() };
    let mut to = MaybeUninit::<T>::zeroed();
    // SAFETY: the writer vouches for `size` bytes; zeros are valid for whatever is missing.
    unsafe {
        std::ptr::copy_nonoverlapping(
            from.cast::<u8>(),
            to.as_mut_ptr().cast::<u8>(),
            size.min(size_of::<T>()),
        );
        Some(to.assume_init())
    }
}

/// Writes as much of `from` as the other side's struct, which says its own size, has room for.
///
/// # Safety
/// `to` is null or points to a struct of this kind, of the size that it says.
pub(crate) unsafe fn write_sized<T: Sized1>(to: *mut T, from: &T) {
    if to.is_null() || !to.is_aligned() {
        return;
    }
    // SAFETY: as promised by the caller.
    unsafe {
        let size = to.cast::<usize>().read();
        let from = std::ptr::from_ref(from).cast::<u8>();
        std::ptr::copy_nonoverlapping(from, to.cast::<u8>(), size.min(size_of::<T>()));
        to.cast::<usize>().write(size);
    }
}

/// A view of text.
pub(crate) fn text_of(text: &str) -> rumbo_str {
    rumbo_str { data: text.as_ptr().cast::<c_char>(), len: text.len() }
}

/// The text behind a view; none where it is no UTF-8 or points nowhere.
///
/// # Safety
/// `view.data` is null or points to `view.len` bytes that live for `'a`.
pub(crate) unsafe fn str_from<'a>(view: rumbo_str) -> Option<&'a str> {
    if view.len == 0 {
        return Some("");
    }
    if view.data.is_null() || view.len > isize::MAX as usize {
        return None;
    }
    // SAFETY: as promised by the caller.
    let bytes = unsafe { std::slice::from_raw_parts(view.data.cast::<u8>(), view.len) };
    std::str::from_utf8(bytes).ok()
}

/// The text behind a view, with what is no UTF-8 replaced.
///
/// # Safety
/// As [`str_from`].
pub(crate) unsafe fn string_from(view: rumbo_str) -> String {
    if view.len == 0 || view.data.is_null() || view.len > isize::MAX as usize {
        return String::new();
    }
    // SAFETY: as promised by the caller.
    let bytes = unsafe { std::slice::from_raw_parts(view.data.cast::<u8>(), view.len) };
    String::from_utf8_lossy(bytes).into_owned()
}

/// Writes text into a fixed array, ended by a zero; cuts between characters.
pub(crate) fn cut_into(array: &mut [c_char], text: &str) {
    let mut end = text.len().min(array.len().saturating_sub(1));
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    for (to, from) in array.iter_mut().zip(text.bytes().take(end).chain([0])) {
        *to = from as c_char;
    }
}

/// The text in a fixed array.
pub(crate) fn text_in(array: &[c_char]) -> String {
    let bytes: Vec<u8> = array.iter().take_while(|c| **c != 0).map(|c| *c as u8).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// A pose in the plane, to the bit.
pub(crate) fn rumbo_pose2_of(pose: &Pose2) -> rumbo_pose2 {
    let (x_m, y_m) = (pose.translation.x, pose.translation.y);
    rumbo_pose2 { x_m, y_m, cos_yaw: pose.rotation.re, sin_yaw: pose.rotation.im }
}

/// How far the squared norm of a rotation may be from 1: rounding, not another meaning.
const UNIT: f64 = 1e-6;

/// The pose behind a view, to the bit.
pub(crate) fn pose2_from(pose: &rumbo_pose2, field: &str) -> Result<Pose2, BadView> {
    let norm2 = pose.cos_yaw * pose.cos_yaw + pose.sin_yaw * pose.sin_yaw;
    if (norm2 - 1.0).abs() > UNIT {
        return Err(not_unit(field, "cosine and sine of a heading", norm2));
    }
    let rotation = UnitComplex::new_unchecked(Complex::new(pose.cos_yaw, pose.sin_yaw));
    Ok(Pose2::from_parts(Translation2::new(pose.x_m, pose.y_m), rotation))
}

fn not_unit(field: &str, expected: &str, norm2: f64) -> BadView {
    BadView::new(format!("{field} has a rotation of the squared length {norm2}, expected {expected}"))
}

/// A pose in space, to the bit.
pub(crate) fn rumbo_pose3_of(pose: &Pose3) -> rumbo_pose3 {
    let (t, q) = (&pose.translation, &pose.rotation);
    rumbo_pose3 { position_m: [t.x, t.y, t.z], quaternion: [q.i, q.j, q.k, q.w] }
}

/// The pose behind a view, to the bit.
pub(crate) fn pose3_from(pose: &rumbo_pose3, field: &str) -> Result<Pose3, BadView> {
    let [i, j, k, w] = pose.quaternion;
    let norm2 = i * i + j * j + k * k + w * w;
    if (norm2 - 1.0).abs() > UNIT {
        return Err(not_unit(field, "a unit quaternion", norm2));
    }
    let [x, y, z] = pose.position_m;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
    Ok(Pose3::from_parts(Translation3::new(x, y, z), rotation))
}

/// A velocity.
pub(crate) fn twist_of(twist: Twist) -> rumbo_twist {
    let Twist { forward_m_s, left_m_s, turn_rad_s } = twist;
    rumbo_twist { forward_m_s, left_m_s, turn_rad_s }
}

/// The velocity behind a view.
pub(crate) fn twist_from(twist: &rumbo_twist) -> Twist {
    Twist { forward_m_s: twist.forward_m_s, left_m_s: twist.left_m_s, turn_rad_s: twist.turn_rad_s }
}
