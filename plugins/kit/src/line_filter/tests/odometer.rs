//! Errors of odometers: derivatives by finite differences, the motion by a textbook update, and whether drives teach them.

use super::{alike, close, seen, sure};
use crate::line_filter::odometer_errors::shift;
use crate::line_filter::*;
use crate::lines::SensedLine;
use nalgebra::{DMatrix, DVector, Matrix5, SMatrix, SVector, Vector5};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{FRAC_PI_2, PI};

const ALL: OdometerModel = OdometerModel { deviations: [0.05, 0.05, 0.03, 0.01, 0.05], wander_per_s: 0.0 };

/// Derivatives of a function by symmetric differences.
fn differences<const N: usize, const M: usize>(
    at: [f64; N],
    function: impl Fn([f64; N]) -> [f64; M],
) -> SMatrix<f64, M, N> {
    SMatrix::from_fn(|row, col| {
        let (mut up, mut down) = (at, at);
        (up[col], down[col]) = (up[col] + 1e-6, down[col] - 1e-6);
        (function(up)[row] - function(down)[row]) / 2e-6
    })
}

/// A filter whose state has a full covariance.
fn correlated(model: OdometerModel, rng: &mut Xoshiro256PlusPlus) -> LineFilter {
    let settings = FilterSettings { odometer: model, ..FilterSettings::default() };
    let (robot, covariance) = sure();
    let mut filter = LineFilter::building(settings, robot, &covariance);
    filter.read_lines(&[seen(4.0, 0.3, [-2.0, 2.0]), seen(3.0, 2.0, [-2.0, 2.0])], &Mount::default());
    let size = filter.state.covariance.size();
    let root = DMatrix::from_fn(size, size, |_, _| rng.random_range(-0.1..0.1));
    let full = &root * root.transpose() + DMatrix::identity(size, size) * 1e-4;
    filter.state.covariance.view_mut().copy_from(&full);
    filter.state.robot = Vector5::new(1.0, -2.0, 0.7, 0.4, -0.3);
    for (k, number) in filter.state.odometer.iter_mut().enumerate() {
        *number = 0.02 * (k as f64 + 1.0);
    }
    filter
}

#[test]
fn readings_and_what_is_behind_them_have_their_derivatives() {
    for [v, omega] in [[0.6, -0.4], [-0.3, 1.2], [0.0, 0.0]] {
        let errors = [0.03, -0.05, 0.02, -0.01, 0.1];
        let (read, by_all) = reading([v, omega], errors);
        let (back, by_errors, by_reading) = truth(read, errors);
        close(back[0], v, 1e-12, "speed");
        close(back[1], omega, 1e-12, "turn");
        let all = [v, omega, errors[0], errors[1], errors[2], errors[3]];
        let expected = differences(all, |[v, omega, a, b, c, d]| reading([v, omega], [a, b, c, d, 0.0]).0);
        assert!((by_all - expected).amax() < 1e-8, "{by_all}{expected}");
        let expected = differences(errors, |errors| truth(read, errors).0);
        assert!((by_errors - expected).amax() < 1e-8, "{by_errors}{expected}");
        let expected = differences(read, |read| truth(read, errors).0);
        assert!((by_reading - expected).amax() < 1e-8, "{by_reading}{expected}");
    }
}

#[test]
fn the_way_back_to_a_scan_is_the_way_of_its_jacobian_and_leads_here_again() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    for integration in [Integration::Midpoint, Integration::Euler] {
        let motion = MotionModel { integration, ..MotionModel::default() };
        let filter = correlated(ALL, &mut rng);
        let mut state = filter.state.clone();
        shift(&ALL, &motion, &mut state, -1.0);
        // x, y, theta, v, omega and the delay, which is the last error.
        let before: [f64; 6] =
            std::array::from_fn(|k| if k < 5 { filter.state.robot[k] } else { filter.state.odometer[4] });
        let moved = |[x, y, theta, v, omega, delay]: [f64; 6]| {
            let (robot, _) = motion.step(&Vector5::new(x, y, theta, v, omega), -delay);
            <[f64; 5]>::from(robot)
        };
        let by_all = differences(before, moved);
        let size = state.covariance.size();
        let mut full = DMatrix::identity(size, size);
        full.view_mut((0, 0), (5, 5)).copy_from(&by_all.fixed_columns::<5>(0));
        full.view_mut((0, ROBOT + 4), (5, 1)).copy_from(&by_all.fixed_columns::<1>(5));
        let expected = &full * filter.state.covariance.view() * full.transpose();
        alike(&state.covariance.view().into_owned(), &expected, 1e-8, "there");
        shift(&ALL, &motion, &mut state, 1.0);
        if integration == Integration::Midpoint {
            assert!((state.robot - filter.state.robot).amax() < 1e-12);
            let there = filter.state.covariance.view().into_owned();
            alike(&state.covariance.view().into_owned(), &there, 1e-9, "and back");
        }
    }
}

#[test]
fn what_an_odometer_reads_is_an_update_of_a_motion_that_nobody_knew() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for model in
        [ALL, OdometerModel { deviations: [0.0, 0.0, 0.03, 0.0, 0.0], ..ALL }, OdometerModel::default()]
    {
        let filter = correlated(model, &mut rng);
        let (read, variances) = ([0.5, -0.2], [1e-3, 2e-3]);
        let mut textbook = filter.state.clone();
        textbook.forget_motion([1e3; 2]);
        // Around the motion itself: the update is linear there.
        let (motion, ..) = truth(read, model.errors(&textbook));
        (textbook.robot[3], textbook.robot[4]) = (motion[0], motion[1]);
        let rows = model.odometer_rows(&textbook, read, variances);
        Update::new(&textbook, &rows).unwrap().fuse(&mut textbook, &rows, false);
        let mut state = filter.state.clone();
        model.move_as_read(&mut state, read, variances);
        assert!((state.robot - textbook.robot).amax() < 1e-6, "{} {}", state.robot, textbook.robot);
        let (found, expected) =
            (state.covariance.view().into_owned(), textbook.covariance.view().into_owned());
        alike(&found, &expected, 1e-6, "covariance");
    }
}

#[test]
fn an_odometers_way_is_kept_however_its_stamps_jitter() {
    let (robot, covariance) = sure();
    let mut filter = LineFilter::building(FilterSettings::default(), robot, &covariance);
    let mut way_m = 0.0;
    for k in 0..200 {
        // One step of 5 cm each; every other one seems four times as fast.
        let seconds = if k % 2 == 0 { 0.04 } else { 0.16 };
        way_m += 0.05;
        let reading = filter.roll([0.05 / seconds, 0.0], [1e-4, 1e-4], Steps { n: 1, seconds });
        assert!(matches!(reading, Reading::Fused(_)), "{reading:?}");
    }
    close(filter.state().robot[0], way_m, 1e-9, "way");
}

#[test]
fn variances_grow_with_the_way_and_the_turn_and_are_the_wheels_where_nobody_says() {
    let wheels = Wheels::default();
    let noise = OdometerNoise { standing: [0.0; 2], ..OdometerNoise::default() };
    let said = noise.of([0.1, 0.02, 0.05], &wheels);
    // After two seconds at 2 m/s and 0.5 rad/s: four meters and one radian.
    let [place, heading] = said.variances([2.0, 0.5], 2.0).map(|variance| variance * 4.0);
    close(place, 0.1 * 0.1 * 4.0, 1e-12, "place");
    close(heading, 0.02 * 0.02 * 4.0 + 0.05 * 0.05, 1e-12, "heading");
    let known = OdometerNoise { way: [0.2, 0.0, 0.0], ..noise }.of([0.1, 0.02, 0.05], &wheels);
    assert_eq!(known.way, [0.2, 0.02, 0.05], "what is known better is taken");
    let silent = noise.of([0.0; 3], &wheels).variances([2.0, 0.5], 0.1);
    close(silent[0], 0.02 * 0.02 / 2.0, 1e-15, "two wheels");
    close(silent[1], 0.02 * 0.02 / 2.0 / (0.45 * 0.45), 1e-15, "and their turn");
}

/// A room of 40 m x 30 m around the origin.
const WALLS: [[f64; 2]; 4] = [[20.0, 0.0], [15.0, FRAC_PI_2], [20.0, PI], [15.0, -FRAC_PI_2]];

/// What a drive leaves: errors less what is true of them, their covariance, and the pose's normalized error.
struct Taught {
    off: DVector<f64>,
    covariance: DMatrix<f64>,
    pose_nees: f64,
}

/// A minute through the room with errors drawn from their deviations; `model` is what the filter thinks.
fn drive(seed: u64, model: OdometerModel) -> Taught {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut normal = || (0..12).map(|_| rng.random_range(-0.5..0.5)).sum::<f64>();
    let errors: [f64; 5] = ALL.deviations.map(|deviation| deviation * normal());
    // Every line is what it is: the gate would cut off the tails of the noise.
    let gates = Gates { distance2: f64::INFINITY, ..Gates::default() };
    let settings = FilterSettings { odometer: model, gates, ..FilterSettings::default() };
    let (robot, covariance) = sure();
    let layer: Vec<_> = WALLS.iter().map(|wall| line_of(*wall)).collect();
    let mut filter = LineFilter::on_map(settings, robot, &covariance, &WallMap::new(&layer));
    let noise = OdometerNoise { way: [0.01, 0.005, 0.01], ..OdometerNoise::default() };
    let exact = MotionModel::default();
    let mut truth = robot;
    for k in 1..=600 {
        let t = 0.1 * f64::from(k);
        // What was started half a second ago goes on: a delay looks back into the same motion.
        let since = (t / 0.5 - 1e-9).floor() * 0.5;
        (truth[3], truth[4]) = (0.5 + 0.4 * (0.31 * since).sin(), 0.7 * (0.23 * since).cos());
        (truth, _) = exact.step(&truth, 0.1);
        let (read, _) = reading([truth[3], truth[4]], errors);
        let variances = noise.variances(read, 0.1);
        let read = [0, 1].map(|k| read[k] + variances[k].sqrt() * normal());
        filter.roll(read, variances, Steps { n: 1, seconds: 0.1 });
        if k % 5 == 0 {
            let (there, _) = exact.step(&truth, -errors[4]);
            let lines: Vec<SensedLine> =
                WALLS.iter().map(|wall| sighted(&there, *wall, &mut normal)).collect();
            assert_eq!(filter.read_lines(&lines, &Mount::default()).matches.len(), 4, "{seed} {t}");
        }
    }
    let state = filter.state();
    let pose = SVector::<f64, 3>::from_fn(|k, _| wrapped_if(k == 2, state.robot[k] - truth[k]));
    let n = state.odometer.len();
    Taught {
        off: DVector::from_fn(n, |k, _| state.odometer[k] - errors[k]),
        covariance: state.covariance.view().view((ROBOT, ROBOT), (n, n)).into_owned(),
        pose_nees: pose.dot(&(state.pose_covariance().try_inverse().unwrap() * pose)),
    }
}

fn wrapped_if(is_angle: bool, value: f64) -> f64 {
    if is_angle { rumbo_core::frames::wrap_angle(value) } else { value }
}

/// A wall of the room as a line of the map: 30 m long, the wall to the left.
fn line_of([rho, phi]: [f64; 2]) -> rumbo_core::map::Line {
    let (sin, cos) = phi.sin_cos();
    let at = |t: f64| [rho * cos - t * sin, rho * sin + t * cos];
    rumbo_core::map::Line { from: at(30.0), to: at(-30.0), covariance: [0.0; 3] }
}

/// The wall as it is seen from there, with the noise that `seen` claims.
fn sighted(robot: &Vector5<f64>, wall: [f64; 2], normal: &mut impl FnMut() -> f64) -> SensedLine {
    let line = PredictedLine::new(robot, &Mount::default(), wall);
    seen(line.distance_m + 0.01 * normal(), line.normal_rad + 1e-5f64.sqrt() * normal(), [-1.0, 1.0])
}

#[test]
fn drives_teach_the_errors_as_surely_as_the_filter_says() {
    let runs: Vec<Taught> = (0..40).map(|seed| drive(seed, ALL)).collect();
    let nees = runs.iter().map(|run| {
        let inverse = run.covariance.clone().try_inverse().unwrap();
        run.off.dot(&(inverse * &run.off))
    });
    let (mean, pose) = (nees.sum::<f64>() / 40.0, runs.iter().map(|run| run.pose_nees).sum::<f64>() / 40.0);
    // Chi square of 200 and of 120 degrees of freedom stays inside with 99.9 %.
    assert!((3.5..6.8).contains(&mean), "errors: {mean}, expected 5");
    assert!((1.8..4.4).contains(&pose), "pose: {pose}, expected 3");
    for k in 0..5 {
        let rms = (runs.iter().map(|run| run.off[k] * run.off[k]).sum::<f64>() / 40.0).sqrt();
        assert!(rms < 0.25 * ALL.deviations[k], "{k}: {rms} of {}", ALL.deviations[k]);
    }
    let untaught: f64 =
        (0..40).map(|seed| drive(seed, OdometerModel::default()).pose_nees).sum::<f64>() / 40.0;
    assert!(untaught > 10.0 * pose, "a filter that does not learn them is wrong of its pose: {untaught}");
}

#[test]
fn errors_wander_and_a_saved_state_has_them() {
    let (robot, _) = sure();
    let model = OdometerModel { wander_per_s: 0.1, ..ALL };
    let settings = FilterSettings { odometer: model, ..FilterSettings::default() };
    let mut filter = LineFilter::building(settings.clone(), robot, &Matrix5::identity());
    filter.predict(4.0);
    let variance = filter.state().covariance.view()[(ROBOT, ROBOT)];
    close(variance, 0.05 * 0.05 * (1.0 + 0.1 * 0.1 * 4.0), 1e-12, "variance");
    filter.state.odometer[2] = 0.0123;
    let saved = SavedFilter {
        start: rumbo_core::time::Time::ZERO,
        now: None,
        odom_from_base: [0.0; 3],
        odometry_stamp: None,
        filter,
    };
    let bytes = saved.to_bytes();
    let back = SavedFilter::from_bytes(&bytes, settings).unwrap();
    assert_eq!(back.filter.state(), saved.filter.state());
    let other = SavedFilter::from_bytes(&bytes, FilterSettings::default());
    assert!(matches!(other, Err(SavedFault::OtherErrors { found: 5, expected: 0 })), "{other:?}");
}
