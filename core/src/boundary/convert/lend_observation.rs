//! Views of observations.
#![allow(unsafe_code)]

use super::array::CArray;
use super::basic::{rumbo_pose2_of, rumbo_pose3_of, text_of, twist_of};
use crate::boundary::abi::*;
use crate::messages::{Data, Intrinsics, Mark, Marks, Observation};
use std::ffi::c_void;

/// Storage for views of observations, kept from call to call.
#[derive(Default)]
pub(crate) struct SeenLoan {
    data: Vec<AnyData>,
    marks: Vec<rumbo_mark>,
    items: Vec<rumbo_observation>,
}

enum AnyData {
    Odometry(rumbo_odometry),
    WheelSpeeds(rumbo_wheel_speeds),
    SteeringAngle(rumbo_steering_angle),
    LaserScan(rumbo_laser_scan),
    RangeRing(rumbo_range_ring),
    Bumpers(rumbo_bumpers),
    DepthImage(rumbo_depth_image),
    PointCloud(rumbo_point_cloud),
    Imu(rumbo_imu),
    PositionFix(rumbo_position_fix),
    Marks(rumbo_marks, usize),
    Custom(rumbo_custom),
}

// SAFETY: the raw pointers are read only while the observations that they were lent from are borrowed.
unsafe impl Send for SeenLoan {}

impl SeenLoan {
    /// Views of `observations`; they hold until the next call, and as long as the observations live.
    pub fn lend<'a>(&mut self, observations: impl Iterator<Item = &'a Observation> + Clone) -> rumbo_seen {
        self.data.clear();
        self.marks.clear();
        self.items.clear();
        for observation in observations.clone() {
            let data = self.lend_data(&observation.data);
            self.data.push(data);
        }
        // Nothing grows from here on, so pointers into the vectors hold.
        for data in &mut self.data {
            if let AnyData::Marks(marks, first) = data {
                marks.marks = self.marks.as_ptr().wrapping_add(*first);
            }
        }
        for (observation, data) in observations.zip(&self.data) {
            let (kind, data) = data.kind_and_pointer();
            self.items.push(rumbo_observation {
                size: size_of::<rumbo_observation>(),
                stamp_ns: observation.stamp.0,
                kind,
                sensor: observation.sensor.0,
                valid: observation.valid.into(),
                reserved: 0,
                base_from_sensor: rumbo_pose3_of(&observation.base_from_sensor),
                data,
            });
        }
        let stride = size_of::<rumbo_observation>();
        rumbo_seen {
            size: size_of::<rumbo_seen>(),
            len: self.items.len(),
            stride,
            first: self.items.as_ptr(),
        }
    }

    /// A view of marks alone.
    pub fn lend_marks(&mut self, marks: &Marks) -> rumbo_marks {
        self.marks.clear();
        self.marks.extend(marks.marks.iter().map(mark_of));
        rumbo_marks { marks: self.marks.as_ptr(), ..marks_of(marks) }
    }

    fn lend_data(&mut self, data: &Data) -> AnyData {
        match data {
            Data::Odometry(d) => AnyData::Odometry(rumbo_odometry {
                size: size_of::<rumbo_odometry>(),
                odom_from_base: rumbo_pose2_of(&d.odom_from_base),
                twist: twist_of(d.twist),
                noise: d.noise,
            }),
            Data::WheelSpeeds(d) => AnyData::WheelSpeeds(rumbo_wheel_speeds {
                size: size_of::<rumbo_wheel_speeds>(),
                n_wheels: d.n_wheels,
                reserved: 0,
                rim_m_s: d.rim_m_s,
            }),
            Data::SteeringAngle(d) => AnyData::SteeringAngle(rumbo_steering_angle {
                size: size_of::<rumbo_steering_angle>(),
                angle_rad: d.angle_rad,
            }),
            Data::LaserScan(d) => AnyData::LaserScan(rumbo_laser_scan {
                size: size_of::<rumbo_laser_scan>(),
                first_bearing_rad: d.first_bearing_rad,
                bearing_step_rad: d.bearing_step_rad,
                sweep_s: d.sweep_s,
                min_range_m: d.min_range_m,
                max_range_m: d.max_range_m,
                ranges_m: CArray::lend(&d.ranges_m),
                intensities: CArray::lend(&d.intensities),
            }),
            Data::RangeRing(d) => AnyData::RangeRing(rumbo_range_ring {
                size: size_of::<rumbo_range_ring>(),
                first_bearing_rad: d.first_bearing_rad,
                bearing_step_rad: d.bearing_step_rad,
                cone_rad: d.cone_rad,
                ring_radius_m: d.ring_radius_m,
                min_range_m: d.min_range_m,
                max_range_m: d.max_range_m,
                ranges_m: CArray::lend(&d.ranges_m),
            }),
            Data::Bumpers(d) => AnyData::Bumpers(rumbo_bumpers {
                size: size_of::<rumbo_bumpers>(),
                pressed: d.pressed,
                first_bearing_rad: d.first_bearing_rad,
                bearing_step_rad: d.bearing_step_rad,
                ring_radius_m: d.ring_radius_m,
                n_bumpers: d.n_bumpers,
                reserved: 0,
            }),
            Data::DepthImage(d) => AnyData::DepthImage(rumbo_depth_image {
                size: size_of::<rumbo_depth_image>(),
                intrinsics: intrinsics_of(&d.intrinsics),
                unit_m: d.unit_m,
                reserved: 0,
                depth: CArray::lend(&d.depth),
            }),
            Data::PointCloud(d) => AnyData::PointCloud(rumbo_point_cloud {
                size: size_of::<rumbo_point_cloud>(),
                points_m: CArray::lend(&d.points_m),
            }),
            Data::Imu(d) => AnyData::Imu(rumbo_imu {
                size: size_of::<rumbo_imu>(),
                has_attitude: d.attitude_rad.is_some().into(),
                reserved: 0,
                attitude_rad: d.attitude_rad.unwrap_or_default(),
                rates_rad_s: d.rates_rad_s,
                accelerations_m_s2: d.accelerations_m_s2,
            }),
            Data::PositionFix(d) => AnyData::PositionFix(rumbo_position_fix {
                size: size_of::<rumbo_position_fix>(),
                position_m: d.position_m,
                deviation_m: d.deviation_m,
            }),
            Data::Marks(d) => {
                let first = self.marks.len();
                self.marks.extend(d.marks.iter().map(mark_of));
                AnyData::Marks(marks_of(d), first)
            }
            Data::Custom(d) => AnyData::Custom(rumbo_custom {
                size: size_of::<rumbo_custom>(),
                schema: text_of(&d.schema),
                bytes: CArray::lend(&d.bytes),
            }),
        }
    }
}

impl AnyData {
    fn kind_and_pointer(&self) -> (u32, *const c_void) {
        fn at<T>(data: &T) -> *const c_void {
            std::ptr::from_ref(data).cast()
        }
        match self {
            AnyData::Odometry(d) => (RUMBO_ODOMETRY, at(d)),
            AnyData::WheelSpeeds(d) => (RUMBO_WHEEL_SPEEDS, at(d)),
            AnyData::SteeringAngle(d) => (RUMBO_STEERING_ANGLE, at(d)),
            AnyData::LaserScan(d) => (RUMBO_LASER_SCAN, at(d)),
            AnyData::RangeRing(d) => (RUMBO_RANGE_RING, at(d)),
            AnyData::Bumpers(d) => (RUMBO_BUMPERS, at(d)),
            AnyData::DepthImage(d) => (RUMBO_DEPTH_IMAGE, at(d)),
            AnyData::PointCloud(d) => (RUMBO_POINT_CLOUD, at(d)),
            AnyData::Imu(d) => (RUMBO_IMU, at(d)),
            AnyData::PositionFix(d) => (RUMBO_POSITION_FIX, at(d)),
            AnyData::Marks(d, _) => (RUMBO_MARKS, at(d)),
            AnyData::Custom(d) => (RUMBO_CUSTOM, at(d)),
        }
    }
}

fn mark_of(mark: &Mark) -> rumbo_mark {
    rumbo_mark {
        has_identity: mark.identity.is_some().into(),
        identity: mark.identity.unwrap_or_default(),
        range_m: mark.range_m,
        bearing_rad: mark.bearing_rad,
    }
}

fn marks_of(marks: &Marks) -> rumbo_marks {
    rumbo_marks {
        size: size_of::<rumbo_marks>(),
        len: marks.marks.len(),
        marks: std::ptr::null(),
        range_deviation_m: marks.range_deviation_m,
        bearing_deviation_rad: marks.bearing_deviation_rad,
    }
}

/// A camera.
pub(crate) fn intrinsics_of(camera: &Intrinsics) -> rumbo_intrinsics {
    let Intrinsics { width, height, focal_px, center_px } = *camera;
    rumbo_intrinsics { width, height, focal_px, center_px }
}
