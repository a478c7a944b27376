//! How well robots are followed; figures with
//! `RUMBO_DRIVES=300 cargo test -p rumbo-localizers --lib triangulation::tests::tracking -- --nocapture`.

use super::super::params::{Estimator, TriangulationParams};
use super::drive::{Hardship, Outcome, drive};
use super::place::Office;
use crate::landmark_noise::LandmarkNoiseParams;

/// Map, length of the drive (meters), bar of the error in x and y (centimeters).
const DRIVES: [(&str, f64, f64); 3] = [("5x5", 3.8, 1.0), ("10x10", 7.6, 1.0), ("20x20", 18.5, 2.0)];

/// So many drives on each map, unless somebody wants more.
fn n_drives(usual: u64) -> u64 {
    std::env::var("RUMBO_DRIVES").ok().map_or(usual, |n| n.parse().unwrap())
}

/// Every drive has an office of its own with the same map, or the one that is exactly like it.
fn drives(map: &str, params: &TriangulationParams, hardship: &Hardship, usual: u64) -> Vec<Outcome> {
    let (_, length_m, _) = *DRIVES.iter().find(|(name, ..)| *name == map).unwrap();
    let settings = params.settings();
    (0..n_drives(usual))
        .map(|seed| drive(&Office::like(map, seed), &settings, length_m, hardship, seed))
        .collect()
}

fn with_noise(share: f64) -> TriangulationParams {
    let noise = LandmarkNoiseParams { share, ..LandmarkNoiseParams::default() };
    TriangulationParams { landmark_noise: Some(noise), ..TriangulationParams::default() }
}

/// Mean of the absolute errors at the end: centimeters and degrees.
fn mean_end(outcomes: &[Outcome], of: fn(&Outcome) -> [f64; 3]) -> [f64; 3] {
    let sum = |k: usize| outcomes.iter().map(|outcome| of(outcome)[k].abs()).sum::<f64>();
    let n = outcomes.len() as f64;
    [100.0 * sum(0) / n, 100.0 * sum(1) / n, sum(2) / n]
}

/// Mean of the squared errors in terms of the covariance, and the share beyond what one in a hundred should be.
fn nees(outcomes: &[Outcome]) -> (f64, f64) {
    let all: Vec<f64> = outcomes.iter().flat_map(|outcome| outcome.nees.clone()).collect();
    let n = all.len() as f64;
    (all.iter().sum::<f64>() / n, all.iter().filter(|nees| **nees > 11.3).count() as f64 / n)
}

/// Tells the figures to those who ask; gives the errors at the end.
#[allow(clippy::print_stdout)]
fn told(what: &str, outcomes: &[Outcome]) -> [f64; 3] {
    let (found, odometry) = (mean_end(outcomes, |o| o.end), mean_end(outcomes, |o| o.odometry_end));
    let worst = outcomes.iter().map(|outcome| outcome.worst_m).fold(0.0, f64::max);
    let n_beyond = outcomes.iter().filter(|o| o.end[0].hypot(o.end[1]) > 0.30).count();
    let counts = [0, 1, 2].map(|k| outcomes.iter().map(|o| o.counts[k] as f64).sum::<f64>());
    let n_starved: u64 = outcomes.iter().map(|o| o.n_starved).sum();
    let n_doubted = outcomes.iter().filter(|o| o.doubted).count();
    let (mean_nees, beyond) = nees(outcomes);
    let yaw: Vec<f64> = outcomes.iter().flat_map(|o| o.yaw_nees.clone()).collect();
    let yaw_nees = yaw.iter().sum::<f64>() / yaw.len() as f64;
    println!(
        "{what}: {:.2} / {:.2} cm, {:.2} deg ({} drives); odometry {:.0} / {:.0} cm, {:.1} deg; worst {worst:.3} m, \
         {n_beyond} end beyond 0.30 m; NEES {mean_nees:.2} (heading {yaw_nees:.2}), {:.1} % beyond 11.3; a scan: {:.1} relations, {:.1} estimates; \
         {n_starved} starved, {n_doubted} doubted",
        found[0],
        found[1],
        found[2],
        outcomes.len(),
        odometry[0],
        odometry[1],
        odometry[2],
        100.0 * beyond,
        counts[0] / counts[2],
        counts[1] / counts[2],
    );
    found
}

fn keeps_the_bar(what: &str, params: &TriangulationParams, hardship: &Hardship, usual: u64) {
    for (map, _, bar_cm) in DRIVES {
        let outcomes = drives(map, params, hardship, usual);
        let found = told(&format!("{what}, {map}"), &outcomes);
        assert!(found[0] <= bar_cm && found[1] <= bar_cm && found[2] <= 0.5, "{map}: {found:?}");
        assert!(outcomes.iter().all(|outcome| outcome.worst_m < 0.30), "{map}: a run is lost");
        assert!(outcomes.iter().all(|outcome| !outcome.was_lost), "{map}: a run is called lost");
    }
}

#[test]
fn the_bars_are_kept_with_an_odometer_that_errs_and_somebody_walking_ahead() {
    keeps_the_bar("default", &TriangulationParams::default(), &Hardship::default(), 15);
}

#[test]
fn the_bars_are_kept_with_a_perfect_odometer() {
    let hardship = Hardship { odometer_errs: false, ..Hardship::default() };
    keeps_the_bar("perfect odometry", &TriangulationParams::default(), &hardship, 6);
}

#[test]
fn the_bars_are_kept_with_an_odometer_that_boasts() {
    let hardship = Hardship { odometer_boasts: true, ..Hardship::default() };
    keeps_the_bar("boasting odometer", &TriangulationParams::default(), &hardship, 6);
}

#[test]
fn the_bars_are_kept_with_tilted_scans() {
    let hardship = Hardship { tilted: 0.05, ..Hardship::default() };
    keeps_the_bar("tilted scans", &TriangulationParams::default(), &hardship, 6);
}

#[test]
fn the_bars_are_kept_with_noise_on_every_fifth_landmark() {
    keeps_the_bar("20 % noise", &with_noise(0.2), &Hardship::default(), 8);
}

#[test]
fn the_bars_are_kept_with_noise_on_most_landmarks() {
    keeps_the_bar("40 % noise", &with_noise(0.4), &Hardship::default(), 4);
    keeps_the_bar("60 % noise", &with_noise(0.6), &Hardship::default(), 4);
}

#[test]
fn the_covariance_means_what_it_says() {
    for ((map, ..), usual) in DRIVES.into_iter().zip([20, 12, 5]) {
        let outcomes = drives(map, &TriangulationParams::default(), &Hardship::default(), usual);
        // Three degrees of freedom: 3 on average, and one in a hundred above 11.3.
        let (mean, beyond) = nees(&outcomes);
        assert!((1.5..4.0).contains(&mean) && beyond < 0.04, "{map}: {mean} {beyond}");
    }
    for share in [0.2, 0.6] {
        let (mean, beyond) = nees(&drives("10x10", &with_noise(share), &Hardship::default(), 10));
        assert!(
            (1.5..4.0).contains(&mean) && beyond < 0.04,
            "noise on {share} of the landmarks: {mean} {beyond}"
        );
    }
}

#[test]
fn pairs_follow_the_robot_on_the_map() {
    let pairs = TriangulationParams { estimator: Estimator::Pairs, ..TriangulationParams::default() };
    for (map, most_cm) in [("5x5", 3.0), ("10x10", 3.0)] {
        let found = told(&format!("pairs, {map}"), &drives(map, &pairs, &Hardship::default(), 10));
        assert!(found[0] < most_cm && found[1] < most_cm && found[2] < 0.5, "{found:?}");
    }
}

/// As printed, with the source's noise on landmarks, in offices that are exactly like their maps.
fn as_printed(map: &str, hardship: Hardship, usual: u64) -> [f64; 3] {
    let (_, length_m, _) = *DRIVES.iter().find(|(name, ..)| *name == map).unwrap();
    let thesis = TriangulationParams { thesis_mode: true, ..with_noise(0.2) };
    let hardship = Hardship { start_is_off: false, ..hardship };
    let office = Office::exact(map);
    let one = |seed| drive(&office, &thesis.settings(), length_m, &hardship, seed);
    let outcomes: Vec<Outcome> = (0..n_drives(usual)).map(one).collect();
    told(&format!("as printed, {map}, {hardship:?}"), &outcomes)
}

#[test]
fn the_source_s_way_is_as_good_as_in_the_reference_simulation() {
    // Mean errors in x, y (centimeters) and heading (degrees) of 30 drives with scans of 0.25 degrees, perfect odometry
    // and nobody in the way. Other routes and other chance: twice these is the same.
    let alone = Hardship { odometer_errs: false, has_walker: false, n_beams: 721, ..Hardship::default() };
    for (map, reference) in [("5x5", [5.4, 4.3, 1.3]), ("10x10", [7.3, 6.3, 2.1])] {
        let found = as_printed(map, alone, 30);
        for (found, reference) in found.iter().zip(reference) {
            assert!((0.5 * reference..2.0 * reference).contains(found), "{map}: {found} for {reference}");
        }
    }
    // Its points jump by a beam: with half the beams it is worse, and the default way is not.
    let coarse = as_printed("10x10", Hardship { n_beams: 361, ..alone }, 30);
    assert!(coarse[0] + coarse[1] > 13.6, "{coarse:?}");
}

#[test]
fn the_same_drive_gives_the_same_bits_also_with_noise() {
    let office = Office::like("5x5", 2);
    let once = |seed| drive(&office, &with_noise(0.6).settings(), 1.0, &Hardship::default(), seed);
    assert_eq!(format!("{:?}", once(2)), format!("{:?}", once(2)));
    assert_ne!(format!("{:?}", once(2)), format!("{:?}", once(3)));
}
