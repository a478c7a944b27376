//! Scans all around: no wall is cut, wherever the readings begin.

use super::*;
use std::f64::consts::TAU;

/// Readings all around, from bearing zero.
fn around(walls: &Walls, n: usize) -> Vec<Reading> {
    let step = TAU / n as f64;
    let reading = |k: usize| {
        let (bearing, none) = (step * k as f64, Reading { place: [0.0; 2], range_m: f64::NAN });
        let range = range_to(walls, bearing);
        if range < 8.0 { Reading::at(bearing, range) } else { none }
    };
    (0..n).map(reading).collect()
}

fn found(readings: &[Reading]) -> Vec<Landmark> {
    let mut extractor = Extractor::new(LandmarkSettings::default());
    extractor.extract_circular(readings.iter().copied(), TAU / readings.len().max(1) as f64, 8.0).to_vec()
}

/// What must not depend on where the readings begin, to the micrometer, in an order of its own.
fn essence(landmarks: &[Landmark]) -> Vec<(char, [i64; 3])> {
    let whole = |value: f64| (value * 1e6).round() as i64;
    let one = |landmark: &Landmark| {
        let [x, y] = landmark.position();
        (landmark.letter(), [whole(x), whole(y), whole(landmark.extent_m().unwrap_or(0.0))])
    };
    let mut all: Vec<_> = landmarks.iter().map(one).collect();
    all.sort_unstable();
    all
}

/// A room with a box (jumps), one with a door to nowhere (no readings), and an empty one (corners only).
fn rooms() -> Vec<Walls> {
    let empty: Walls = room(0.3)[..4].to_vec();
    let mut open = empty.clone();
    let [[ax, ay], [bx, by]] = open[0];
    let at = |share: f64| [ax + share * (bx - ax), ay + share * (by - ay)];
    open[0] = [at(0.0), at(0.4)];
    open.push([at(0.6), at(1.0)]);
    vec![room(0.3), open, empty]
}

#[test]
fn landmarks_do_not_depend_on_where_the_readings_begin() {
    for (idx, walls) in rooms().iter().enumerate() {
        let readings = around(walls, 360);
        let as_is = essence(&found(&readings));
        assert!(as_is.len() >= 8, "{idx}: {as_is:?}");
        for by in [1, 2, 45, 90, 177, 300, 359] {
            let mut turned = readings.clone();
            turned.rotate_left(by);
            assert_eq!(essence(&found(&turned)), as_is, "room {idx}, begun at {by}");
        }
    }
}

#[test]
fn a_wall_that_a_scan_from_end_to_end_would_cut_is_whole() {
    // Straight ahead, where the readings begin, lies the middle of a wall 4 m long.
    let readings = around(&room(0.0)[..4].to_vec(), 360);
    let lengths = |landmarks: &[Landmark]| -> Vec<f64> {
        let mut lengths: Vec<f64> =
            landmarks.iter().filter(|l| l.is_wall()).filter_map(Landmark::extent_m).collect();
        lengths.sort_by(f64::total_cmp);
        lengths
    };
    let whole = lengths(&found(&readings));
    let expected = [4.0, 4.0, 6.0, 6.0];
    assert_eq!(whole.len(), 4, "{whole:?}");
    whole.iter().zip(expected).for_each(|(found, expected)| assert!((found - expected).abs() < 0.15));
    let fan = BeamFan { first_bearing_rad: 0.0, bearing_step_rad: TAU / 360.0, ..half_turn(1.0) };
    let ranges: Vec<f64> = readings.iter().map(|reading| reading.range_m).collect();
    assert_eq!(lengths(&extract(LandmarkSettings::default(), &fan, &ranges)).len(), 5);
}

#[test]
fn beams_are_those_of_the_readings_as_they_were_given() {
    for by in [0, 100, 250] {
        let mut readings = around(&room(0.3), 360);
        readings.rotate_left(by);
        for landmark in found(&readings) {
            let [first, last] = landmark.beams.map(|beam| readings[beam as usize]);
            let near = if let LandmarkKind::Wall { .. } = landmark.kind {
                let (sin, cos) = landmark.bearing_rad.sin_cos();
                let off = |r: &Reading| (r.place[0] * cos + r.place[1] * sin - landmark.distance_m).abs();
                off(&first).max(off(&last))
            } else {
                (first.range_m - landmark.distance_m).abs().min((last.range_m - landmark.distance_m).abs())
            };
            assert!(near < 0.15, "{landmark:?}");
        }
    }
}

#[test]
fn rooms_without_any_feature_and_scans_without_readings_are_survived() {
    let none = Reading { place: [0.0; 2], range_m: f64::NAN };
    let round: Vec<Reading> = (0..360).map(|k| Reading::at(f64::from(k) * TAU / 360.0, 0.07)).collect();
    assert!(found(&round).is_empty());
    for n in 0..6 {
        found(&vec![none; n]);
        found(&round[..n]);
        let mut one_silent = round.clone();
        one_silent[n] = none;
        found(&one_silent);
    }
    let far = Reading { place: [f64::INFINITY; 2], range_m: f64::INFINITY };
    found(&[far, none, far, round[0], far]);
}
