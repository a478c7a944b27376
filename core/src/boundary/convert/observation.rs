//! Observations out of their views.
#![allow(unsafe_code)]

use super::BadView;
use super::array::{CArray, Hold};
use super::basic::{Sized1, pose2_from, pose3_from, read, str_from, twist_from};
use crate::boundary::Buffer;
use crate::boundary::abi::*;
use crate::messages::{
    Bumpers, Custom, Data, DepthImage, Imu, Intrinsics, LaserScan, Mark, Marks, Observation, Odometry,
    PointCloud, PositionFix, RangeRing, SensorId, SteeringAngle, WheelSpeeds,
};
use crate::time::Time;
use std::ffi::c_void;

/// The camera behind a view.
pub(crate) fn intrinsics_from(camera: &rumbo_intrinsics) -> Intrinsics {
    let rumbo_intrinsics { width, height, focal_px, center_px } = *camera;
    Intrinsics { width, height, focal_px, center_px }
}

/// The marks behind a view.
///
/// # Safety
/// `view.marks` points to `view.len` marks.
pub(crate) unsafe fn marks_from(view: &rumbo_marks) -> Result<Marks, BadView> {
    // SAFETY: as promised by the caller.
    let marks = unsafe { slice(view.marks, view.len)? };
    let marks = marks.iter().map(|m| Mark {
        identity: (m.has_identity != 0).then_some(m.identity),
        range_m: m.range_m,
        bearing_rad: m.bearing_rad,
    });
    Ok(Marks {
        marks: marks.collect(),
        range_deviation_m: view.range_deviation_m,
        bearing_deviation_rad: view.bearing_deviation_rad,
    })
}

/// The elements at `first`.
///
/// # Safety
/// `first` is null or points to `len` elements that live for `'a`.
pub(crate) unsafe fn slice<'a, T>(first: *const T, len: usize) -> Result<&'a [T], BadView> {
    if len == 0 {
        return Ok(&[]);
    }
    if first.is_null() || !first.is_aligned() || len > isize::MAX as usize / size_of::<T>().max(1) {
        return Err(BadView::new(format!("a list of {len} elements points nowhere")));
    }
    // SAFETY: as promised by the caller.
    Ok(unsafe { std::slice::from_raw_parts(first, len) })
}

/// Puts all observations behind a view into `out`; kinds that this side does not know are left out.
///
/// # Safety
/// `seen` points to a view whose parts are alive.
pub(crate) unsafe fn observations_from(
    seen: *const rumbo_seen,
    out: &mut Vec<Observation>,
) -> Result<(), BadView> {
    out.clear();
    // SAFETY: as promised by the caller.
    let Some(seen) = (unsafe { read(seen) }) else { return Ok(()) };
    for idx in 0..seen.len {
        let at = seen.first.cast::<u8>().wrapping_add(idx * seen.stride).cast::<rumbo_observation>();
        // SAFETY: the view says that there are `len` of them, `stride` bytes apart.
        if let Some(observation) = unsafe { observation_from(at, Hold::Lent)? } {
            out.push(observation);
        }
    }
    Ok(())
}

unsafe fn part<T: Sized1>(data: *const c_void) -> Result<T, BadView> {
    // SAFETY: the kind of the observation says what is there.
    unsafe { read(data.cast::<T>()) }.ok_or_else(|| BadView::new("an observation has no data"))
}

/// The observation behind a view; none where this side does not know its kind.
///
/// # Safety
/// `at` points to a view whose parts are alive.
pub(crate) unsafe fn observation_from(
    at: *const rumbo_observation,
    hold: Hold,
) -> Result<Option<Observation>, BadView> {
    // SAFETY: as promised by the caller.
    let header = unsafe { read(at) }.ok_or_else(|| BadView::new("an observation points nowhere"))?;
    // SAFETY: as promised by the caller.
    let Some(data) = (unsafe { data_from(header.kind, header.data, hold)? }) else { return Ok(None) };
    Ok(Some(Observation {
        sensor: SensorId(header.sensor),
        stamp: Time(header.stamp_ns),
        base_from_sensor: pose3_from(&header.base_from_sensor, "base_from_sensor")?,
        valid: header.valid != 0,
        data,
    }))
}

fn array<A: CArray>(view: A, hold: Hold) -> Result<Buffer<A::Item>, BadView> {
    // SAFETY: arrays in observations hold blocks of the host, or data.
    unsafe { view.take(hold) }.map_err(|bad| BadView::new(bad.to_string()))
}

/// # Safety
/// `data` points to the struct that `kind` names.
unsafe fn data_from(kind: u32, data: *const c_void, hold: Hold) -> Result<Option<Data>, BadView> {
    // SAFETY: for all blocks below: as promised by the caller.
    Ok(Some(match kind {
        RUMBO_ODOMETRY => {
            let d: rumbo_odometry = unsafe { part(data)? };
            let odom_from_base = pose2_from(&d.odom_from_base, "odom_from_base")?;
            Data::Odometry(Odometry { odom_from_base, twist: twist_from(&d.twist), noise: d.noise })
        }
        RUMBO_WHEEL_SPEEDS => {
            let d: rumbo_wheel_speeds = unsafe { part(data)? };
            Data::WheelSpeeds(WheelSpeeds { n_wheels: d.n_wheels, rim_m_s: d.rim_m_s })
        }
        RUMBO_STEERING_ANGLE => {
            let d: rumbo_steering_angle = unsafe { part(data)? };
            Data::SteeringAngle(SteeringAngle { angle_rad: d.angle_rad })
        }
        RUMBO_LASER_SCAN => {
            let d: rumbo_laser_scan = unsafe { part(data)? };
            Data::LaserScan(LaserScan {
                first_bearing_rad: d.first_bearing_rad,
                bearing_step_rad: d.bearing_step_rad,
                sweep_s: d.sweep_s,
                min_range_m: d.min_range_m,
                max_range_m: d.max_range_m,
                ranges_m: array(d.ranges_m, hold)?,
                intensities: array(d.intensities, hold)?,
            })
        }
        RUMBO_RANGE_RING => {
            let d: rumbo_range_ring = unsafe { part(data)? };
            Data::RangeRing(RangeRing {
                first_bearing_rad: d.first_bearing_rad,
                bearing_step_rad: d.bearing_step_rad,
                cone_rad: d.cone_rad,
                ring_radius_m: d.ring_radius_m,
                min_range_m: d.min_range_m,
                max_range_m: d.max_range_m,
                ranges_m: array(d.ranges_m, hold)?,
            })
        }
        RUMBO_BUMPERS => {
            let d: rumbo_bumpers = unsafe { part(data)? };
            Data::Bumpers(Bumpers {
                n_bumpers: d.n_bumpers,
                pressed: d.pressed,
                first_bearing_rad: d.first_bearing_rad,
                bearing_step_rad: d.bearing_step_rad,
                ring_radius_m: d.ring_radius_m,
            })
        }
        RUMBO_DEPTH_IMAGE => {
            let d: rumbo_depth_image = unsafe { part(data)? };
            let intrinsics = intrinsics_from(&d.intrinsics);
            Data::DepthImage(DepthImage { intrinsics, unit_m: d.unit_m, depth: array(d.depth, hold)? })
        }
        RUMBO_POINT_CLOUD => {
            let d: rumbo_point_cloud = unsafe { part(data)? };
            Data::PointCloud(PointCloud { points_m: array(d.points_m, hold)? })
        }
        RUMBO_IMU => {
            let d: rumbo_imu = unsafe { part(data)? };
            Data::Imu(Imu {
                attitude_rad: (d.has_attitude != 0).then_some(d.attitude_rad),
                rates_rad_s: d.rates_rad_s,
                accelerations_m_s2: d.accelerations_m_s2,
            })
        }
        RUMBO_POSITION_FIX => {
            let d: rumbo_position_fix = unsafe { part(data)? };
            Data::PositionFix(PositionFix { position_m: d.position_m, deviation_m: d.deviation_m })
        }
        RUMBO_MARKS => {
            let d: rumbo_marks = unsafe { part(data)? };
            Data::Marks(unsafe { marks_from(&d)? })
        }
        RUMBO_CUSTOM => {
            let d: rumbo_custom = unsafe { part(data)? };
            let schema = unsafe { str_from(d.schema) }.ok_or_else(|| BadView::new("schema is no UTF-8"))?;
            Data::Custom(Custom { schema: schema.to_owned(), bytes: array(d.bytes, hold)? })
        }
        _ => return Ok(None),
    }))
}
