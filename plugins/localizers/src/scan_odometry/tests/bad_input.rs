//! What a bad sensor may say: each row of the matrix of bad inputs that is about scans, stamps and what the robot begins with.

use super::*;
use rumbo_core::messages::{Check, DepthImage, Intrinsics};

/// A robot that drove for a second at 0.3 m/s.
fn driven(params: &ScanOdometryParams) -> (Box<dyn Localizer>, Pose2, Estimate) {
    let (mut localizer, mut at) = (started(params), Pose2::identity());
    let mut estimate = Estimate::lost(Time::ZERO);
    for k in 0..10 {
        let seconds = 0.1 * f64::from(k);
        estimate = update(&mut *localizer, seconds, &[scan(HALL, &at, seconds)]);
        at *= Twist::new(0.3, 0.0).integrate(0.1);
    }
    (localizer, at, estimate)
}

fn is_sound(estimate: &Estimate) -> bool {
    let covariance = estimate.covariance2();
    estimate.check().is_ok() && covariance.symmetric_eigenvalues().min() > 0.0
}

fn deviation_m(estimate: &Estimate) -> f64 {
    estimate.covariance2()[(0, 0)].sqrt()
}

#[test]
fn scans_of_nothing_leave_the_prediction_and_a_growing_covariance() {
    for value in [Some(f32::NAN), Some(f32::INFINITY), Some(0.0), None] {
        let (mut localizer, _, mut before) = driven(&ScanOdometryParams::default());
        for k in 10..40 {
            let seconds = 0.1 * f64::from(k);
            let mut blind = scan(HALL, &Pose2::identity(), seconds);
            if let Data::LaserScan(scan) = &mut blind.data {
                scan.min_range_m = 0.1;
                scan.ranges_m = Buffer::from(value.map_or(Vec::new(), |value| vec![value; N_BEAMS]));
            }
            let estimate = update(&mut *localizer, seconds, &[blind]);
            assert!(is_sound(&estimate), "{value:?}, {seconds} s");
            assert_ne!(estimate.status, Status::Tracking);
            assert!(deviation_m(&estimate) > deviation_m(&before), "{value:?}, {seconds} s");
            before = estimate;
        }
        assert_eq!(before.status, Status::Lost);
        let moved_m = before.pose2().translation.x - 0.27;
        assert!((0.0..0.25).contains(&moved_m), "it was carried on for half a second: {moved_m}");
    }
}

#[test]
fn single_beams_without_a_reading_cost_nothing() {
    let (mut localizer, at, _) = driven(&ScanOdometryParams::default());
    let mut spoiled = scan(HALL, &at, 1.0);
    if let Data::LaserScan(scan) = &mut spoiled.data {
        for (k, range) in scan.ranges_m.make_mut().iter_mut().enumerate() {
            *range = match k % 4 {
                0 => f32::NAN,
                1 => f32::INFINITY,
                _ => *range,
            };
        }
    }
    let estimate = update(&mut *localizer, 1.0, &[spoiled]);
    let [way_m, turn_rad] = apart(&estimate.pose2(), &at);
    assert!(estimate.status == Status::Tracking && way_m < 0.02 && turn_rad < 0.01, "{way_m} {turn_rad}");
}

#[test]
fn after_a_long_gap_the_robot_may_be_anywhere_near_until_a_scan_says_where() {
    let (mut localizer, at, before) = driven(&ScanOdometryParams::default());
    // Five seconds later nothing is seen, and the robot may have gone 2.5 m.
    let mut blind = scan(HALL, &at, 6.0);
    if let Data::LaserScan(scan) = &mut blind.data {
        scan.ranges_m = Buffer::from(vec![f32::NAN; N_BEAMS]);
    }
    let blinded = update(&mut *localizer, 6.0, &[blind]);
    assert!(is_sound(&blinded) && deviation_m(&before) < 0.05, "{}", deviation_m(&before));
    assert!((2.0..3.0).contains(&deviation_m(&blinded)), "{}", deviation_m(&blinded));
    let found = update(&mut *localizer, 6.1, &[scan(HALL, &at, 6.1)]);
    assert_eq!(found.status, Status::Tracking);
    let [way_m, turn_rad] = apart(&found.pose2(), &at);
    assert!(way_m < 0.03 && turn_rad < 0.02 && deviation_m(&found) < 0.1, "{way_m} {turn_rad}");
}

#[test]
fn stamps_that_do_not_grow_change_nothing() {
    let (mut localizer, at, _) = driven(&ScanOdometryParams::default());
    let before = update(&mut *localizer, 1.0, &[]);
    for seconds in [0.9, 0.5, 0.0] {
        let late = scan(HALL, &(at * pose2(0.2, 0.1, 0.1)), seconds);
        let estimate = update(&mut *localizer, 1.0, &[late]);
        assert_eq!(estimate, before, "{seconds} s");
    }
}

#[test]
fn numbers_that_cannot_be_are_refused_at_the_start() {
    let localizer =
        || Plugin::<dyn Localizer>::build(&ScanOdometryParams::default(), &BuildContext::bare("odometer"));
    let prior = |x_m: f64, covariance: Matrix3<f64>| Prior::Pose {
        map_from_base: pose2(x_m, 0.0, 0.0),
        odom_from_base: Pose2::identity(),
        covariance,
    };
    for bad in [prior(f64::NAN, Matrix3::zeros()), prior(0.0, -Matrix3::identity())] {
        assert!(localizer().unwrap().start(&bad, &Map::default()).is_err(), "{bad:?}");
    }
}

#[test]
fn bad_pictures_do_not_tilt_scans() {
    let params = ScanOdometryParams { vertical_slice: true, ..ScanOdometryParams::default() };
    let mut localizer = started(&params);
    let camera = Intrinsics { width: 8, height: 60, focal_px: [60.0, 60.0], center_px: [3.5, 29.5] };
    let picture = |depth: Vec<u16>| DepthImage { intrinsics: camera, unit_m: 0.001, depth: depth.into() };
    let bad = [picture(vec![0; 480]), picture(vec![1000; 7]), picture(vec![u16::MAX; 480])];
    let above = |observation: Observation| Observation {
        base_from_sensor: Pose3::translation(0.0, 0.0, 0.4),
        ..observation
    };
    for (k, image) in bad.into_iter().cycle().take(12).enumerate() {
        let seconds = 0.1 * k as f64;
        let seen = [observed(3, seconds, Data::DepthImage(image)), scan(HALL, &Pose2::identity(), seconds)]
            .map(above);
        let estimate = update(&mut *localizer, seconds, &seen);
        let [way_m, turn_rad] = apart(&estimate.pose2(), &Pose2::identity());
        assert!(is_sound(&estimate) && way_m < 0.02 && turn_rad < 0.01, "{k}: {way_m} {turn_rad}");
    }
}

/// As in logs that were written in bursts: the robot moves by a few centimeters from scan to scan, and its stamps say that
/// this took a millisecond, or a second.
#[test]
fn stamps_that_jitter_make_no_velocity_that_cannot_be() {
    let mut localizer = started(&ScanOdometryParams::default());
    let (mut at, mut seconds) = (Pose2::identity(), 0.0);
    for k in 0..60 {
        let mut taken = scan(HALL, &at, f64::from(k));
        taken.stamp = Time::from_secs(seconds);
        let estimate = update(&mut *localizer, seconds, &[taken]);
        let [way_m, turn_rad] = apart(&estimate.pose2(), &at);
        assert!(way_m < 0.04 && turn_rad < 0.02, "scan {k}, {seconds} s: {way_m} m, {turn_rad} rad");
        assert_eq!(estimate.status, Status::Tracking, "scan {k}");
        at *= pose2(0.05, 0.0, 0.06);
        seconds += [0.001, 0.3, 0.002, 0.9, 0.05][k as usize % 5];
    }
}
