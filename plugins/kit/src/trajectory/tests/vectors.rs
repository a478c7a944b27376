//! `slam3d_ate_rpe.json`: a trajectory of nine poses with all its errors.

use super::*;
use crate::spread::Spread;
use serde_json::Value;

fn vector() -> (Value, f64) {
    let text = include_str!("../../../tests/data/slam3d_ate_rpe.json");
    let vector: Value = serde_json::from_str(text).unwrap();
    let tolerance = vector["tolerance"].as_f64().unwrap();
    (vector, tolerance)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn poses(value: &Value) -> Vec<Pose3> {
    let pose = |row: &Value| {
        let [tx, ty, tz, qx, qy, qz, qw] = numbers(row).try_into().unwrap();
        let rotation = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(qw, qx, qy, qz));
        Pose3::from_parts(Translation3::new(tx, ty, tz), rotation)
    };
    value.as_array().unwrap().iter().map(pose).collect()
}

fn pairs(vector: &Value, scale: f64) -> Vec<PosePair> {
    let truth = poses(&vector["synthetic"]["ground_truth_tx_ty_tz_qx_qy_qz_qw"]);
    let estimate = poses(&vector["synthetic"]["estimate"]);
    let scaled = estimate.into_iter().map(|mut pose| {
        pose.translation.vector *= scale;
        pose
    });
    truth.into_iter().zip(scaled).enumerate().map(|(idx, (a, b))| pair(idx as f64, a, b)).collect()
}

fn assert_spread(errors: Vec<f64>, expected: &Value, tolerance: f64, what: &str) {
    let found = Spread::of(errors).unwrap();
    let named = [
        ("rmse", found.rmse),
        ("mean", found.mean),
        ("median", found.median),
        ("std_population", found.std),
        ("min", found.min),
        ("max", found.max),
    ];
    for (name, value) in named {
        let wanted = expected[name].as_f64().unwrap();
        assert!((value - wanted).abs() <= tolerance, "{what} {name}: {value}, expected {wanted}");
    }
}

#[test]
fn absolute_errors_and_their_alignment_are_those_of_the_vector() {
    let (vector, tolerance) = vector();
    let pairs = pairs(&vector, 1.0);
    let alignment = align(&pairs, Alignment::Se3).unwrap();
    let expected = &vector["synthetic"]["ate"];
    let rotation = alignment.truth_from_estimate.rotation.to_rotation_matrix();
    for row in 0..3 {
        for (col, wanted) in numbers(&expected["R"][row]).into_iter().enumerate() {
            assert!((rotation[(row, col)] - wanted).abs() <= tolerance, "R[{row}][{col}]");
        }
        let wanted = numbers(&expected["t"])[row];
        assert!((alignment.truth_from_estimate.translation.vector[row] - wanted).abs() <= tolerance);
    }
    let errors = absolute_errors(&pairs, &alignment);
    for (error, wanted) in errors.iter().zip(numbers(&expected["errors"])) {
        assert!((error - wanted).abs() <= tolerance);
    }
    assert_eq!(errors.len(), 9);
    assert_spread(errors, expected, tolerance, "ate");
}

#[test]
fn an_unknown_scale_is_found_as_in_the_vector() {
    let (vector, tolerance) = vector();
    let expected = &vector["synthetic"]["ate_with_scale"];
    let pairs = pairs(&vector, expected["estimate_positions_multiplied_by"].as_f64().unwrap());
    let alignment = align(&pairs, Alignment::Sim3).unwrap();
    assert!((alignment.scale - expected["scale"].as_f64().unwrap()).abs() <= tolerance);
    assert_spread(absolute_errors(&pairs, &alignment), expected, tolerance, "ate with scale");
}

#[test]
fn relative_errors_are_those_of_the_vector() {
    let (vector, tolerance) = vector();
    let pairs = pairs(&vector, 1.0);
    let alignment = align(&pairs, Alignment::Se3).unwrap();
    for (name, step, choice, n) in [
        ("rpe_delta_1_frame", Step::Frames(1), PairChoice::EveryStart, 8),
        ("rpe_delta_1_frame", Step::Frames(1), PairChoice::Consecutive, 8),
        ("rpe_delta_3_frames", Step::Frames(3), PairChoice::EveryStart, 6),
        ("rpe_all_pairs", Step::Frames(1), PairChoice::All, 36),
    ] {
        let expected = &vector["synthetic"][name];
        let compared = index_pairs(&pairs, step, choice);
        assert_eq!(compared.len(), n, "{name}");
        let errors = relative_errors(&pairs, &alignment, &compared);
        assert_spread(errors.translation_m, &expected["translation_m"], tolerance, name);
        assert_spread(errors.rotation_rad, &expected["rotation_rad"], tolerance, name);
    }
}

#[test]
fn stamps_are_associated_as_in_the_vector() {
    let (vector, tolerance) = vector();
    let stamps = |key: &str| numbers(&vector["association"][key]);
    let with = |stamps: Vec<f64>, poses: Vec<Pose3>| {
        trajectory(stamps.into_iter().zip(poses).map(|(t, pose)| stamped(t, pose)).collect())
    };
    let truth =
        with(stamps("ground_truth_stamps"), poses(&vector["synthetic"]["ground_truth_tx_ty_tz_qx_qy_qz_qw"]));
    let estimate = with(stamps("estimate_stamps"), poses(&vector["synthetic"]["estimate"]));
    let found = associate(&truth, &estimate, Span::from_secs(0.02));
    let expected: Vec<(usize, usize)> = vector["association"]["matched_pairs"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| (pair[0].as_u64().unwrap() as usize, pair[1].as_u64().unwrap() as usize))
        .collect();
    assert_eq!(found, expected);
    let dropped = numbers(&vector["association"]["dropped"]);
    assert!(dropped.iter().all(|idx| found.iter().all(|(truth_idx, _)| *truth_idx != *idx as usize)));
    let pairs = pose_pairs(&truth, &estimate, Span::from_secs(0.02));
    let errors = absolute_errors(&pairs, &align(&pairs, Alignment::Se3).unwrap());
    assert_spread(errors, &vector["association"]["ate_after_association"], tolerance, "after association");
}
