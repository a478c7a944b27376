use super::*;

/// Begins of up to 10 cm and 4 degrees beside the truth.
const STARTS: [[f64; 3]; 5] =
    [[0.0; 3], [0.1, -0.05, 0.05], [-0.1, 0.03, -0.07], [0.04, 0.1, 0.07], [-0.06, -0.1, -0.05]];

fn errors(settings: &ScanOdometrySettings, starts: &[[f64; 3]], noise_m: f64, n_seeds: u64) -> Vec<[f64; 2]> {
    let (mut registrar, walls) = (Registrar::default(), room());
    let mut found = Vec::new();
    for seed in 0..n_seeds {
        let mut rng = rng(seed);
        let at = pose2(0.3 * seed as f64 - 0.8, 0.1, 0.7 * seed as f64);
        let step = pose2(0.12, -0.02, 0.06);
        let key = key_of(&seen(&walls, &at, 361, noise_m, &mut rng), settings);
        let points = placed(&seen(&walls, &(at * step), 361, noise_m, &mut rng));
        for [x, y, yaw] in starts.iter().copied() {
            let matched = registrar.register(&key, &points, &prior(step * pose2(x, y, yaw)), settings);
            assert_eq!(matched.status, MatchStatus::Ok, "{seed}: {matched:?}");
            found.push(apart(&matched.key_from_base, &step));
        }
    }
    found
}

fn mean(errors: &[[f64; 2]]) -> [f64; 2] {
    let sum = errors.iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
    sum.map(|v| v / errors.len() as f64)
}

#[test]
fn a_scan_without_noise_is_placed_within_a_millimeter() {
    for lines in [LineKind::Neighbor, LineKind::Fitted] {
        let settings = ScanOdometrySettings { lines, ..ScanOdometrySettings::default() };
        for [way_m, turn_rad] in errors(&settings, &STARTS, 0.0, 6) {
            assert!(way_m < 1e-3 && turn_rad < 5e-4, "{lines:?}: {way_m} m, {turn_rad} rad");
        }
    }
}

#[test]
fn with_noise_of_a_centimeter_a_scan_is_placed_within_millimeters_and_fitted_lines_help() {
    let of = |lines, starts: &[[f64; 3]]| {
        let settings = ScanOdometrySettings { lines, ..ScanOdometrySettings::default() };
        mean(&errors(&settings, starts, 0.01, 12))
    };
    let ([neighbor_m, _], [fitted_m, fitted_rad]) =
        (of(LineKind::Neighbor, &STARTS[..1]), of(LineKind::Fitted, &STARTS));
    assert!(fitted_m < 0.003 && fitted_rad < 0.001, "{fitted_m} m, {fitted_rad} rad");
    assert!(fitted_m < 0.9 * neighbor_m, "{fitted_m} m beside {neighbor_m} m");
}

#[test]
fn the_covariance_is_as_large_as_the_errors_are() {
    let settings =
        ScanOdometrySettings { min_std_m: 1e-5, min_std_rad: 1e-5, ..ScanOdometrySettings::default() };
    let (mut registrar, walls, step) = (Registrar::default(), room(), pose2(0.1, 0.0, 0.05));
    let (mut sum, n) = (0.0, 200);
    for seed in 0..n {
        let mut rng = rng(1000 + seed);
        let at = pose2(-0.5, 0.2, 0.4);
        let key = key_of(&seen(&walls, &at, 361, 0.01, &mut rng), &settings);
        let points = placed(&seen(&walls, &(at * step), 361, 0.01, &mut rng));
        let matched = registrar.register(&key, &points, &prior(step), &settings);
        let error = registration::numbers(&matched.key_from_base) - registration::numbers(&step);
        sum += (matched.covariance.try_inverse().unwrap() * error).dot(&error);
    }
    let mean_nees = sum / n as f64;
    assert!((0.7..8.0).contains(&mean_nees), "{mean_nees}, 3 were ideal");
}

#[test]
fn a_way_through_the_room_adds_up_with_keys_and_without_a_prior() {
    let (walls, mut rng) = (room(), rng(7));
    let mut odometer =
        ScanOdometer::new(ScanOdometrySettings::default(), Pose2::identity(), Matrix3::zeros());
    let start = pose2(0.0, -2.3, 0.0);
    let (mut at, mut n_keys, mut last) = (start, 0, Pose2::identity());
    for k in 0..200 {
        let scan = seen(&walls, &at, 361, 0.01, &mut rng);
        let step =
            odometer.take(&scan, &Pose3::identity(), &Pose2::identity(), &(Matrix3::identity() * 0.01));
        n_keys += usize::from(step.is_key);
        last *= step.last_from_base;
        let [way_m, turn_rad] = apart(&odometer.odom_from_base(), &(start.inverse() * at));
        assert!(way_m < 0.02 && turn_rad < 0.008, "scan {k}: {way_m} m, {turn_rad} rad");
        at *= rumbo_core::frames::Twist::new(0.04, 0.03).integrate(1.0);
    }
    assert!((30..110).contains(&n_keys), "{n_keys} keys in 8 m and 6 rad");
    let [way_m, turn_rad] = apart(&last, &odometer.odom_from_base());
    assert!(way_m < 1e-9 && turn_rad < 1e-9, "the steps add up to the pose: {way_m} m, {turn_rad} rad");
    let deviation_m = odometer.covariance()[(0, 0)].sqrt();
    assert!((0.005..0.5).contains(&deviation_m), "{deviation_m}");
}

#[test]
fn a_turn_that_nothing_announced_is_found_by_looking_from_other_directions() {
    let (walls, mut rng) = (room(), rng(11));
    let settings = ScanOdometrySettings::default();
    let run = |settings: ScanOdometrySettings, rng: &mut Xoshiro256PlusPlus| {
        let mut odometer = ScanOdometer::new(settings, Pose2::identity(), Matrix3::zeros());
        let (at, step) = (pose2(-1.0, -1.0, 0.3), pose2(0.1, 0.0, 0.4));
        for pose in [at, at * step] {
            let scan = seen(&walls, &pose, 361, 0.01, rng);
            odometer.take(&scan, &Pose3::identity(), &Pose2::identity(), &Matrix3::identity());
        }
        apart(&odometer.odom_from_base(), &step)
    };
    let [way_m, turn_rad] = run(settings, &mut rng);
    assert!(way_m < 0.02 && turn_rad < 0.01, "{way_m} m, {turn_rad} rad");
}

#[test]
fn what_matches_badly_or_hardly_leaves_the_prior_and_says_so() {
    let (settings, mut registrar) = (ScanOdometrySettings::default(), Registrar::default());
    let mut rng = rng(2);
    let at = Pose2::identity();
    let full = seen(&room(), &at, 361, 0.01, &mut rng);
    let key = key_of(&full, &settings);
    let given = prior(pose2(0.05, 0.01, 0.02));
    let told = |matched: &Registration| {
        assert_eq!(matched.key_from_base, given.key_from_base);
        assert_eq!(matched.covariance, given.covariance);
        matched.status
    };
    let mut few = full.clone();
    few.ranges_m.make_mut().iter_mut().skip(20).for_each(|range| *range = f32::NAN);
    let matched = registrar.register(&key, &placed(&few), &given, &settings);
    assert_eq!(told(&matched), MatchStatus::TooFewPoints);
    let mut empty = full.clone();
    empty.ranges_m.make_mut().fill(f32::INFINITY);
    let matched = registrar.register(&key, &placed(&empty), &given, &settings);
    assert_eq!(told(&matched), MatchStatus::TooFewPoints);
    let blind = key_of(&empty, &settings);
    assert_eq!(
        told(&registrar.register(&blind, &placed(&full), &given, &settings)),
        MatchStatus::TooFewPoints
    );
    let elsewhere: Vec<Wall> = around(&[[-9.0, -8.0], [8.0, -9.0], [9.0, 8.0], [-8.0, 9.0]]);
    let other = placed(&seen(&elsewhere, &at, 361, 0.01, &mut rng));
    assert!(!told(&registrar.register(&key, &other, &given, &settings)).is_good());
    let start = registration::numbers(&given.key_from_base);
    let close = ScanOdometrySettings { max_correction_m: 0.01, ..settings };
    let near = placed(&seen(&room(), &at, 361, 0.01, &mut rng));
    let matched = registrar.register_from(&key, &near, (start, &given.key_from_base), &given, &close);
    assert_eq!(told(&matched), MatchStatus::Diverged, "it is at the key, 5 cm from the prior");
    let mut rough = full.clone();
    for (k, range) in rough.ranges_m.make_mut().iter_mut().enumerate() {
        *range += if k % 3 == 0 {
            0.2
        } else if k % 3 == 1 {
            -0.2
        } else {
            0.0
        };
    }
    let matched = registrar.register(&key, &placed(&rough), &given, &settings);
    assert_eq!(told(&matched), MatchStatus::Diverged, "{matched:?}");
}

#[test]
fn a_scanner_that_hangs_upside_down_or_turned_gives_the_same_way() {
    let (walls, settings) = (room(), ScanOdometrySettings::default());
    let step = pose2(0.1, 0.02, 0.05);
    let at = pose2(0.5, 0.0, 0.3);
    let mount = pose2(0.2, -0.1, 2.0);
    let flipped = Pose3::rotation(nalgebra::Vector3::x() * std::f64::consts::PI);
    let mut odometer = ScanOdometer::new(settings, Pose2::identity(), Matrix3::zeros());
    for pose in [at, at * step] {
        let mut scan = seen(&walls, &(pose * mount), 361, 0.0, &mut rng(0));
        // Seen from below, the beams go the other way round.
        scan.ranges_m.make_mut().reverse();
        let base_from_sensor = rumbo_core::frames::lift(&mount) * flipped;
        odometer.take(&scan, &base_from_sensor, &Pose2::identity(), &Matrix3::identity());
    }
    let [way_m, turn_rad] = apart(&odometer.odom_from_base(), &step);
    assert!(way_m < 1e-3 && turn_rad < 5e-4, "{way_m} m, {turn_rad} rad");
}

#[test]
fn a_warm_scan_allocates_nothing() {
    let (walls, mut rng) = (room(), rng(5));
    let scans: Vec<LaserScan> =
        (0..8).map(|k| seen(&walls, &pose2(0.1 * f64::from(k), 0.0, 0.0), 541, 0.01, &mut rng)).collect();
    let mut odometer =
        ScanOdometer::new(ScanOdometrySettings::default(), Pose2::identity(), Matrix3::zeros());
    let mut take = |scan: &LaserScan, x_m: f64| {
        odometer.take(scan, &Pose3::identity(), &pose2(x_m, 0.0, 0.0), &(Matrix3::identity() * 0.01))
    };
    let n_keys = scans.iter().filter(|scan| take(scan, 0.1).is_key).count();
    assert!(n_keys > 1, "{n_keys}");
    let info = allocation_counter::measure(|| {
        let n_keys = scans.iter().rev().filter(|scan| take(scan, -0.1).is_key).count();
        assert!(n_keys > 1, "{n_keys}");
    });
    assert_eq!(info.count_total, 0);
}

/// The prior is far ahead and turned the wrong way round, as after a scan whose stamp was wrong.
#[test]
fn a_prediction_that_is_all_wrong_is_given_up_for_a_look_around_the_last_place() {
    let (walls, mut rng) = (room(), rng(12));
    for turn_rad in [-0.9, -0.5, 0.0, 0.7] {
        let settings = ScanOdometrySettings { far_retries: 3, ..ScanOdometrySettings::default() };
        let mut odometer = ScanOdometer::new(settings, Pose2::identity(), Matrix3::zeros());
        let (at, step) = (pose2(-1.0, -1.0, 0.3), pose2(0.05, 0.0, turn_rad));
        let wrong = pose2(1.4, 0.5, -1.2 * f64::signum(turn_rad));
        for (pose, guess) in [(at, Pose2::identity()), (at * step, wrong)] {
            let scan = seen(&walls, &pose, 361, 0.01, &mut rng);
            odometer.take(&scan, &Pose3::identity(), &guess, &Matrix3::identity());
        }
        let [way_m, off_rad] = apart(&odometer.odom_from_base(), &step);
        assert!(way_m < 0.02 && off_rad < 0.01, "{turn_rad}: {way_m} m, {off_rad} rad");
    }
}
