//! Proposals: the published numbers, and integration by brute force.

use crate::rbpf_slam::motion::{MotionNoise, Step};
use crate::rbpf_slam::proposal::{Proposal, SAMPLED_FLOOR, difference};
use crate::rbpf_slam::weights::{best, gain, normalized};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::rng::{Rng, stream};
use rumbo_kit::resampling::effective_number;
use rumbo_kit::turn_way_turn::{TurnWayTurn, noisy};
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn published() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/slam2d_rbpf_proposal.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

#[test]
fn the_published_samples_give_the_published_gaussian() {
    let v = published();
    let tolerance = v["tolerance"].as_f64().unwrap();
    let vector = |value: &Value| Vector3::from_column_slice(&numbers(value));
    let samples: Vec<Vector3<f64>> = v["samples"].as_array().unwrap().iter().map(vector).collect();
    let (scan, motion) = (numbers(&v["log_likelihood"]), numbers(&v["log_motion"]));
    let found = Proposal::of_samples(&vector(&v["mode"]), &samples, &scan, &motion).unwrap();
    assert!((found.mean - vector(&v["mu"])).amax() < tolerance, "{}", found.mean);
    let rows: Vec<f64> = v["Sigma"].as_array().unwrap().iter().flat_map(numbers).collect();
    assert!((found.covariance - Matrix3::from_row_slice(&rows)).amax() < tolerance, "{}", found.covariance);
    assert!((found.ln_weight - v["log_eta"].as_f64().unwrap()).abs() < tolerance);
}

#[test]
fn the_published_weights_are_updated_as_published() {
    let v = &published()["weight_update"];
    let before = numbers(&v["previous_weights"]);
    let ln: Vec<f64> = before.iter().zip(numbers(&v["log_etas"])).map(|(w, eta)| w.ln() + eta).collect();
    let weights = normalized(&ln, gain(0.0, 4)).unwrap();
    for (found, expected) in weights.iter().zip(numbers(&v["normali\u{73}ed_weights"])) {
        assert!((found - expected).abs() < 1e-10, "{weights:?}");
    }
    let effective = effective_number(&weights);
    assert!((effective - v["n_eff"].as_f64().unwrap()).abs() < 1e-10);
    let threshold = v["threshold_fraction"].as_f64().unwrap() * 4.0;
    assert_eq!(effective < threshold, v["resample_expected"].as_bool().unwrap());
}

#[test]
fn samples_across_the_wrap_are_averaged_around_the_match() {
    let mode = Vector3::new(0.0, 0.0, 3.13);
    let samples = [Vector3::new(0.0, 0.0, 3.12), Vector3::new(0.0, 0.0, -3.133_185_307_179_586)];
    let found = Proposal::of_samples(&mode, &samples, &[-5.0; 2], &[0.0; 2]).unwrap();
    assert!((found.mean.z - 3.135).abs() < 1e-9, "{}", found.mean);
    assert!(Proposal::of_samples(&mode, &samples, &[f64::NEG_INFINITY; 2], &[0.0; 2]).is_none());
    let one = Proposal::of_samples(&mode, &samples, &[f64::NAN, -1.0], &[0.0; 2]).unwrap();
    assert!((one.mean.z - (samples[1].z + std::f64::consts::TAU)).abs() < 1e-9, "{}", one.mean);
}

#[test]
fn the_gaussian_of_the_curvature_is_the_integral_over_a_fine_raster() {
    let evidence = Matrix3::new(900.0, 80.0, -40.0, 80.0, 300.0, 60.0, -40.0, 60.0, 2000.0);
    let information = Matrix3::new(100.0, -20.0, 10.0, -20.0, 60.0, 5.0, 10.0, 5.0, 200.0);
    // The peak of both is at zero, so the odometer's pose lies where its pull is that of the scan's, turned round.
    let odometer = Vector3::new(0.06, -0.04, 0.02);
    let pull = information * odometer;
    let scan = -evidence.try_inverse().unwrap() * pull;
    let ln_scan = |x: &Vector3<f64>| -3.0 - 0.5 * (x - scan).dot(&(evidence * (x - scan)));
    let ln_normal = 0.5 * information.determinant().ln() - 1.5 * std::f64::consts::TAU.ln();
    let ln_motion = |x: &Vector3<f64>| ln_normal - 0.5 * (x - odometer).dot(&(information * (x - odometer)));
    let mode = Vector3::zeros();
    let found =
        Proposal::of_curvature(&mode, ln_scan(&mode), &evidence, &information, &(mode - odometer)).unwrap();
    let (n, steps) = (40i32, [0.012, 0.02, 0.008]);
    let (mut sum, mut second) = (0.0, Matrix3::zeros());
    for i in -n..=n {
        for j in -n..=n {
            for k in -n..=n {
                let x = Vector3::new(f64::from(i), f64::from(j), f64::from(k))
                    .component_mul(&Vector3::from(steps));
                let tau = (ln_scan(&x) + ln_motion(&x)).exp();
                sum += tau;
                second += x * x.transpose() * tau;
            }
        }
    }
    let volume: f64 = steps.iter().product();
    assert!(
        (found.ln_weight - (sum * volume).ln()).abs() < 1e-3,
        "{} {}",
        found.ln_weight,
        (sum * volume).ln()
    );
    assert!((found.covariance - second / sum).amax() < 1e-3 * found.covariance.amax());
}

#[test]
fn drawn_poses_have_the_mean_and_the_covariance_of_the_proposal() {
    let covariance = Matrix3::new(0.01, 0.004, -0.002, 0.004, 0.02, 0.001, -0.002, 0.001, 0.003);
    let proposal = Proposal { mean: Vector3::new(1.0, -2.0, 3.1), covariance, ln_weight: 0.0 };
    let mut rng = stream(4, "draws");
    let center = pose2(1.0, -2.0, 3.1);
    let drawn: Vec<Vector3<f64>> =
        (0..40_000).map(|_| difference(&center, &proposal.draw(SAMPLED_FLOOR, &mut rng))).collect();
    let mean = drawn.iter().sum::<Vector3<f64>>() / drawn.len() as f64;
    let spread = drawn.iter().map(|off| off * off.transpose()).sum::<Matrix3<f64>>() / drawn.len() as f64;
    assert!(mean.amax() < 0.003, "{mean}");
    assert!((spread - covariance).amax() < 5e-4, "{spread}");
    let flat = Proposal { covariance: Matrix3::zeros(), ..proposal };
    assert!(
        difference(&center, &flat.draw(SAMPLED_FLOOR, &mut rng)).amax() < 0.02,
        "without width it is the floor's"
    );
}

/// A pose after a step, with noise in its turns and its way.
fn sampled(noise: &MotionNoise, map_from_before: &Pose2, step: &Step, rng: &mut Rng) -> Pose2 {
    let parts = TurnWayTurn::between(&Pose2::identity(), &step.before_from_after, noise.alpha);
    let [turn, way, turn_after] = noisy(parts.mean, parts.variance.map(f64::sqrt), rng);
    let floor =
        [noise.floor_m.powi(2) + step.stray[0], noise.floor_rad.powi(2) + step.stray[1]].map(f64::sqrt);
    let [x, y, yaw] = noisy([0.0; 3], [floor[0], floor[0], floor[1]], rng);
    let yaw_before = map_from_before.rotation.angle();
    let (sin, cos) = (yaw_before + turn).sin_cos();
    let at = map_from_before.translation.vector;
    pose2(at.x + way * cos + x, at.y + way * sin + y, yaw_before + turn + turn_after + yaw)
}

#[test]
fn the_covariance_of_a_step_is_that_of_sampled_steps() {
    let noise = MotionNoise { alpha: [0.01, 0.002, 0.003, 0.002], floor_m: 0.01, floor_rad: 0.005 };
    let before = pose2(3.0, 1.0, 2.0);
    let step = Step { before_from_after: pose2(0.6, 0.1, 0.3), stray: [0.0004, 0.0001], ..Step::default() };
    let covariance = noise.covariance(&before, &step);
    let expected = before * step.before_from_after;
    let mut rng = stream(6, "steps");
    let drawn: Vec<Vector3<f64>> =
        (0..100_000).map(|_| difference(&expected, &sampled(&noise, &before, &step, &mut rng))).collect();
    let mean = drawn.iter().sum::<Vector3<f64>>() / drawn.len() as f64;
    let spread = drawn.iter().map(|off| (off - mean) * (off - mean).transpose()).sum::<Matrix3<f64>>()
        / drawn.len() as f64;
    assert!(mean.amax() < 0.003, "{mean}");
    assert!((spread - covariance).amax() < 0.03 * covariance.amax(), "{spread} {covariance}");
}

#[test]
fn weights_are_flattened_by_the_number_of_particles_and_bad_ones_are_none() {
    assert_eq!(gain(0.0, 30), 1.0);
    assert!((gain(3.0, 30) - 1.0 / 90.0).abs() < 1e-15);
    let weights = normalized(&[0.0, -90.0, f64::NAN], gain(3.0, 30)).unwrap();
    let whole = 1.0 + (-1f64).exp();
    assert!((weights[0] - 1.0 / whole).abs() < 1e-12 && weights[2] == 0.0, "{weights:?}");
    assert_eq!(normalized(&[f64::NEG_INFINITY, f64::NAN], 1.0), None);
    assert_eq!(best([1.0, 3.0, 3.0, f64::NAN].into_iter()), 1);
    assert_eq!(Pose2::identity(), pose2(0.0, 0.0, 0.0));
}
