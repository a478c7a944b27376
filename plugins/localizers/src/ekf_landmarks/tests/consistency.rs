//! Whether errors are as large as the filter says: many simulated drives, each with its own errors.

use super::*;
use rumbo_core::frames::Twist;

const NOISE: [f64; 3] = [0.03, 0.02, 0.05];
const CAMERA_DEVIATIONS: [f64; 2] = [0.08, 0.02];
const N_DRIVES: usize = 60;

/// What an odometer says of a true step that errs anew each time, with these scales.
fn told(step: Twist, scales: [f64; 2], rng: &mut Rng) -> Pose2 {
    let (way_m, turn) = (step.speed_m_s(), step.turn_rad_s);
    let error = |deviation: f64, amount: f64, rng: &mut Rng| deviation * amount.sqrt() * normal(rng);
    let along = way_m + error(NOISE[0], way_m, rng);
    let around = turn + error(NOISE[1], way_m, rng) + error(NOISE[2], turn.abs(), rng);
    Twist::new(along / scales[0], around / scales[1]).integrate(1.0)
}

/// Mean of the normalized squared error of x, y, yaw over drives and time.
fn nees(scale_deviation: f64) -> f64 {
    let marks = [mark(-1.0, 4.5), mark(5.0, 4.0), mark(6.0, -2.0), mark(0.5, -3.5), mark(2.0, 1.2)];
    let (camera, mut rng) = (pose2(0.15, 0.0, 0.0), rng::stream(21, "drives"));
    let (mut sum, mut n) = (0.0, 0);
    for drive in 0..N_DRIVES {
        let sigma = Vector3::new(0.1, 0.1, 0.05);
        let start = pose2(0.5, -1.0, 0.3);
        let covariance = Matrix3::from_diagonal(&sigma.component_mul(&sigma));
        let scales = [0, 1].map(|_| 1.0 + scale_deviation * normal(&mut rng));
        let off = sigma.component_mul(&Vector3::from_fn(|_, _| normal(&mut rng)));
        let mut truth = pose2(0.5 + off.x, -1.0 + off.y, 0.3 + off.z);
        let mut belief = Belief::at(&start, &covariance, [scale_deviation; 2]);
        for k in 0..400 {
            let bend = if (k / 100 + drive) % 2 == 0 { 0.025 } else { -0.02 };
            let step = Twist::new(0.03, bend);
            truth *= step.integrate(1.0);
            belief.advance(&told(step, scales, &mut rng), NOISE);
            if k % 4 == 3 {
                for mark in &marks {
                    let sighting = seen(&truth, &camera, mark, CAMERA_DEVIATIONS, &mut rng);
                    let is_in_view = sighting.measured.y.abs() < 0.6 && sighting.measured.x < 7.0;
                    if is_in_view && belief.distance(&sighting, mark) <= GATE {
                        assert!(belief.correct(&sighting, mark));
                    }
                }
            }
            if k % 10 == 9 {
                let pose = belief.pose();
                let way = pose.translation.vector - truth.translation.vector;
                let turn = wrap_angle(pose.rotation.angle() - truth.rotation.angle());
                let error = Vector3::new(way.x, way.y, turn);
                sum += error.dot(&(belief.pose_covariance().try_inverse().unwrap() * error));
                n += 1;
            }
        }
    }
    sum / f64::from(n)
}

#[test]
fn errors_are_as_large_as_the_filter_says() {
    let nees = nees(0.0);
    // Three degrees of freedom.
    assert!((1.5..4.5).contains(&nees), "{nees}");
}

#[test]
fn they_are_so_as_well_with_scales_that_it_has_to_find_out() {
    let nees = nees(0.1);
    assert!((1.5..4.5).contains(&nees), "{nees}");
}

#[test]
fn scales_of_the_odometer_are_found() {
    let marks = [mark(-1.0, 4.5), mark(5.0, 4.0), mark(6.0, -2.0), mark(0.5, -3.5)];
    let (mut rng, mut truth) = (rng::stream(22, "scales"), pose2(0.5, -1.0, 0.3));
    let mut belief = Belief::at(&truth, &(Matrix3::identity() * 1e-4), [0.1; 2]);
    for k in 0..1500 {
        let step = Twist::new(0.03, if k / 200 % 2 == 0 { 0.025 } else { -0.02 });
        truth *= step.integrate(1.0);
        belief.advance(&told(step, [0.9, 1.08], &mut rng), NOISE);
        if k % 5 == 0 {
            for mark in &marks {
                let sighting = seen(&truth, &Pose2::identity(), mark, CAMERA_DEVIATIONS, &mut rng);
                assert!(belief.correct(&sighting, mark));
            }
        }
    }
    for (idx, scale) in [(3, 0.9), (4, 1.08)] {
        let (found, sigma) = (1.0 + belief.mean[idx], belief.covariance[(idx, idx)].sqrt());
        assert!((found - scale).abs() < 4.0 * sigma && sigma < 0.02, "{found} +- {sigma}, not {scale}");
    }
}

#[test]
fn the_gate_lets_all_but_one_in_a_thousand_through() {
    let (mut rng, n) = (rng::stream(23, "gate"), 40_000);
    let at = mark(-3.0, 2.0);
    let sigma = Vector3::new(0.05, 0.08, 0.03);
    let covariance = Matrix3::from_diagonal(&sigma.component_mul(&sigma));
    let belief = Belief::at(&pose2(0.0, 0.0, 3.1), &covariance, [0.0; 2]);
    let n_refused = (0..n)
        .filter(|_| {
            let off = sigma.component_mul(&Vector3::from_fn(|_, _| normal(&mut rng)));
            let truth = pose2(off.x, off.y, 3.1 + off.z);
            let sighting = seen(&truth, &Pose2::identity(), &at, CAMERA_DEVIATIONS, &mut rng);
            belief.distance(&sighting, &at) > GATE
        })
        .count();
    assert!((15..=75).contains(&n_refused), "{n_refused} of {n}, expected about 40");
}
