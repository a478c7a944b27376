//! The particle filter's parts against the answers of the specification's vectors.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::rng;
use rumbo_kit::GridSize;
use rumbo_kit::beam_table::BeamShape;
use rumbo_kit::grid_poses::GridPoses;
use rumbo_kit::likelihood_field::{FieldShape, LikelihoodField};
use rumbo_kit::normal::{upper_quantile, upper_tail};
use rumbo_kit::resampling::{ResampleError, effective_number, low_variance};
use rumbo_kit::turn_way_turn::TurnWayTurn;
use rumbo_localizers::particle_filter::beams::ScanBeams;
use rumbo_localizers::particle_filter::kld::{KldBound, sample_size};
use rumbo_localizers::particle_filter::measurement::{FieldModel, MeasurementModel, Obstacles};
use rumbo_localizers::particle_filter::motion::{MotionModel, OdometryMotion};
use rumbo_localizers::particle_filter::particles::Particles;
use rumbo_localizers::particle_filter::recovery::Recovery;
use serde_json::Value;

fn vector(name: &str) -> Value {
    let path = format!("{}/tests/data/slam2d_{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(&path).expect(&path)).unwrap()
}

/// A number, or a word that JSON has no number for.
fn number(value: &Value) -> f64 {
    match value.as_str() {
        Some("NaN") => f64::NAN,
        Some("+inf") => f64::INFINITY,
        Some(word) => panic!("{word}"),
        None => value.as_f64().unwrap_or_else(|| panic!("{value}")),
    }
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn triple(value: &Value) -> [f64; 3] {
    numbers(value).try_into().unwrap()
}

fn pose(value: &Value) -> Pose2 {
    let [x, y, yaw] = triple(value);
    pose2(x, y, yaw)
}

fn close(found: f64, expected: &Value, tolerance: f64, what: &str) {
    let expected = number(expected);
    assert!((found - expected).abs() <= tolerance, "{what}: {found} for {expected}");
}

fn array<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().unwrap()
}

#[test]
fn the_likelihood_field_gives_distances_probabilities_and_the_weight() {
    let v = vector("likelihood_field");
    let tolerance = number(&v["tolerance"]);
    let grid = &v["grid"];
    let (size, cell_m) = (GridSize::new(9, 7), number(&grid["resolution_m"]));
    let occupied: Vec<u8> =
        array(grid, "occupied_rows").iter().flat_map(numbers).map(|cell| cell as u8).collect();
    let model = FieldModel {
        likelihood_max_dist_m: number(&v["likelihood_max_dist_m"]),
        sigma_hit_m: number(&v["sigma_hit_m"]),
        z_hit: number(&v["z_hit"]),
        z_rand: number(&v["z_rand"]),
        z_max_range_m: number(&v["z_max_range_m"]),
    };
    let shape = FieldShape {
        max_distance_m: model.likelihood_max_dist_m,
        sigma_hit_m: model.sigma_hit_m,
        z_hit: model.z_hit,
        z_rand: model.z_rand,
        z_max_range_m: model.z_max_range_m,
    };
    // Not truncated, to see the transform itself.
    let wide = LikelihoodField::new(size, cell_m, &occupied, FieldShape { max_distance_m: 9.0, ..shape });
    let field = LikelihoodField::new(size, cell_m, &occupied, shape);
    for (row, distances) in array(&v, "distance_field_m_rows").iter().enumerate() {
        for (col, distance) in distances.as_array().unwrap().iter().enumerate() {
            let found = wide.distance_m(col as f64 + 0.5, row as f64 + 0.5);
            close(found, distance, tolerance, &format!("distance at {col}, {row}"));
        }
    }
    let base = pose(&v["pose"]);
    let mut beams = ScanBeams {
        origin: [0.0, 0.0],
        directions: Vec::new(),
        ranges_m: Vec::new(),
        max_range_m: model.z_max_range_m,
    };
    for beam in array(&v, "beams") {
        let (bearing, range) = (number(&beam["bearing"]), number(&beam["range"]));
        if !range.is_nan() {
            beams.directions.push([bearing.cos(), bearing.sin()]);
            beams.ranges_m.push(range);
        }
        if beam["skipped"] == true {
            continue;
        }
        let end = base * nalgebra::Point2::new(range * bearing.cos(), range * bearing.sin());
        let expected = numbers(&beam["endpoint_m"]);
        assert!((end.x - expected[0]).abs() < tolerance && (end.y - expected[1]).abs() < tolerance);
        let (x, y) = (end.x / cell_m, end.y / cell_m);
        assert_eq!(numbers(&beam["cell"]), [x.floor(), y.floor()]);
        close(field.distance_m(x, y), &beam["distance_m"], tolerance, "distance");
        close(field.exact_ln(x, y).exp(), &beam["p"], tolerance, "p");
    }
    let mut on_map = model.on_map(&Obstacles { size, resolution_m: cell_m, occupied: &occupied });
    let in_cells = [base.translation.x / cell_m, base.translation.y / cell_m, base.rotation.angle()];
    close(on_map.exact_ln(&beams, in_cells), &v["log_weight"], tolerance, "log weight");
    let (mut poses, mut ln_p) = (GridPoses::default(), [0.0]);
    poses.push(in_cells[0], in_cells[1], in_cells[2]);
    let n_used = on_map.add_ln(&beams, &poses, &mut ln_p);
    assert_eq!(n_used as f64, number(&v["beams_used"]));
    // Half a step of the table for each of five beams.
    close(ln_p[0], &v["log_weight"], 5.0 * 0.5 * (0.92f64 / 0.0595).ln() / 255.0, "fast log weight");
}

#[test]
fn the_beam_model_gives_all_parts_of_its_mixture() {
    let v = vector("beam_model");
    let (tolerance, p) = (number(&v["tolerance"]), &v["parameters"]);
    let shape = BeamShape {
        z_hit: number(&p["z_hit"]),
        z_short: number(&p["z_short"]),
        z_max: number(&p["z_max"]),
        z_rand: number(&p["z_rand"]),
        sigma_hit_m: number(&p["sigma_hit_m"]),
        lambda_short_per_m: number(&p["lambda_short_per_m"]),
        z_max_range_m: number(&p["z_max_range_m"]),
    };
    for case in array(&v, "cases") {
        let (z, expected) = (number(&case["z"]), number(&case["z_expected"]));
        let parts = shape.parts(z, expected);
        let what = format!("z {z} where {expected} is expected");
        close(parts.hit, &case["p_hit"], tolerance, &what);
        close(parts.short, &case["p_short"], tolerance, &what);
        close(parts.max, &case["p_max"], tolerance, &what);
        close(parts.rand, &case["p_rand"], tolerance, &what);
        close(shape.likelihood(z, expected), &case["p"], tolerance, &what);
    }
}

#[test]
fn the_odometry_motion_model_has_the_variances_and_the_moments() {
    let v = vector("odometry_motion_model");
    let tolerance = number(&v["tolerance_deterministic"]);
    for (idx, case) in array(&v, "cases").iter().enumerate() {
        let (before, after) = (pose(&case["odom_before"]), pose(&case["odom_after"]));
        let alpha: [f64; 4] = numbers(&case["alpha"]).try_into().unwrap();
        let step = TurnWayTurn::between(&before, &after, alpha);
        let what = |key: &str| format!("case {idx}: {key}");
        // A turn by pi is one by -pi.
        let turn = |found: f64, key: &str| {
            let off = rumbo_core::frames::wrap_angle(found - number(&case[key]));
            assert!(off.abs() < tolerance, "{}: {found}", what(key));
        };
        turn(step.mean[0], "rot1");
        close(step.mean[1], &case["trans"], tolerance, &what("trans"));
        turn(step.mean[2], "rot2");
        close(step.folded_rad[0], &case["noise_rot1_folded"], tolerance, &what("fold 1"));
        close(step.folded_rad[1], &case["noise_rot2_folded"], tolerance, &what("fold 2"));
        for (k, key) in ["variance_rot1", "variance_trans", "variance_rot2"].into_iter().enumerate() {
            close(step.variance[k], &case[key], tolerance, &what(key));
        }
        let start = triple(&case["particle"]);
        let exact = moved(&OdometryMotion { alpha: [0.0; 4] }, &before, &after, start, 1);
        compare_poses(exact[0], triple(&case["noise_free_pose"]), [1e-9; 3]);
        check_moments(&moved(&OdometryMotion { alpha }, &before, &after, start, 200_000), case);
    }
}

fn moved(model: &dyn MotionModel, before: &Pose2, after: &Pose2, start: [f64; 3], n: usize) -> Vec<[f64; 3]> {
    let mut particles = Particles::default();
    (0..n).for_each(|_| particles.push(start));
    model.move_all(before, after, &mut particles, &mut rng::stream(11, "motion"));
    particles.iter().collect()
}

fn compare_poses(found: [f64; 3], expected: [f64; 3], tolerance: [f64; 3]) {
    let mut off = [found[0] - expected[0], found[1] - expected[1], found[2] - expected[2]];
    off[2] = rumbo_core::frames::wrap_angle(off[2]);
    (0..3).for_each(|k| assert!(off[k].abs() <= tolerance[k], "{found:?} for {expected:?}"));
}

/// Each mean within five standard errors, each covariance within 3 percent of the product of the deviations.
fn check_moments(samples: &[[f64; 3]], case: &Value) {
    let expected = triple(&case["mean_unwrapped"]);
    let covariance = Matrix3::from_row_iterator(array(case, "covariance").iter().flat_map(numbers));
    let n = samples.len() as f64;
    let off = |s: &[f64; 3]| {
        let yaw = rumbo_core::frames::wrap_angle(s[2] - expected[2]);
        Vector3::new(s[0] - expected[0], s[1] - expected[1], yaw)
    };
    let mean: Vector3<f64> = samples.iter().map(off).sum::<Vector3<f64>>() / n;
    let found =
        samples.iter().map(|s| (off(s) - mean) * (off(s) - mean).transpose()).sum::<Matrix3<f64>>() / n;
    for i in 0..3 {
        let deviation = covariance[(i, i)].sqrt();
        assert!(mean[i].abs() <= 5.0 * deviation / n.sqrt() + 1e-9, "mean {i}: off by {}", mean[i]);
        for j in 0..3 {
            let scale = deviation * covariance[(j, j)].sqrt();
            let off = (found[(i, j)] - covariance[(i, j)]).abs();
            assert!(off <= 0.03 * scale + 1e-12, "{i} {j}: {} for {}", found[(i, j)], covariance[(i, j)]);
        }
    }
}

#[test]
fn kld_sampling_asks_for_the_numbers_of_the_formula() {
    let v = vector("kld_sample_size");
    let tolerance = number(&v["tolerance_relative"]);
    let bins = |case: &Value| case["bins"].as_u64().unwrap() as usize;
    for case in array(&v, "cases").iter().chain(array(&v, "cases_given_z")) {
        let (epsilon, z) = (number(&case["epsilon"]), number(&case["z"]));
        let (found, expected) = (sample_size(bins(case), epsilon, z), number(&case["n_real"]));
        assert!((found / expected - 1.0).abs() <= tolerance, "{case}: {found}");
        let bound = KldBound { epsilon, z, min_particles: 1, max_particles: usize::MAX };
        assert_eq!(bound.particles(bins(case)) as f64, number(&case["n_ceil"]), "{case}");
        if let Some(exact) = case["chi_square_exact"].as_f64().filter(|_| bins(case) >= 10) {
            assert!((found / exact - 1.0).abs() <= 0.01, "{case}");
        }
    }
    for case in array(&v, "z_check") {
        let (delta, z) = (number(&case["delta"]), number(&case["z"]));
        assert!((upper_quantile(delta).unwrap() - z).abs() < 1e-9 * z.max(1.0), "{case}");
        assert!((upper_tail(z) / delta - 1.0).abs() < 1e-8, "{case}");
        let bound = KldBound::new(0.05, delta, 1, 2).unwrap();
        assert!((bound.z - z).abs() < 1e-8);
    }
    for case in array(&v, "clamped") {
        let bound = KldBound {
            epsilon: number(&case["epsilon"]),
            z: number(&case["z"]),
            min_particles: number(&case["min_particles"]) as usize,
            max_particles: number(&case["max_particles"]) as usize,
        };
        assert_eq!(bound.particles(bins(case)) as f64, number(&case["expected"]), "{case}");
    }
}

#[test]
fn low_variance_resampling_draws_the_listed_particles() {
    let v = vector("low_variance_resampling");
    for case in array(&v, "cases") {
        let weights = numbers(&case["weights"]);
        let n_out = case["n_out"].as_u64().unwrap() as usize;
        let share = number(&case["offset_fraction"]);
        let offset = share * weights.iter().sum::<f64>() / n_out as f64;
        let expected_offset = number(&case["offset"]);
        assert!((offset - expected_offset).abs() <= 1e-12 * expected_offset.max(offset), "{case}");
        let found = low_variance(&weights, n_out, share).unwrap();
        let expected: Vec<usize> = numbers(&case["indexes"]).into_iter().map(|i| i as usize).collect();
        assert_eq!(found, expected, "{case}");
        let counts: Vec<f64> =
            (0..weights.len()).map(|i| found.iter().filter(|f| **f == i).count() as f64).collect();
        assert_eq!(counts, numbers(&case["counts"]), "{case}");
    }
    let tolerance = number(&v["n_eff"]["tolerance"]);
    for case in array(&v["n_eff"], "cases") {
        close(effective_number(&numbers(&case["weights"])), &case["n_eff"], tolerance, "n_eff");
    }
    let errors: Vec<_> = array(&v, "error_cases")
        .iter()
        .map(|case| low_variance(&numbers(&case["weights"]), 4, 0.5))
        .collect();
    assert_eq!(errors[0], Err(ResampleError::AllWeightsZero { n: 3 }));
    assert_eq!(errors[1], Ok(vec![0, 0, 2, 2]), "a weight that is no number counts as zero");
    assert_eq!(errors[2], Err(ResampleError::InvalidWeight { index: 1, weight: -0.1 }));
    assert_eq!(errors[3], Err(ResampleError::EmptyParticleSet));
}

#[test]
fn augmented_mcl_averages_and_injects_as_listed() {
    let v = vector("augmented_mcl");
    let tolerance = number(&v["tolerance"]);
    let mut recovery = Recovery::new(number(&v["alpha_slow"]), number(&v["alpha_fast"]));
    for step in array(&v, "steps") {
        recovery.observe(number(&step["w_avg"]));
        let [slow, fast] = recovery.averages().unwrap();
        close(slow, &step["w_slow"], tolerance, "w_slow");
        close(fast, &step["w_fast"], tolerance, "w_fast");
        close(recovery.random_share(), &step["p_random"], tolerance, "p_random");
    }
    let weights = &v["log_weight_normal\u{69}sation"];
    let ln = numbers(&weights["log_weights"]);
    let mut particles = Particles::default();
    ln.iter().for_each(|_| particles.push([0.0; 3]));
    particles.equalize();
    assert!(particles.reweigh(&ln));
    for (found, expected) in particles.weights.iter().zip(array(weights, "normal\u{69}sed")) {
        close(*found, expected, tolerance, "weight");
    }
    let mut zero = Recovery::new(0.1, 0.5);
    zero.observe(number(&v["zero_slow"]["w_slow"]));
    close(zero.random_share(), &v["zero_slow"]["expected_p_random"], 0.0, "p_random of nothing");
}
