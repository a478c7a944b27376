//! The printed example of the relaxation, with a geometry that gives it.

use super::super::match_score::{heading_rad, heading_scatter_rad, headings_rad, squared_error_m2};
use super::super::relaxation::{Assignment, RelationTolerance, Relations, best, relax};
use rumbo_kit::landmark_model::Similarity;
use rumbo_kit::landmarks::{Landmark, LandmarkKind, Side};

fn file() -> toml::Table {
    toml::from_str(include_str!("../../../tests/data/natural_landmark/table7_1_relaxation.toml")).unwrap()
}

fn landmarks(rows: &toml::Value) -> Vec<Landmark> {
    rows.as_array().unwrap().iter().map(landmark).collect()
}

fn landmark(row: &toml::Value) -> Landmark {
    let [distance_m, bearing_deg, extent_m] = [1, 2, 3].map(|idx| row[idx].as_float().unwrap());
    let hiding = |hidden| LandmarkKind::Discontinuity { hidden, jump_m: extent_m, spacing_m: 0.02 };
    let kind = match row[0].as_str().unwrap() {
        "wall" => LandmarkKind::Wall { length_m: extent_m, unit_covariance: [0.0; 3], unevenness_m: 0.0 },
        "disc_i" => hiding(Side::Left),
        "disc_d" => hiding(Side::Right),
        other => panic!("{other}"),
    };
    Landmark { distance_m, bearing_rad: bearing_deg.to_radians(), kind, beams: [0; 2] }
}

/// The printed example with this treatment of separations.
fn relaxed(is_signed: bool) -> (Vec<Landmark>, Vec<Landmark>, Vec<Assignment>) {
    let file = file();
    let geometry = &file["geometry"];
    let number = |key: &str| geometry[key].as_float().unwrap();
    let alike =
        Similarity { distance_m: number("attribute_tolerance_d"), extent_m: number("attribute_tolerance_p") };
    let within = RelationTolerance {
        distance_m: number("relation_tolerance_distance"),
        angle_rad: number("relation_tolerance_angle").to_radians(),
        is_signed,
    };
    let [observed, model] = ["observed", "model"].map(|key| landmarks(&geometry[key]));
    let [seen, known] = [&observed, &model].map(|set| Relations::of(set));
    let allowed = relax((&observed, &seen), (&model, &known), &alike, &within);
    (observed, model, allowed)
}

/// Supports as a table; -1 where an assignment is not allowed.
fn table(allowed: &[Assignment]) -> Vec<Vec<i64>> {
    let mut table = vec![vec![-1; 5]; 3];
    for assignment in allowed {
        table[assignment.observed][assignment.model] = i64::from(assignment.support);
    }
    table
}

fn expected(table: &toml::Value) -> Vec<Vec<i64>> {
    let row =
        |row: &toml::Value| row.as_array().unwrap().iter().map(|value| value.as_integer().unwrap()).collect();
    table.as_array().unwrap().iter().map(row).collect()
}

#[test]
fn supports_are_those_of_the_printed_table_with_unsigned_separations() {
    let file = file();
    let (_, _, allowed) = relaxed(false);
    assert_eq!(table(&allowed), expected(&file["printed"]["result"]));
    assert_eq!(table(&allowed), expected(&file["geometry"]["result_unsigned_separation"]));
}

#[test]
fn signed_separations_tell_the_mirror_image_from_the_place() {
    let (observed, model, allowed) = relaxed(true);
    let file = file();
    assert_eq!(table(&allowed), expected(&file["geometry"]["result_signed_separation"]));
    let chosen: Vec<i64> =
        best(&allowed, &observed, &model).iter().map(|pair| pair.model as i64 + 1).collect();
    let assignment = file["geometry"]["assignment"].as_array().unwrap();
    assert_eq!(chosen, assignment.iter().map(|v| v.as_integer().unwrap()).collect::<Vec<i64>>());
}

#[test]
fn error_and_heading_are_those_of_the_worked_example() {
    let file = file();
    let expected = &file["localization"];
    let (mut observed, model, allowed) = relaxed(true);
    let chosen = best(&allowed, &observed, &model);
    let error = squared_error_m2(&chosen, &observed, &model);
    assert!((error - expected["least_squares_error"].as_float().unwrap()).abs() < 1e-9, "{error}");
    for (landmark, bearing) in
        observed.iter_mut().zip(expected["observed_theta_with_noise"].as_array().unwrap())
    {
        landmark.bearing_rad = bearing.as_float().unwrap().to_radians();
    }
    let heading = heading_rad(&chosen, &observed, &model).to_degrees();
    assert!((heading - expected["heading"].as_float().unwrap()).abs() < 1e-6, "{heading}");
    assert!((heading + expected["printed_sign_result"].as_float().unwrap()).abs() < 1e-6);
    // 28, 31 and 29.5 degrees scatter by the root of 1.5 around their mean.
    let scatter = heading_scatter_rad(&chosen, &observed, &model).to_degrees();
    assert!((scatter - 1.5_f64.sqrt()).abs() < 1e-3, "{scatter}");
    let headings = headings_rad(&allowed, &observed, &model);
    assert!(headings.len() == 1 && (headings[0].to_degrees() - 29.5).abs() < 0.01, "{headings:?}");
}

fn wall(distance_m: f64, bearing_deg: f64) -> Landmark {
    let kind = LandmarkKind::Wall { length_m: 3.0, unit_covariance: [0.0; 3], unevenness_m: 0.0 };
    Landmark { distance_m, bearing_rad: bearing_deg.to_radians(), kind, beams: [0; 2] }
}

const ALIKE: Similarity = Similarity { distance_m: 0.075, extent_m: 0.15 };
const WITHIN: RelationTolerance = RelationTolerance { distance_m: 0.075, angle_rad: 0.105, is_signed: true };

#[test]
fn in_the_middle_of_a_room_that_looks_the_same_after_half_a_turn_there_are_two_headings() {
    let model = [wall(2.0, 0.0), wall(1.0, 90.0), wall(2.0, 180.0), wall(1.0, -90.0)];
    for turned in [0.0, 30.0, 170.0] {
        let observed: Vec<Landmark> = (0..4)
            .map(|k| {
                let known = model[k];
                wall(known.distance_m, known.bearing_rad.to_degrees() - turned)
            })
            .collect();
        let relations = [Relations::of(&observed), Relations::of(&model)];
        let allowed = relax((&observed, &relations[0]), (&model, &relations[1]), &ALIKE, &WITHIN);
        let mut found: Vec<i64> = headings_rad(&allowed, &observed, &model)
            .iter()
            .map(|heading| (heading.to_degrees().round() as i64).rem_euclid(360))
            .collect();
        found.sort_unstable();
        let mut both = [turned as i64, turned as i64 + 180];
        both.sort_unstable();
        assert_eq!(found, both);
    }
}

#[test]
fn landmarks_that_are_alone_have_no_place() {
    let (lonely, model) = ([wall(2.0, 0.0)], [wall(2.0, 90.0), wall(1.0, 0.0)]);
    let relations = [Relations::of(&lonely), Relations::of(&model)];
    let allowed = relax((&lonely, &relations[0]), (&model, &relations[1]), &ALIKE, &WITHIN);
    assert_eq!(allowed, [Assignment { observed: 0, model: 0, support: 0 }]);
    assert!(best(&allowed, &lonely, &model).is_empty());
    assert!(headings_rad(&allowed, &lonely, &model).is_empty());
    let nothing = Relations::of(&[]);
    assert!(relax((&[], &nothing), (&model, &relations[1]), &ALIKE, &WITHIN).is_empty());
}

#[test]
fn however_many_model_landmarks_fit_another_observed_one_counts_once() {
    // Two walls of the model stand where the second observed one may be.
    let observed = [wall(2.0, 0.0), wall(1.0, 90.0)];
    let model = [wall(2.0, 0.0), wall(1.0, 90.0), wall(1.03, 91.0)];
    let relations = [Relations::of(&observed), Relations::of(&model)];
    let allowed = relax((&observed, &relations[0]), (&model, &relations[1]), &ALIKE, &WITHIN);
    let supports: Vec<u32> = allowed.iter().map(|pair| pair.support).collect();
    assert_eq!(supports, [1, 1, 1]);
    // Of two that are supported alike the one with the smaller difference of distances is taken.
    let chosen: Vec<usize> = best(&allowed, &observed, &model).iter().map(|pair| pair.model).collect();
    assert_eq!(chosen, [0, 1]);
}
