//! Not-a-number and infinity stop at the door, in every message type.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use nalgebra::Matrix3;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose3, Twist, pose2};
use rumbo_core::messages::*;
use rumbo_core::time::Time;

const BAD: [f64; 3] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];

/// The message made of a good number passes, the one made of a bad number is refused by this field's name.
fn refuses<M: Check>(field: &str, make: impl Fn(f64) -> M) {
    assert_eq!(make(0.5).check(), Ok(()), "{field}");
    for bad in BAD {
        let fault = make(bad).check().err().unwrap_or_else(|| panic!("{field} passed with {bad}"));
        assert!(fault.to_string().contains(field), "{fault}");
    }
}

#[test]
fn odometry_wheels_and_steering_refuse_bad_numbers() {
    refuses("odom_from_base", |v| Odometry { odom_from_base: pose2(v, 0.0, 0.0), ..Odometry::default() });
    refuses("odom_from_base", |v| Odometry { odom_from_base: pose2(0.0, 0.0, v), ..Odometry::default() });
    refuses("twist", |v| Odometry { twist: Twist::new(0.0, v), ..Odometry::default() });
    refuses("noise", |v| Odometry { noise: [0.0, v, 0.0], ..Odometry::default() });
    refuses("rim_m_s", |v| WheelSpeeds { n_wheels: 2, rim_m_s: [0.0, v, 0.0, 0.0] });
    refuses("angle_rad", |v| SteeringAngle { angle_rad: v });
}

#[test]
fn range_messages_refuse_bad_headers_but_keep_the_readings_of_rep_117() {
    let scan = LaserScan { max_range_m: 8.0, ..LaserScan::default() };
    refuses("first_bearing_rad", |v| LaserScan { first_bearing_rad: v, ..scan.clone() });
    refuses("bearing_step_rad", |v| LaserScan { bearing_step_rad: v, ..scan.clone() });
    refuses("sweep_s", |v| LaserScan { sweep_s: v, ..scan.clone() });
    refuses("min_range_m", |v| LaserScan { min_range_m: v as f32, ..scan.clone() });
    refuses("max_range_m", |v| LaserScan { max_range_m: v as f32, ..scan.clone() });
    let with = |ranges: Vec<f32>| LaserScan { ranges_m: ranges.into(), ..scan.clone() };
    assert_eq!(with(vec![f32::NAN, f32::INFINITY, 1.0]).check(), Ok(()));
    assert!(with(vec![f32::NEG_INFINITY]).check().is_err() && with(vec![-0.1]).check().is_err());
    let uneven = LaserScan { intensities: Buffer::zeroed(2), ..with(vec![1.0]) };
    assert!(uneven.check().unwrap_err().to_string().contains("intensities"));
    let ring = RangeRing { cone_rad: 0.4, max_range_m: 8.0, ..RangeRing::default() };
    refuses("first_bearing_rad", |v| RangeRing { first_bearing_rad: v, ..ring.clone() });
    refuses("bearing_step_rad", |v| RangeRing { bearing_step_rad: v, ..ring.clone() });
    refuses("cone_rad", |v| RangeRing { cone_rad: v, ..ring.clone() });
    refuses("ring_radius_m", |v| RangeRing { ring_radius_m: v, ..ring.clone() });
    refuses("max_range_m", |v| RangeRing { max_range_m: v as f32, ..ring.clone() });
    refuses("first_bearing_rad", |v| Bumpers { first_bearing_rad: v, ..Bumpers::default() });
    refuses("bearing_step_rad", |v| Bumpers { bearing_step_rad: v, ..Bumpers::default() });
    refuses("ring_radius_m", |v| Bumpers { ring_radius_m: v, ..Bumpers::default() });
}

#[test]
fn pictures_and_clouds_refuse_bad_numbers_and_wrong_sizes() {
    let intrinsics = Intrinsics { width: 2, height: 1, focal_px: [500.0; 2], center_px: [1.0; 2] };
    let image = DepthImage { intrinsics, unit_m: 0.001, depth: Buffer::zeroed(2) };
    refuses("focal_px", |v| DepthImage {
        intrinsics: Intrinsics { focal_px: [v; 2], ..intrinsics },
        ..image.clone()
    });
    refuses("center_px", |v| DepthImage {
        intrinsics: Intrinsics { center_px: [v; 2], ..intrinsics },
        ..image.clone()
    });
    refuses("unit_m", |v| DepthImage { unit_m: v as f32, ..image.clone() });
    assert!(
        DepthImage { depth: Buffer::zeroed(3), ..image }.check().unwrap_err().to_string().contains("depth")
    );
    let cloud = |v: f32| PointCloud { points_m: vec![[0.0, v, 0.0]].into() };
    assert_eq!((cloud(1.0).check(), cloud(f32::NAN).check()), (Ok(()), Ok(())), "no reading");
    assert!(cloud(f32::INFINITY).check().is_err());
}

#[test]
fn inertia_fixes_marks_and_custom_messages_refuse_bad_numbers() {
    refuses("attitude_rad", |v| Imu { attitude_rad: Some([0.0, 0.0, v]), ..Imu::default() });
    refuses("rates_rad_s", |v| Imu { rates_rad_s: [v, 0.0, 0.0], ..Imu::default() });
    refuses("accelerations_m_s2", |v| Imu { accelerations_m_s2: [0.0, v, 0.0], ..Imu::default() });
    refuses("position_m", |v| PositionFix { position_m: [0.0, 0.0, v], ..PositionFix::default() });
    refuses("deviation_m", |v| PositionFix { deviation_m: [v, 0.0, 0.0], ..PositionFix::default() });
    let mark = |range_m: f64, bearing_rad: f64| Marks {
        marks: vec![Mark { identity: Some(3), range_m, bearing_rad }],
        ..Marks::default()
    };
    refuses("range_m", |v| mark(v, 0.0));
    refuses("bearing_rad", |v| mark(1.0, v));
    refuses("range_deviation_m", |v| Marks { range_deviation_m: v, ..Marks::default() });
    refuses("bearing_deviation_rad", |v| Marks { bearing_deviation_rad: v, ..Marks::default() });
    assert!(Custom::default().check().unwrap_err().to_string().contains("schema"));
}

#[test]
fn estimates_paths_goals_and_commands_refuse_bad_numbers() {
    let estimate =
        || Estimate::planar(Time::ZERO, pose2(0.0, 0.0, 0.0), pose2(0.0, 0.0, 0.0), Matrix3::identity());
    refuses("map_from_base", |v| Estimate { map_from_base: Pose3::translation(v, 0.0, 0.0), ..estimate() });
    refuses("map_from_odom", |v| Estimate { map_from_odom: Pose3::translation(0.0, 0.0, v), ..estimate() });
    refuses("covariance", |v| Estimate { covariance: nalgebra::Matrix6::from_element(v), ..estimate() });
    refuses("wish", |v| Estimate { wish: Some(Wish::TurnBy(v)), ..estimate() });
    let candidate = |score: f64| Candidate { map_from_base: pose2(0.0, 0.0, 0.0), score };
    refuses("score", |v| Estimate { candidates: vec![candidate(v)], ..estimate() });
    let point = |v: f64, yaw: Option<f64>| PathPoint { position: Point2::new(v, 0.0), yaw_rad: yaw };
    refuses("position", |v| Path::new(vec![point(v, None)], 0.0).unwrap());
    refuses("yaw_rad", |v| Path::new(vec![point(0.0, Some(v))], 0.0).unwrap());
    refuses("cost", |v| Path::new(vec![point(0.0, None)], v).unwrap());
    refuses("position", |v| Obstacle { position: Point2::new(0.0, v), radius_m: 0.0, stamp: Time::ZERO });
    refuses("radius_m", |v| Obstacle { position: Point2::origin(), radius_m: v, stamp: Time::ZERO });
    refuses("position", |v| Goal { position: Point2::new(v, 0.0), yaw_rad: None });
    refuses("yaw_rad", |v| Goal { position: Point2::origin(), yaw_rad: Some(v) });
    refuses("parts", |v| Command { stamp: Time::ZERO, twist: Twist::new(v, 0.0) });
    let prior = |v: f64| Prior::Pose {
        map_from_base: pose2(v, 0.0, 0.0),
        odom_from_base: pose2(0.0, 0.0, 0.0),
        covariance: Matrix3::identity(),
    };
    refuses("map_from_base", prior);
    assert_eq!(Path::new(Vec::new(), 0.0), None);
}

#[test]
fn an_observation_refuses_a_bad_mount() {
    let at = |v: f64| Observation {
        sensor: SensorId(0),
        stamp: Time::ZERO,
        base_from_sensor: Pose3::translation(v, 0.0, 0.0),
        valid: true,
        data: Data::SteeringAngle(SteeringAngle::default()),
    };
    refuses("base_from_sensor", at);
}
