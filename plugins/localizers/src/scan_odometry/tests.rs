//! Odometry by scans in a room and a corridor whose walls are known, and with everything that a bad sensor may say.

mod bad_input;
mod corridor;
mod drift;
mod nodding;

use super::*;
use nalgebra::Matrix3;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2, wrap_angle};
use rumbo_core::map::Map;
use rumbo_core::messages::{
    Data, Estimate, Imu, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status,
};
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::rng;
use rumbo_core::stages::{BuildContext, Cx, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

/// Boxes from corner to corner, meters.
type Boxes = &'static [[f64; 4]];

/// A hall with three boxes; the robot drives in the middle.
const HALL: Boxes =
    &[[-5.0, -4.0, 7.0, 4.5], [2.5, 1.8, 3.4, 2.6], [-3.0, 1.5, -2.0, 3.0], [4.0, -3.0, 5.0, -2.2]];

/// Two walls that go on for ever, and a pillar beside the first meters.
const CORRIDOR: Boxes = &[[-500.0, -1.1, 500.0, 1.3], [1.0, 0.9, 1.3, 1.3]];

fn range_m(boxes: Boxes, at: &Pose2, bearing_rad: f64) -> f64 {
    let (sine, cosine) = (at.rotation.angle() + bearing_rad).sin_cos();
    let (x, y) = (at.translation.x, at.translation.y);
    let mut nearest_m = f64::INFINITY;
    for [x0, y0, x1, y1] in boxes {
        for (wall, from, along, across, low, high) in [
            (x0, x, cosine, (y, sine), y0, y1),
            (x1, x, cosine, (y, sine), y0, y1),
            (y0, y, sine, (x, cosine), x0, x1),
            (y1, y, sine, (x, cosine), x0, x1),
        ] {
            let range = (wall - from) / along;
            if range > 0.0 && (*low..=*high).contains(&(across.0 + range * across.1)) {
                nearest_m = nearest_m.min(range);
            }
        }
    }
    nearest_m
}

const N_BEAMS: usize = 361;

fn observed(sensor: u16, seconds: f64, data: Data) -> Observation {
    let base_from_sensor = Pose3::identity();
    Observation {
        sensor: SensorId(sensor),
        stamp: Time::from_secs(seconds),
        base_from_sensor,
        valid: true,
        data,
    }
}

/// A scan with a centimeter of noise.
fn scan(boxes: Boxes, at: &Pose2, seconds: f64) -> Observation {
    let mut rng = rng::stream((1e3 * seconds) as u64, "scan");
    let ranges = (0..N_BEAMS).map(|k| {
        let noise: f64 = StandardNormal.sample(&mut rng);
        (range_m(boxes, at, (0.5 * k as f64 - 90.0).to_radians()) + 0.01 * noise) as f32
    });
    observed(
        0,
        seconds,
        Data::LaserScan(LaserScan {
            first_bearing_rad: -90f64.to_radians(),
            bearing_step_rad: 0.5f64.to_radians(),
            max_range_m: 30.0,
            ranges_m: ranges.collect::<Vec<_>>().into(),
            ..LaserScan::default()
        }),
    )
}

fn wheels(odom_from_base: Pose2, seconds: f64) -> Observation {
    observed(1, seconds, Data::Odometry(Odometry { odom_from_base, noise: [0.02; 3], ..Odometry::default() }))
}

fn gyro(turn_rad_s: f64, seconds: f64) -> Observation {
    observed(2, seconds, Data::Imu(Imu { rates_rad_s: [0.0, 0.0, turn_rad_s], ..Imu::default() }))
}

fn started(params: &ScanOdometryParams) -> Box<dyn Localizer> {
    let mut localizer = Plugin::<dyn Localizer>::build(params, &BuildContext::bare("scan_odometry")).unwrap();
    let prior = Prior::Pose {
        map_from_base: Pose2::identity(),
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::zeros(),
    };
    localizer.start(&prior, &Map::default()).unwrap();
    localizer
}

fn update(localizer: &mut dyn Localizer, seconds: f64, seen: &[Observation]) -> Estimate {
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time::from_secs(seconds), trace: &trace };
    localizer.update(&mut cx, Seen::sorted(seen), &Map::default()).unwrap()
}

fn with(prediction: Prediction) -> ScanOdometryParams {
    ScanOdometryParams { prediction, ..ScanOdometryParams::default() }
}

/// How far apart two poses are, meters and radians.
fn apart(one: &Pose2, other: &Pose2) -> [f64; 2] {
    let way_m = (one.translation.vector - other.translation.vector).norm();
    [way_m, wrap_angle(one.rotation.angle() - other.rotation.angle()).abs()]
}

#[test]
fn a_drive_without_wheels_is_followed() {
    let mut localizer = started(&ScanOdometryParams::default());
    let mut at = Pose2::identity();
    for k in 0..150 {
        let seconds = 0.2 * f64::from(k);
        let estimate = update(&mut *localizer, seconds, &[scan(HALL, &at, seconds)]);
        let [way_m, turn_rad] = apart(&estimate.pose2(), &at);
        assert!(way_m < 0.04 && turn_rad < 0.02, "{seconds} s: {way_m} m, {turn_rad} rad");
        assert_eq!(estimate.status, Status::Tracking);
        assert_eq!(estimate.stamp, Time::from_secs(seconds));
        at *= Twist::new(0.3, 0.25).integrate(0.2);
    }
    let deviation_m = update(&mut *localizer, 30.0, &[]).covariance2()[(0, 0)].sqrt();
    assert!((0.005..0.5).contains(&deviation_m), "{deviation_m}");
}

/// What one run says at all scans, with wheels that slip by half and now and then jump, or without.
fn run(params: &ScanOdometryParams, has_wheels: bool) -> Vec<Estimate> {
    let mut localizer = started(params);
    let (mut at, mut odom_from_base, mut said) = (Pose2::identity(), Pose2::identity(), Vec::new());
    for k in 0..60 {
        let seconds = 0.2 * f64::from(k);
        let mut seen = vec![gyro(0.3, seconds - 0.01), scan(HALL, &at, seconds)];
        if has_wheels {
            seen.insert(0, wheels(odom_from_base, seconds - 0.02));
            let between = wheels(odom_from_base, seconds - 0.1);
            update(&mut *localizer, seconds - 0.1, &[between]);
        }
        said.push(update(&mut *localizer, seconds, &seen));
        at *= Twist::new(0.3, 0.3).integrate(0.2);
        odom_from_base *= Twist::new(0.15, if k % 9 == 0 { 3.0 } else { 0.1 }).integrate(0.2);
    }
    said
}

#[test]
fn wheels_that_nobody_asked_for_change_nothing_to_the_bit() {
    for prediction in [Prediction::Gyro, Prediction::ConstantVelocity, Prediction::None] {
        let params = with(prediction);
        for (with, without) in run(&params, true).iter().zip(&run(&params, false)) {
            assert_eq!(with.map_from_base, without.map_from_base, "{prediction:?}");
            assert_eq!(with.covariance, without.covariance);
            assert_eq!((with.stamp, with.status), (without.stamp, without.status));
        }
    }
    let params = with(Prediction::Wheels);
    let differ =
        run(&params, true).iter().zip(&run(&params, false)).any(|(a, b)| a.map_from_base != b.map_from_base);
    assert!(differ, "a pipeline that asks for wheels gets them");
}

#[test]
fn the_correction_is_that_of_the_odometry_at_the_time_of_the_estimate() {
    for estimate in run(&ScanOdometryParams::default(), true).iter().skip(1) {
        let odom_from_base = estimate.map_from_odom.inverse() * estimate.map_from_base;
        assert!(odom_from_base.translation.vector.norm() > 0.01);
    }
    let last = run(&ScanOdometryParams::default(), false).pop().unwrap();
    assert_eq!(last.map_from_odom, last.map_from_base, "without odometry its frame is where the base began");
}

/// Along a corridor at a constant speed that then changes.
fn along_corridor(params: &ScanOdometryParams) -> (Estimate, Pose2) {
    let mut localizer = started(params);
    let mut at = Pose2::identity();
    // The pillar is in sight at first, and tells the speed.
    let mut estimate = Estimate::lost(Time(0));
    for k in 0..40 {
        let seconds = 0.2 * f64::from(k);
        estimate = update(&mut *localizer, seconds, &[wheels(at, seconds), scan(CORRIDOR, &at, seconds)]);
        let speed_m_s = if k < 20 { 0.4 } else { 0.2 };
        at *= Twist::new(speed_m_s, 0.0).integrate(0.2);
    }
    (estimate, pose2(2.4 - 0.04, 0.0, 0.0))
}

#[test]
fn along_a_corridor_the_way_is_that_of_wheels_where_they_are_asked() {
    let (by_wheels, truth) = along_corridor(&with(Prediction::Wheels));
    let [way_m, turn_rad] = apart(&by_wheels.pose2(), &truth);
    assert!(way_m < 0.15 && turn_rad < 0.02, "{way_m} m, {turn_rad} rad");
}

#[test]
fn a_gyro_announces_turns_that_matches_alone_would_miss() {
    let off = |has_gyro: bool| {
        let params = ScanOdometryParams { retries: 0, ..ScanOdometryParams::default() };
        let mut localizer = started(&params);
        let (mut at, mut worst_rad) = (Pose2::identity(), 0f64);
        for k in 0..30u32 {
            let seconds = 0.5 * f64::from(k);
            let turn_rad_s = if k % 10 < 3 { 1.4 } else { 0.0 };
            let mut seen = vec![scan(HALL, &at, seconds)];
            if has_gyro {
                seen.extend((0..25).map(|j| gyro(turn_rad_s, seconds + 0.02 * f64::from(j))));
            }
            let estimate = update(&mut *localizer, seconds, &seen[..1]);
            worst_rad = worst_rad.max(apart(&estimate.pose2(), &at)[1]);
            update(&mut *localizer, seconds + 0.49, &seen[1..]);
            at *= Twist::new(0.0, turn_rad_s).integrate(0.5);
        }
        worst_rad
    };
    let (with, without) = (off(true), off(false));
    assert!(with < 0.03, "{with} rad");
    assert!(without > 0.3, "{without} rad: then this test shows nothing");
}

#[test]
fn between_scans_the_gyro_turns_the_robot_on() {
    let mut localizer = started(&ScanOdometryParams::default());
    for k in 0..5 {
        let seconds = 0.1 * f64::from(k);
        update(&mut *localizer, seconds, &[gyro(0.0, seconds), scan(HALL, &Pose2::identity(), seconds)]);
    }
    let ahead: Vec<Observation> = (1..6).map(|k| gyro(1.0, 0.4 + 0.01 * f64::from(k))).collect();
    let estimate = update(&mut *localizer, 0.46, &ahead);
    assert_eq!(estimate.stamp, Time::from_secs(0.45));
    let turn_rad = estimate.pose2().rotation.angle();
    assert!((turn_rad - 0.04).abs() < 0.006, "{turn_rad}");
}

#[test]
fn a_gyro_that_hangs_upside_down_turns_the_right_way_round() {
    let mut motion = Motion::new(Prediction::Gyro, 0.5, 0.01);
    let guess =
        |motion: &Motion, to_s: f64| motion.guess(Time::ZERO, Time::from_secs(to_s), Twist::ZERO, None).step;
    let down = Pose3::rotation(nalgebra::Vector3::x() * std::f64::consts::PI);
    for k in 0..11 {
        let Data::Imu(imu) = gyro(-0.5, 0.0).data else { unreachable!() };
        assert!(motion.take_imu(Time::from_secs(0.1 * f64::from(k)), &down, &imu));
    }
    let step = guess(&motion, 1.0);
    assert!((step.rotation.angle() - 0.5).abs() < 1e-9, "{step}");
    let too_late = guess(&motion, 2.0);
    assert_eq!(too_late, Pose2::identity(), "a gap of a second is not bridged, and nothing was learned");
}

/// A robot that turns by 40 degrees from scan to scan and is 0.3 m on, and one that stands while its wheels turn.
#[test]
fn of_wheels_and_velocity_the_one_counts_that_the_scan_supports() {
    let far = |k: u32| pose2(0.3 * f64::from(k), 0.0, 0.7 * f64::from(k));
    let near = |_| Pose2::identity();
    for (prediction, turned, truth) in [
        (Prediction::Either, far as fn(u32) -> Pose2, far as fn(u32) -> Pose2),
        (Prediction::Either, far, near),
        (Prediction::Wheels, far, far),
    ] {
        let mut localizer = started(&ScanOdometryParams { prediction, ..ScanOdometryParams::default() });
        for k in 0..3 {
            let seconds = f64::from(k);
            let seen = [wheels(turned(k), seconds), scan(HALL, &truth(k), seconds)];
            update(&mut *localizer, seconds, &seen);
        }
        let estimate = update(&mut *localizer, 2.0, &[]);
        let [way_m, turn_rad] = apart(&estimate.pose2(), &truth(2));
        assert!(way_m < 0.02 && turn_rad < 0.01, "{prediction:?}: {way_m} m, {turn_rad} rad");
    }
}

#[test]
fn what_says_nothing_leaves_the_prediction_and_ends_as_lost() {
    let mut localizer = started(&ScanOdometryParams::default());
    let step = Twist::new(0.3, 0.0).integrate(0.1);
    let mut at = Pose2::identity();
    for k in 0..10 {
        let seconds = 0.1 * f64::from(k);
        update(&mut *localizer, seconds, &[scan(HALL, &at, seconds)]);
        at *= step;
    }
    let blind = |seconds: f64, value: f32| {
        let mut blind = scan(HALL, &Pose2::identity(), seconds);
        if let Data::LaserScan(scan) = &mut blind.data {
            scan.ranges_m = Buffer::from(vec![value; N_BEAMS]);
        }
        blind
    };
    let mut before = update(&mut *localizer, 0.95, &[]);
    for k in 10..30 {
        let seconds = 0.1 * f64::from(k);
        let estimate =
            update(&mut *localizer, seconds, &[blind(seconds, [f32::NAN, f32::INFINITY][k as usize % 2])]);
        let expected = if k < 19 { Status::Converging } else { Status::Lost };
        assert_eq!(estimate.status, expected, "{k}");
        assert!(estimate.covariance2()[(0, 0)] > before.covariance2()[(0, 0)]);
        let way_m = estimate.pose2().translation.x - before.pose2().translation.x;
        let expected_m = if k < 14 {
            0.03
        } else if k < 16 {
            way_m.clamp(-1e-9, 0.031)
        } else {
            0.0
        };
        assert!((way_m - expected_m).abs() < 0.006, "{k}: {way_m} m");
        before = estimate;
    }
    let again = update(&mut *localizer, 3.0, &[scan(HALL, &before.pose2(), 3.0)]);
    assert_eq!(again.status, Status::Tracking);
}

#[test]
fn late_and_foreign_and_impossible_readings_are_left_out_and_counted() {
    let settings = ScanOdometryParams::default().settings(&BuildContext::bare("scan_odometry").robot);
    let mut tracker = Tracker::new(settings, Pose2::identity(), Matrix3::zeros(), Pose2::identity());
    tracker.take(&scan(HALL, &Pose2::identity(), 1.0));
    let before = tracker.estimate(Time::from_secs(2.0));
    let elsewhere = pose2(0.5, 0.3, 0.2);
    tracker.take(&scan(HALL, &elsewhere, 1.0));
    tracker.take(&scan(HALL, &elsewhere, 0.5));
    tracker.take(&Observation { sensor: SensorId(7), ..scan(HALL, &elsewhere, 1.2) });
    let mut impossible = scan(HALL, &elsewhere, 1.3);
    if let Data::LaserScan(scan) = &mut impossible.data {
        scan.first_bearing_rad = f64::NAN;
    }
    tracker.take(&impossible);
    tracker.take(&gyro(f64::NAN, 1.4));
    assert_eq!(tracker.estimate(Time::from_secs(2.0)), before);
    let counts = tracker.counts();
    assert_eq!((counts.n_late, counts.n_other, counts.n_refused, counts.n_keys), (2, 1, 2, 1));
    let mut motion = Motion::new(Prediction::Gyro, 0.5, 0.01);
    let imu = Imu { rates_rad_s: [0.0, 0.0, 40.0], ..Imu::default() };
    assert!(!motion.take_imu(Time(1), &Pose3::identity(), &imu), "nothing turns so fast");
}

#[test]
fn a_start_needs_a_pose_and_numbers_that_can_be() {
    let mut localizer =
        Plugin::<dyn Localizer>::build(&ScanOdometryParams::default(), &BuildContext::bare("scan_odometry"))
            .unwrap();
    assert!(localizer.start(&Prior::Unknown, &Map::default()).is_err());
    let trace = Trace::unwatched();
    let mut cx = Cx { now: Time(0), trace: &trace };
    assert!(localizer.update(&mut cx, Seen::NOTHING, &Map::default()).is_err(), "not started");
    assert!(ScanOdometryParams::default().check().is_empty());
    let bad = ScanOdometryParams {
        trim: 1.0,
        min_overlap: -0.1,
        least_match_m: 0.5,
        huber_m: 0.0,
        carry_on_s: f64::NAN,
        max_iterations: 0,
        retries: 1000,
        ..ScanOdometryParams::default()
    };
    let faults: Vec<String> = bad.check().iter().map(ToString::to_string).collect();
    assert_eq!(faults.len(), 7, "{faults:?}");
    assert!(Plugin::<dyn Localizer>::build(&bad, &BuildContext::bare("scan_odometry")).is_err());
}
