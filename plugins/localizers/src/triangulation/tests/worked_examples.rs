//! Worked examples of the method: numbers in, numbers out.

use super::super::correspondence::Relation;
use super::super::fusion::{ODOMETRY_WEIGHT, circular_mean, turns, weighted_mean};
use super::super::pairs::{PairEstimate, intersection, line_through, pair_estimate, two_circles};
use super::super::quality::{Weighting, weight};
use super::{corner, wall};
use toml::Value;

const PRODUCT: Weighting = Weighting::Product { least_sine: 0.3 };

fn file() -> toml::Table {
    toml::from_str(include_str!("../../../tests/data/natural_landmark/worked_examples.toml")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_float().or(value.as_integer().map(|v| v as f64)).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn place(value: &Value) -> [f64; 2] {
    [number(&value[0]), number(&value[1])]
}

fn is_near(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-6, "{found} for {expected}");
}

fn are_near(found: [f64; 2], expected: &Value) {
    is_near(found[0], number(&expected[0]));
    is_near(found[1], number(&expected[1]));
}

#[test]
fn circles_around_two_points_meet_where_they_should() {
    for case in file()["triangulation"].as_array().unwrap() {
        let points = [place(&case["m0"]), place(&case["m1"])];
        let ranges = [number(&case["d0"]), number(&case["d1"])];
        let found = two_circles(points, ranges);
        if let Some(candidates) = case.get("candidates") {
            let found = found.unwrap();
            are_near(found[0], &candidates[0]);
            are_near(found[1], &candidates[1]);
        }
        let relation = |k: usize| {
            let mut seen = corner([1.0, k as f64]);
            seen.distance_m = ranges[k];
            Relation { known: corner(points[k]), seen, off_m: 0.0 }
        };
        let odometry = case.get("odometry").map_or([0.0; 2], place);
        let estimate = pair_estimate(&relation(0), &relation(1), odometry);
        match case.get("estimate") {
            Some(Value::String(_)) => assert!(estimate.is_none()),
            Some(expected) => are_near(estimate.unwrap().position, expected),
            None => is_near(estimate.unwrap().position[1].abs(), number(&case["lateral_error"])),
        }
    }
    assert!(two_circles([[1.0, 0.0], [1.05, 0.0]], [1.0, 1.0]).is_none(), "too near to each other");
}

#[test]
fn parallels_to_two_walls_meet_where_they_should() {
    for case in file()["line_intersection"].as_array().unwrap() {
        let [theta, a, b] = ["theta_a", "d_a", "d_b"].map(|key| numbers(&case[key]));
        let relation =
            |k: usize| Relation { known: wall(a[k], theta[k]), seen: wall(b[k], theta[k]), off_m: 0.0 };
        are_near(pair_estimate(&relation(0), &relation(1), [0.0; 2]).unwrap().position, &case["estimate"]);
        if let (Some(one), Some(two)) = (case.get("line1"), case.get("line2")) {
            let line = |value: &Value| [0, 1, 2].map(|k| number(&value[k]));
            are_near(intersection(line(one), line(two)).unwrap(), &case["estimate"]);
        }
    }
    let relation = |theta: f64| Relation { known: wall(2.0, theta), seen: wall(1.9, theta), off_m: 0.0 };
    assert!(pair_estimate(&relation(10.0), &relation(18.0), [0.0; 2]).is_none(), "parallel");
    let point = Relation { known: corner([1.0, 0.0]), seen: corner([1.0, 0.0]), off_m: 0.0 };
    assert!(pair_estimate(&relation(10.0), &point, [0.0; 2]).is_none(), "a wall and a point");
}

#[test]
fn a_line_goes_through_its_two_points() {
    let case = &file()["line_through_two_points"];
    let found = line_through(place(&case["p1"]), place(&case["p2"]));
    for (found, key) in found.into_iter().zip(["a", "b", "c"]) {
        is_near(found, number(&case[key]));
    }
}

fn pair(position: [f64; 2], separation_deg: f64, farthest_m: f64, on_both_sides: bool) -> PairEstimate {
    PairEstimate { position, separation_rad: separation_deg.to_radians(), farthest_m, on_both_sides }
}

#[test]
fn weights_are_the_printed_ones_and_products_the_better_ones() {
    for case in file()["weight"].as_array().unwrap() {
        let sides = case["both_sides"].as_bool().unwrap();
        let pair = pair([0.0; 2], number(&case["separation"]), number(&case["farthest"]), sides);
        is_near(weight(&pair, Weighting::Mean), number(&case["p"]));
        is_near(weight(&pair, Weighting::Product { least_sine: 0.0 }), number(&case["p_product"]));
        let is_sharp = number(&case["separation"]).to_radians().sin() >= 0.3;
        assert!(is_sharp || weight(&pair, PRODUCT) == 0.0);
    }
}

#[test]
fn pairs_and_odometry_are_fused_by_their_weights() {
    let file = file();
    let (case, better) = (&file["fusion"], &file["fusion_extension"]);
    let pairs: Vec<PairEstimate> = case["estimates"]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers)
        .map(|row| pair([row[0], row[1]], row[2], row[3], row[4] > 0.5))
        .collect();
    for (weighting, case, odometry) in [(Weighting::Mean, case, case), (PRODUCT, better, case)] {
        let mut estimates: Vec<_> = pairs
            .iter()
            .map(|pair| (pair.position, weight(pair, weighting)))
            .filter(|(_, w)| *w > 0.0)
            .collect();
        for ((_, found), expected) in estimates.iter().zip(numbers(&case["weights"])) {
            is_near(*found, expected);
        }
        estimates.push((place(&odometry["odometry"]), ODOMETRY_WEIGHT));
        is_near(estimates.iter().map(|(_, weight)| weight).sum(), number(&case["total_weight"]));
        are_near(weighted_mean(&estimates).unwrap(), &case["fused"]);
    }
    assert!(weighted_mean(&[]).is_none());
}

#[test]
fn the_turn_is_the_circular_mean_over_all_marks_also_across_the_seam() {
    let case = &file()["orientation"];
    let relations: Vec<Relation> = case["mark"]
        .as_array()
        .unwrap()
        .iter()
        .map(|mark| {
            let known = match mark.get("position_in_a") {
                Some(position) => corner(place(position)),
                None => wall(number(&mark["normal_in_a"][0]), number(&mark["normal_in_a"][1])),
            };
            let bearing_rad = number(&mark["beta"]).to_radians();
            Relation { known, seen: rumbo_kit::landmarks::Landmark { bearing_rad, ..known }, off_m: 0.0 }
        })
        .collect();
    let found = turns(&relations, place(&case["position"]));
    for (turn, mark) in found.iter().zip(case["mark"].as_array().unwrap()) {
        is_near(turn.to_degrees(), number(&mark["delta"]));
    }
    is_near(circular_mean(&found).unwrap().to_degrees(), number(&case["heading_change"]));
    let case = &file()["circular_mean"];
    let angles: Vec<f64> = numbers(&case["values"]).into_iter().map(f64::to_radians).collect();
    is_near(circular_mean(&angles).unwrap().to_degrees(), number(&case["circular_mean"]));
}

#[test]
fn constants_of_the_weights_are_those_learned_from_the_tables() {
    let text = include_str!("../../../tests/data/natural_landmark/quality_tables.toml");
    let file: toml::Table = toml::from_str(text).unwrap();
    let constants = &file["weights"];
    let of = |key: &str| number(&constants[key]);
    let good = &file["table_5_3"]["good"];
    assert_eq!([number(&good[0]), number(&good[1])], [of("f_sides_same"), of("f_sides_both")]);
    assert_eq!(ODOMETRY_WEIGHT, of("odometry"));
    // Landmarks at the reach and in line: only the sides are left, a third of the mean.
    for (both_sides, key) in [(true, "f_sides_both"), (false, "f_sides_same")] {
        let worst = pair([0.0; 2], 0.0, of("f_dis_range"), both_sides);
        is_near(weight(&worst, Weighting::Mean), of(key) / 3.0);
    }
}

#[test]
fn pairs_that_the_source_calls_good_weigh_more_than_those_it_calls_bad() {
    let text = include_str!("../../../tests/data/natural_landmark/quality_tables.toml");
    let file: toml::Table = toml::from_str(text).unwrap();
    let rows = file["table_5_1"][0]["rows"].as_array().unwrap();
    for weighting in [Weighting::Mean, Weighting::Product { least_sine: 0.0 }] {
        let weights = |class: &str| -> Vec<f64> {
            let of_class = rows.iter().filter(|row| row[4].as_str() == Some(class));
            of_class
                .map(|row| {
                    let pair = pair([0.0; 2], number(&row[0]), number(&row[2]), number(&row[3]) > 0.5);
                    weight(&pair, weighting)
                })
                .collect()
        };
        let least = |class: &str| weights(class).into_iter().fold(f64::INFINITY, f64::min);
        let most = |class: &str| weights(class).into_iter().fold(0.0, f64::max);
        assert!(least("good") > most("regular") && least("good") > most("bad"));
        // The mean of three is kind to a bad pair whose landmarks are on both sides; the product is not.
        assert!(weighting == Weighting::Mean || least("regular") > most("bad"));
    }
}
