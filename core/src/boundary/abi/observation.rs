//! Observations as they cross: a header, and a struct for each kind.

use super::basic::{
    rumbo_f32_array, rumbo_point3_array, rumbo_pose2, rumbo_pose3, rumbo_str, rumbo_twist, rumbo_u8_array,
    rumbo_u16_array,
};
use std::ffi::c_void;

/// `data` is a `rumbo_odometry`.
pub const RUMBO_ODOMETRY: u32 = 0;
/// `data` is a `rumbo_wheel_speeds`.
pub const RUMBO_WHEEL_SPEEDS: u32 = 1;
/// `data` is a `rumbo_steering_angle`.
pub const RUMBO_STEERING_ANGLE: u32 = 2;
/// `data` is a `rumbo_laser_scan`.
pub const RUMBO_LASER_SCAN: u32 = 3;
/// `data` is a `rumbo_range_ring`.
pub const RUMBO_RANGE_RING: u32 = 4;
/// `data` is a `rumbo_bumpers`.
pub const RUMBO_BUMPERS: u32 = 5;
/// `data` is a `rumbo_depth_image`.
pub const RUMBO_DEPTH_IMAGE: u32 = 6;
/// `data` is a `rumbo_point_cloud`.
pub const RUMBO_POINT_CLOUD: u32 = 7;
/// `data` is a `rumbo_imu`.
pub const RUMBO_IMU: u32 = 8;
/// `data` is a `rumbo_position_fix`.
pub const RUMBO_POSITION_FIX: u32 = 9;
/// `data` is a `rumbo_marks`.
pub const RUMBO_MARKS: u32 = 10;
/// `data` is a `rumbo_custom`.
pub const RUMBO_CUSTOM: u32 = 11;

/// One reading of one sensor. Skip kinds that you do not know.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_observation {
    /// Bytes of this struct.
    pub size: usize,
    /// When it was seen, nanoseconds.
    pub stamp_ns: i64,
    /// One of `RUMBO_ODOMETRY`, `RUMBO_LASER_SCAN`, ...
    pub kind: u32,
    /// Which sensor of the pipeline, in the order of the file; the host overwrites what a sensor says here.
    pub sensor: u16,
    /// 1 where the device stands by this reading.
    pub valid: u8,
    /// 0.
    pub reserved: u8,
    /// Where the sensor sat on the robot.
    pub base_from_sensor: rumbo_pose3,
    /// The reading: a struct that `kind` names.
    pub data: *const c_void,
}

/// Everything since the last call, oldest stamp first: element `k` is `stride` bytes times `k` behind `first`.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_seen {
    /// Bytes of this struct.
    pub size: usize,
    /// Number of observations.
    pub len: usize,
    /// Bytes from one to the next.
    pub stride: usize,
    /// The oldest.
    pub first: *const rumbo_observation,
}

/// Where the wheels say the base is, seen from where it started.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_odometry {
    /// Bytes of this struct.
    pub size: usize,
    /// The base in the odometer's frame.
    pub odom_from_base: rumbo_pose2,
    /// Velocity of the base.
    pub twist: rumbo_twist,
    /// Standard deviations that grow: distance (m/m), direction (rad/m), turn (rad/rad).
    pub noise: [f64; 3],
}

/// Rolling speeds of at most four wheels.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_wheel_speeds {
    /// Bytes of this struct.
    pub size: usize,
    /// How many are used.
    pub n_wheels: u32,
    /// 0.
    pub reserved: u32,
    /// Speed of each rim over the floor, m/s.
    pub rim_m_s: [f64; 4],
}

/// Angle of the steered wheel.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_steering_angle {
    /// Bytes of this struct.
    pub size: usize,
    /// Counter-clockwise from straight ahead, radians.
    pub angle_rad: f64,
}

/// A planar scan. Finite ranges are hits, infinity is nothing within reach, not-a-number no reading (REP-117).
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_laser_scan {
    /// Bytes of this struct.
    pub size: usize,
    /// Bearing of the first beam in the sensor's frame, radians.
    pub first_bearing_rad: f64,
    /// Bearing from one beam to the next, radians.
    pub bearing_step_rad: f64,
    /// Time from the first beam to the last, seconds.
    pub sweep_s: f64,
    /// Shorter ranges are not readings, meters.
    pub min_range_m: f32,
    /// Reach of the device, meters.
    pub max_range_m: f32,
    /// One range a beam, meters.
    pub ranges_m: rumbo_f32_array,
    /// One intensity a beam, or none at all.
    pub intensities: rumbo_f32_array,
}

/// Single ranges around the hull, each a cone.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_range_ring {
    /// Bytes of this struct.
    pub size: usize,
    /// Bearing of the first cone's axis, radians.
    pub first_bearing_rad: f64,
    /// Bearing from one axis to the next, radians.
    pub bearing_step_rad: f64,
    /// Full opening of a cone, radians.
    pub cone_rad: f64,
    /// Distance of the transducers from the ring's center, meters.
    pub ring_radius_m: f64,
    /// Shorter ranges are not readings, meters.
    pub min_range_m: f32,
    /// Reach, meters.
    pub max_range_m: f32,
    /// One range a transducer, meters.
    pub ranges_m: rumbo_f32_array,
}

/// Touch sensors around the hull.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_bumpers {
    /// Bytes of this struct.
    pub size: usize,
    /// Bit `k` is set while bumper `k` touches something.
    pub pressed: u64,
    /// Bearing of bumper 0, radians.
    pub first_bearing_rad: f64,
    /// Bearing from one bumper to the next, radians.
    pub bearing_step_rad: f64,
    /// Distance of the bumpers from the ring's center, meters.
    pub ring_radius_m: f64,
    /// How many there are, at most 64.
    pub n_bumpers: u32,
    /// 0.
    pub reserved: u32,
}

/// A pinhole camera without distortion.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_intrinsics {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Focal lengths, pixels.
    pub focal_px: [f64; 2],
    /// Where the optical axis meets the picture, pixels.
    pub center_px: [f64; 2],
}

/// A depth picture, row 0 on top.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_depth_image {
    /// Bytes of this struct.
    pub size: usize,
    /// The camera.
    pub intrinsics: rumbo_intrinsics,
    /// Meters of one count.
    pub unit_m: f32,
    /// 0.
    pub reserved: u32,
    /// Counts, row by row; 0 is no reading.
    pub depth: rumbo_u16_array,
}

/// Points in the sensor's frame.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_point_cloud {
    /// Bytes of this struct.
    pub size: usize,
    /// x, y, z, meters.
    pub points_m: rumbo_point3_array,
}

/// Attitude, turning rates and specific force.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_imu {
    /// Bytes of this struct.
    pub size: usize,
    /// 1 where `attitude_rad` is given.
    pub has_attitude: u32,
    /// 0.
    pub reserved: u32,
    /// Roll, pitch, yaw, radians.
    pub attitude_rad: [f64; 3],
    /// Turning rates about x, y, z, rad/s.
    pub rates_rad_s: [f64; 3],
    /// Specific force along x, y, z, m/s².
    pub accelerations_m_s2: [f64; 3],
}

/// A position in the map's frame from outside the robot.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_position_fix {
    /// Bytes of this struct.
    pub size: usize,
    /// x, y, z, meters.
    pub position_m: [f64; 3],
    /// Standard deviation along each axis, meters.
    pub deviation_m: [f64; 3],
}

/// One recognized mark.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_mark {
    /// 1 where `identity` is known.
    pub has_identity: u32,
    /// Which mark.
    pub identity: u32,
    /// Distance in the plane, meters.
    pub range_m: f64,
    /// Direction in the sensor's frame, radians.
    pub bearing_rad: f64,
}

/// Marks recognized at one time.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_marks {
    /// Bytes of this struct.
    pub size: usize,
    /// Number of marks.
    pub len: usize,
    /// The marks.
    pub marks: *const rumbo_mark,
    /// Standard deviation of the range, meters.
    pub range_deviation_m: f64,
    /// Standard deviation of the bearing, radians.
    pub bearing_deviation_rad: f64,
}

/// A message of a third party's own kind.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct rumbo_custom {
    /// Bytes of this struct.
    pub size: usize,
    /// Name of the schema, `vendor/Kind`.
    pub schema: rumbo_str,
    /// The message.
    pub bytes: rumbo_u8_array,
}
