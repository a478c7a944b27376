//! ROS 2's messages as observations. Twist and pose of an odometer are projected to the floor.

use super::layout::{IMU, LASER_SCAN, ODOMETRY, TRANSFORMS};
use crate::recording::cdr::{CdrError, CdrReader};
use nalgebra::{Quaternion, Translation3, UnitQuaternion};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist, flatten};
use rumbo_core::messages::{Imu, LaserScan};
use rumbo_core::time::Time;

/// What a message said.
#[derive(Debug, Clone, PartialEq)]
pub enum RosData {
    /// A planar scan.
    Scan(LaserScan),
    /// The pose of an odometer and its velocity.
    Odometry(Pose2, Twist),
    /// Attitude, rates, accelerations.
    Imu(Imu),
    /// Where frames are: parent, child, `parent_from_child`.
    Transforms(Vec<(String, String, Pose3)>),
}

/// A message with its own stamp.
#[derive(Debug, Clone, PartialEq)]
pub struct RosMessage {
    /// When it was measured.
    pub stamp: Time,
    /// In which frame.
    pub frame: String,
    /// What it says.
    pub data: RosData,
}

/// The schemas that [`read_ros`] understands.
pub fn readable_schemas() -> [&'static str; 4] {
    [LASER_SCAN.name, ODOMETRY, IMU, TRANSFORMS.name]
}

/// Reads a message of one of the [`readable_schemas`]; none of another.
pub fn read_ros(schema: &str, message: &[u8]) -> Result<Option<RosMessage>, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    if schema == TRANSFORMS.name {
        return transforms(&mut cdr).map(Some);
    }
    if !readable_schemas().contains(&schema) {
        return Ok(None);
    }
    let (stamp, frame) = header(&mut cdr)?;
    let data = if schema == LASER_SCAN.name {
        RosData::Scan(scan(&mut cdr)?)
    } else if schema == ODOMETRY {
        odometry(&mut cdr)?
    } else {
        RosData::Imu(imu(&mut cdr)?)
    };
    Ok(Some(RosMessage { stamp, frame, data }))
}

fn header(cdr: &mut CdrReader<'_>) -> Result<(Time, String), CdrError> {
    let (seconds, nanoseconds) = (cdr.i32()?, cdr.u32()?);
    Ok((Time(i64::from(seconds) * 1_000_000_000 + i64::from(nanoseconds)), cdr.text()?))
}

fn scan(cdr: &mut CdrReader<'_>) -> Result<LaserScan, CdrError> {
    let (first, _last, step) = (cdr.f32()?, cdr.f32()?, cdr.f32()?);
    let (per_step, _period) = (cdr.f32()?, cdr.f32()?);
    let (min_range_m, max_range_m) = (cdr.f32()?, cdr.f32()?);
    let (ranges, intensities) = (cdr.f32s()?, cdr.f32s()?);
    let sweep_s = f64::from(per_step) * ranges.len().saturating_sub(1) as f64;
    let fits = intensities.len() == ranges.len();
    Ok(LaserScan {
        first_bearing_rad: first.into(),
        bearing_step_rad: step.into(),
        sweep_s: if sweep_s.is_finite() && sweep_s > 0.0 { sweep_s } else { 0.0 },
        min_range_m,
        max_range_m,
        ranges_m: ranges.into_iter().map(|range| reading(range, max_range_m)).collect::<Vec<f32>>().into(),
        intensities: if fits { intensities.into() } else { Buffer::empty() },
    })
}

/// Drivers say zero, or the reach itself, where nothing came back; REP-117 says infinity.
fn reading(range_m: f32, max_range_m: f32) -> f32 {
    if range_m <= 0.0 || range_m >= max_range_m { f32::INFINITY } else { range_m }
}

fn pose(cdr: &mut CdrReader<'_>) -> Result<Pose3, CdrError> {
    let ([x, y, z], q) = (cdr.array()?, quaternion(cdr)?);
    // Some drivers leave a rotation that they do not know at zero.
    let rotation = q.unwrap_or_else(UnitQuaternion::identity);
    Ok(Pose3::from_parts(Translation3::new(x, y, z), rotation))
}

fn quaternion(cdr: &mut CdrReader<'_>) -> Result<Option<UnitQuaternion<f64>>, CdrError> {
    let [i, j, k, w] = cdr.array()?;
    Ok(UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-6))
}

fn odometry(cdr: &mut CdrReader<'_>) -> Result<RosData, CdrError> {
    let _child = cdr.text()?;
    let pose = pose(cdr)?;
    let _covariance: [f64; 36] = cdr.array()?;
    let ([forward_m_s, left_m_s, _up], [_roll, _pitch, turn_rad_s]) = (cdr.array()?, cdr.array()?);
    Ok(RosData::Odometry(flatten(&pose), Twist { forward_m_s, left_m_s, turn_rad_s }))
}

fn imu(cdr: &mut CdrReader<'_>) -> Result<Imu, CdrError> {
    let attitude = quaternion(cdr)?;
    let known: [f64; 9] = cdr.array()?;
    let rates_rad_s = cdr.array()?;
    let _rates: [f64; 9] = cdr.array()?;
    let accelerations_m_s2 = cdr.array()?;
    // A covariance that begins with -1 says that the device has no such reading.
    let attitude = attitude.filter(|_| known.first() != Some(&-1.0));
    let attitude_rad = attitude.map(|attitude| <[f64; 3]>::from(attitude.euler_angles()));
    Ok(Imu { attitude_rad, rates_rad_s, accelerations_m_s2 })
}

fn transforms(cdr: &mut CdrReader<'_>) -> Result<RosMessage, CdrError> {
    let n_transforms = cdr.length(64)?;
    let (mut stamp, mut all) = (Time::ZERO, Vec::with_capacity(n_transforms));
    for _ in 0..n_transforms {
        let (when, parent) = header(cdr)?;
        let child = cdr.text()?;
        stamp = stamp.max(when);
        all.push((parent, child, pose(cdr)?));
    }
    Ok(RosMessage { stamp, frame: String::new(), data: RosData::Transforms(all) })
}

#[cfg(test)]
mod tests {
    use super::super::write::{Stamped, put_scan, put_transforms};
    use super::*;
    use crate::recording::cdr::CdrWriter;

    #[test]
    fn a_scan_written_for_viewers_is_read_back_as_rep_117_wants_it() {
        let scan = LaserScan {
            first_bearing_rad: -1.5,
            bearing_step_rad: 0.5,
            sweep_s: 0.25,
            min_range_m: 0.1,
            max_range_m: 8.0,
            ranges_m: [0.0f32, 1.5, 8.0, f32::NAN, f32::INFINITY].as_slice().into(),
            intensities: Buffer::empty(),
        };
        let mut cdr = CdrWriter::default();
        put_scan(&mut cdr, Stamped { stamp: Time(-1), frame: "front" }, &scan);
        let message = read_ros(LASER_SCAN.name, cdr.bytes()).unwrap().unwrap();
        assert_eq!((message.stamp, message.frame.as_str()), (Time(-1), "front"));
        let RosData::Scan(read) = message.data else { panic!("a scan") };
        assert_eq!((read.first_bearing_rad, read.bearing_step_rad, read.sweep_s), (-1.5, 0.5, 0.25));
        let infinity = f32::INFINITY;
        assert_eq!(read.ranges_m[..3], [infinity, 1.5, infinity]);
        assert!(read.ranges_m[3].is_nan() && read.ranges_m[4] == infinity);
        for len in 0..cdr.bytes().len() {
            assert!(read_ros(LASER_SCAN.name, &cdr.bytes()[..len]).is_err(), "cut at {len}");
        }
    }

    #[test]
    fn a_big_endian_odometry_is_projected_to_the_floor() {
        let mut message = vec![0, 0, 0, 0];
        message.extend(3i32.to_be_bytes());
        message.extend(5u32.to_be_bytes());
        message.extend(5u32.to_be_bytes());
        message.extend(b"odom\0\0\0\0");
        message.extend(5u32.to_be_bytes());
        message.extend(b"base\0\0\0\0");
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let numbers = [1.0, 2.0, 9.0, 0.0, 0.0, half, half].into_iter().chain([0.5; 36]);
        let numbers = numbers.chain([0.25, 0.0, 0.0, 0.0, 0.0, -0.125]).chain([0.0; 36]);
        message.extend(numbers.flat_map(f64::to_be_bytes));
        let read = read_ros(ODOMETRY, &message).unwrap().unwrap();
        assert_eq!(read.stamp, Time(3_000_000_005));
        let RosData::Odometry(pose, twist) = read.data else { panic!("odometry") };
        assert_eq!((pose.translation.x, pose.translation.y), (1.0, 2.0));
        assert!((pose.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
        assert_eq!((twist.forward_m_s, twist.turn_rad_s), (0.25, -0.125));
    }

    #[test]
    fn transforms_keep_their_frames_and_other_schemas_are_left_alone() {
        let place = Pose3::translation(1.0, 2.0, 3.0);
        let mut cdr = CdrWriter::default();
        put_transforms(&mut cdr, Time(7), &[("map", "odom", place), ("odom", "base", Pose3::identity())]);
        let read = read_ros(TRANSFORMS.name, cdr.bytes()).unwrap().unwrap();
        let expected =
            vec![("map".into(), "odom".into(), place), ("odom".into(), "base".into(), Pose3::identity())];
        assert_eq!((read.stamp, read.data), (Time(7), RosData::Transforms(expected)));
        assert_eq!(read_ros("std_msgs/msg/String", cdr.bytes()), Ok(None));
    }
}
