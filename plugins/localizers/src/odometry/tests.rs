//! Dead reckoning against samples of imperfect odometers, and against everything a bad odometer may say.

use super::propagation::{ErrorGrowth, Uncertainty};
use super::*;
use nalgebra::{Matrix3, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, Pose3, Twist, flatten, pose2, wrap_angle};
use rumbo_core::map::Map;
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status};
use rumbo_core::registry::{Built, Params, Registry, Stage};
use rumbo_core::rng;
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

const NOISE: [f64; 3] = [0.03, 0.02, 0.04];

/// An S-shaped way with a turn in place between both halves and some sideways motion: steps of 2 cm or 0.01 rad.
fn steps() -> Vec<Twist> {
    let mut steps = vec![Twist::new(0.02, 0.012); 150];
    steps.extend(vec![Twist::new(0.0, -0.01); 120]);
    steps.extend(vec![Twist { forward_m_s: 0.02, left_m_s: 0.006, turn_rad_s: -0.008 }; 150]);
    steps
}

/// What the way becomes for a robot whose odometer is off by these errors: distance, direction, turn.
fn off(step: Twist, errors: Vector3<f64>) -> Twist {
    let length_m = step.speed_m_s();
    let longer = step.scaled(1.0 + errors[0]);
    let turn_rad_s = step.turn_rad_s * (1.0 + errors[2]) + length_m * errors[1];
    Twist { turn_rad_s, ..longer }
}

/// Covariance of the end pose over many robots, each with odometer errors drawn once or anew for every step.
fn sampled(start: Matrix3<f64>, growth: ErrorGrowth) -> (Matrix3<f64>, Pose2) {
    let mut rng = rng::stream(5, "monte carlo");
    let mut draw = || -> Vector3<f64> { Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng)) };
    let root = start.cholesky().unwrap().l();
    let (steps, begin) = (steps(), pose2(1.0, 2.0, 2.8));
    let end = steps.iter().fold(begin, |pose, step| pose * step.integrate(1.0));
    let n = 20_000;
    let mut sum = Matrix3::zeros();
    for _ in 0..n {
        let e = root * draw();
        let constant = draw();
        let begin = pose2(1.0 + e[0], 2.0 + e[1], 2.8 + e[2]);
        let reached = steps.iter().fold(begin, |pose, step| {
            let errors = match growth {
                ErrorGrowth::Constant => constant.component_mul(&Vector3::from(NOISE)),
                ErrorGrowth::Random => {
                    // Independent from step to step: a variance in proportion to the way.
                    let z = draw();
                    let (way_m, turn) = (step.speed_m_s().max(1e-12), step.turn_rad_s.abs().max(1e-12));
                    let per = [NOISE[0] / way_m.sqrt(), NOISE[1] / way_m.sqrt(), NOISE[2] / turn.sqrt()];
                    Vector3::new(z[0] * per[0], z[1] * per[1], z[2] * per[2])
                }
            };
            pose * off(*step, errors).integrate(1.0)
        });
        let error = Vector3::new(
            reached.translation.x - end.translation.x,
            reached.translation.y - end.translation.y,
            wrap_angle(reached.rotation.angle() - end.rotation.angle()),
        );
        sum += error * error.transpose();
    }
    (sum / f64::from(n), end)
}

#[test]
fn the_covariance_is_that_of_many_sampled_odometers() {
    let start = Matrix3::new(4e-4, 1e-4, 0.0, 1e-4, 9e-4, 2e-4, 0.0, 2e-4, 4e-4);
    for growth in [ErrorGrowth::Constant, ErrorGrowth::Random] {
        let (expected, end) = sampled(start, growth);
        let params = OdometryParams { error_growth: growth, ..OdometryParams::default() };
        let mut localizer = DeadReckoning::new(params, 0.5, 1.0);
        localizer
            .start(&prior(pose2(1.0, 2.0, 2.8), pose2(5.0, -3.0, -1.0), start), &Map::default())
            .unwrap();
        let mut odom_from_base = pose2(5.0, -3.0, -1.0);
        let mut estimate = None;
        for (idx, step) in steps().into_iter().enumerate() {
            odom_from_base *= step.integrate(1.0);
            estimate =
                Some(update(&mut localizer, &[reading(0.1 * (idx + 1) as f64, odom_from_base)]).unwrap());
        }
        let estimate = estimate.unwrap();
        assert!((estimate.pose2().to_homogeneous() - end.to_homogeneous()).norm() < 1e-9);
        let found = estimate.covariance2();
        for (row, col) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
            let scale = (expected[(row, row)] * expected[(col, col)]).sqrt();
            let off = (found[(row, col)] - expected[(row, col)]).abs() / scale;
            // Sampling gives two percent, the neglected second order as much again.
            assert!(off < 0.05, "{growth:?} {row} {col}: {} for {}", found[(row, col)], expected[(row, col)]);
        }
        assert!(found[(2, 2)] > 1.5 * start[(2, 2)], "the way adds something");
    }
}

#[test]
fn deviations_grow_with_the_way_or_with_its_root_however_finely_it_is_reported() {
    for (growth, expected_m) in [(ErrorGrowth::Constant, 0.16), (ErrorGrowth::Random, 0.04)] {
        for n in [4, 400, 40_000] {
            let mut uncertainty = Uncertainty::new(Matrix3::zeros());
            for _ in 0..n {
                let way = nalgebra::Vector2::new(0.0, 16.0 / f64::from(n));
                uncertainty.advance(way, 0.0, [0.01, 0.0, 0.0], growth);
            }
            let deviation_m = uncertainty.covariance()[(1, 1)].sqrt();
            assert!((deviation_m - expected_m).abs() < 1e-9, "{growth:?} {n}: {deviation_m}");
        }
    }
    // A heading that drifts by 0.001 rad a meter bends 16 m into an arc that ends 0.128 m beside its line.
    for n in [4, 400] {
        let mut uncertainty = Uncertainty::new(Matrix3::zeros());
        for _ in 0..n {
            let way = nalgebra::Vector2::new(0.0, 16.0 / f64::from(n));
            uncertainty.advance(way, 0.0, [0.0, 0.001, 0.0], ErrorGrowth::Constant);
        }
        let covariance = uncertainty.covariance();
        assert!((covariance[(0, 0)].sqrt() - 0.128).abs() < 1e-9, "{n}: {}", covariance[(0, 0)].sqrt());
        assert!((covariance[(0, 2)] + 0.128 * 0.016).abs() < 1e-9, "a turn to the left leads to the left");
    }
}

fn prior(map_from_base: Pose2, odom_from_base: Pose2, covariance: Matrix3<f64>) -> Prior {
    Prior::Pose { map_from_base, odom_from_base, covariance }
}

fn reading(seconds: f64, odom_from_base: Pose2) -> Observation {
    Observation {
        sensor: SensorId(0),
        stamp: Time::from_secs(seconds),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::Odometry(Odometry { odom_from_base, twist: Twist::ZERO, noise: NOISE }),
    }
}

fn update(localizer: &mut DeadReckoning, seen: &[Observation]) -> Result<Estimate, LocalizeError> {
    let trace = Trace::unwatched();
    localizer.update(
        &mut Cx { now: Time::from_secs(99.0), trace: &trace },
        Seen::sorted(seen),
        &Map::default(),
    )
}

/// Starts at (2, 1) looking along +y, where the odometer says (10, 0) looking along +x.
fn started() -> DeadReckoning {
    let mut localizer = DeadReckoning::new(OdometryParams::default(), 0.5, 1.0);
    let start = prior(pose2(2.0, 1.0, std::f64::consts::FRAC_PI_2), pose2(10.0, 0.0, 0.0), Matrix3::zeros());
    localizer.start(&start, &Map::default()).unwrap();
    localizer
}

fn place(estimate: &Estimate) -> (f64, f64) {
    let rounded = |v: f64| (v * 1e6).round() / 1e6;
    (rounded(estimate.pose2().translation.x), rounded(estimate.pose2().translation.y))
}

#[test]
fn the_odometer_is_followed_from_where_the_prior_put_it() {
    let mut localizer = started();
    let before = update(&mut localizer, &[]).unwrap();
    assert_eq!(
        (place(&before), before.stamp, before.status),
        ((2.0, 1.0), Time::from_secs(99.0), Status::Tracking)
    );
    let seen = [reading(1.0, pose2(10.3, 0.0, 0.0)), reading(2.0, pose2(10.6, 0.2, 0.1))];
    let after = update(&mut localizer, &seen).unwrap();
    assert_eq!((place(&after), after.stamp), ((1.8, 1.6), Time::from_secs(2.0)));
    assert_eq!(after.map_from_odom, before.map_from_odom);
    let yaw = after.pose2().rotation.angle();
    assert!((yaw - std::f64::consts::FRAC_PI_2 - 0.1).abs() < 1e-12);
    let again = update(&mut localizer, &[]).unwrap();
    assert_eq!(again, after, "nothing new");
}

#[test]
fn several_readings_at_once_are_as_good_as_one_by_one() {
    let readings: Vec<Observation> =
        (1..20).map(|k| reading(0.1 * f64::from(k), pose2(10.0 + 0.05 * f64::from(k), 0.0, 0.02))).collect();
    let (mut at_once, mut one_by_one) = (started(), started());
    let together = update(&mut at_once, &readings).unwrap();
    let last = readings.iter().map(|r| update(&mut one_by_one, std::slice::from_ref(r)).unwrap()).last();
    assert_eq!(Some(together), last);
}

#[test]
fn late_readings_change_nothing() {
    let (mut with_late, mut without) = (started(), started());
    let (early, late, newest) = (
        reading(1.0, pose2(10.1, 0.0, 0.0)),
        reading(1.5, pose2(10.2, 0.1, 0.3)),
        reading(2.0, pose2(10.3, 0.0, 0.0)),
    );
    let wrong = reading(2.0, pose2(10.9, 0.0, 0.0));
    update(&mut with_late, &[early.clone(), newest.clone()]).unwrap();
    let seen = [early.clone(), late, wrong];
    assert_eq!(update(&mut with_late, &seen), update(&mut without, &[early, newest]));
}

#[test]
fn a_jump_of_the_odometer_is_reported_once_and_the_pose_kept() {
    let mut localizer = started();
    update(&mut localizer, &[reading(1.0, pose2(10.4, 0.0, 0.0))]).unwrap();
    let seen = [reading(1.1, pose2(0.0, 0.0, 0.0)), reading(1.2, pose2(0.1, 0.0, 0.0))];
    let error = update(&mut localizer, &seen).unwrap_err();
    assert!(error.to_string().contains("jumped by 10.40 m and 0 degrees in 0.10 s"), "{error}");
    // The engine hands the same readings in once more after a failure.
    let estimate = update(&mut localizer, &seen).unwrap();
    assert_eq!(place(&estimate), (2.0, 1.5));
    assert!(estimate.covariance2()[(0, 0)] > 0.05f64.powi(2), "what happened meanwhile is unknown");
    let turned = [reading(1.3, pose2(0.1, 0.0, 3.0))];
    assert!(update(&mut localizer, &turned).unwrap_err().to_string().contains("172 degrees"));
}

#[test]
fn an_odometer_that_first_speaks_elsewhere_is_taken_at_its_word() {
    let mut localizer = DeadReckoning::new(OdometryParams::default(), 0.5, 1.0);
    let start = prior(pose2(2.0, 1.0, 0.0), Pose2::identity(), Matrix3::zeros());
    localizer.start(&start, &Map::default()).unwrap();
    let estimate = update(&mut localizer, &[reading(0.5, pose2(-40.0, 7.0, 2.0))]).unwrap();
    assert_eq!(place(&estimate), (2.0, 1.0));
    let seen = [reading(0.6, pose2(-40.0, 7.0, 2.0) * pose2(0.05, 0.0, 0.0))];
    assert_eq!(place(&update(&mut localizer, &seen).unwrap()), (2.05, 1.0));
}

#[test]
fn a_start_is_needed_and_needs_a_pose() {
    let mut localizer = DeadReckoning::new(OdometryParams::default(), 0.5, 1.0);
    assert_eq!(update(&mut localizer, &[]), Err(LocalizeError::NotStarted));
    assert_eq!(update(&mut localizer, &[reading(1.0, Pose2::identity())]), Err(LocalizeError::NotStarted));
    for (prior, word) in [(Prior::Unknown, "unknown"), (Prior::Saved(Vec::new().into()), "saved")] {
        let error = localizer.start(&prior, &Map::default()).unwrap_err();
        assert!(error.to_string().contains(word), "{error}");
    }
    let negative = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, 1.0));
    for covariance in [negative, Matrix3::from_element(f64::NAN)] {
        let start = prior(Pose2::identity(), Pose2::identity(), covariance);
        assert!(matches!(localizer.start(&start, &Map::default()), Err(LocalizeError::Message(_))));
    }
}

#[test]
fn numbers_that_are_none_are_refused_and_leave_no_trace() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut localizer = started();
        let seen = [reading(1.0, pose2(bad, 0.0, 0.0))];
        assert!(matches!(update(&mut localizer, &seen), Err(LocalizeError::Message(_))));
        let invalid = Observation { valid: false, ..reading(1.0, pose2(bad, 0.0, 0.0)) };
        let scan = Observation { data: Data::LaserScan(LaserScan::default()), ..invalid.clone() };
        assert_eq!(place(&update(&mut localizer, &[invalid, scan]).unwrap()), (2.0, 1.0));
    }
}

#[test]
fn a_new_start_forgets_the_old_way() {
    let mut localizer = started();
    update(&mut localizer, &[reading(5.0, pose2(10.4, 0.0, 0.0))]).unwrap();
    let start = prior(pose2(-1.0, 0.0, 0.0), pose2(10.4, 0.0, 0.0), Matrix3::zeros());
    localizer.start(&start, &Map::default()).unwrap();
    let estimate = update(&mut localizer, &[reading(5.1, pose2(10.5, 0.0, 0.0))]).unwrap();
    assert_eq!(place(&estimate), (-0.9, 0.0));
    assert!((estimate.covariance2()[(0, 0)].sqrt() - 0.1 * NOISE[0]).abs() < 1e-12);
    assert_eq!(flatten(&estimate.map_from_odom).translation.x, -11.4);
}

#[test]
fn the_registry_builds_it_from_its_defaults_and_every_bad_value_is_named() {
    let registry = Registry::linked().unwrap();
    let entry = registry.get(Stage::Localizer, "odometry").unwrap();
    let configured = entry.source.parse("error_growth = 'random'".parse().unwrap()).ok().unwrap();
    assert!(configured.check().is_empty());
    assert!(matches!(configured.build(&BuildContext::bare("localizer")), Ok(Built::Localizer(_))));
    let bad = OdometryParams { jump_m: 0.0, jump_deg: f64::NAN, ..OdometryParams::default() };
    let keys: Vec<String> = Params::check(&bad).into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["jump_m", "jump_deg"]);
}
