//! One update against Bayes' rule on a fine grid, which knows no linearization.

use super::*;

/// Mean and covariance of the posterior of x, y, yaw after sightings, summed over a grid of six deviations to both sides.
fn on_a_grid(prior: &Belief, sightings: &[(Sighting, KnownMark)], n: i32) -> (Vector3<f64>, Matrix3<f64>) {
    let center = prior.mean.fixed_rows::<3>(0).into_owned();
    let covariance = prior.pose_covariance();
    let (inverse, root) = (covariance.try_inverse().unwrap(), covariance.cholesky().unwrap().l());
    let (mut total, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
    let reach = 6.0;
    let at = |k: i32| reach * f64::from(k) / f64::from(n);
    for (i, j, k) in (-n..=n).flat_map(|i| (-n..=n).flat_map(move |j| (-n..=n).map(move |k| (i, j, k)))) {
        let offset = root * Vector3::new(at(i), at(j), at(k));
        let point = center + offset;
        let mut exponent = -0.5 * offset.dot(&(inverse * offset));
        for (sighting, mark) in sightings {
            let here = expect(&pose2(point.x, point.y, point.z), &sighting.base_from_sensor, &mark.at);
            let off = sighting.minus(&here.unwrap().expected);
            exponent -= 0.5 * off.dot(&(sighting.noise.try_inverse().unwrap() * off));
        }
        let weight = exponent.exp();
        total += weight;
        first += offset * weight;
        second += offset * offset.transpose() * weight;
    }
    let mean = first / total;
    (center + mean, second / total - mean * mean.transpose())
}

fn prior(deviations: [f64; 3]) -> Belief {
    let sigma = Matrix3::from_diagonal(&Vector3::from(deviations));
    let tilt = Matrix3::new(1.0, 0.3, 0.2, 0.3, 1.0, -0.1, 0.2, -0.1, 1.0);
    Belief::at(&pose2(1.0, -0.5, 2.9), &(sigma * tilt * sigma), [0.0; 2])
}

fn after(prior: &Belief, sightings: &[(Sighting, KnownMark)]) -> Belief {
    let mut belief = prior.clone();
    for (sighting, mark) in sightings {
        assert!(belief.correct(sighting, mark));
    }
    belief
}

#[test]
fn far_marks_are_taken_in_as_bayes_rule_does() {
    let (prior, mut rng) = (prior([0.1, 0.15, 0.05]), rng::stream(3, "grid"));
    let camera = pose2(0.2, 0.05, 0.1);
    let truth = prior.pose() * pose2(0.07, -0.09, 0.03);
    let marks = [mark(-4.0, 1.5), mark(-2.0, -3.0)];
    let sightings = marks.map(|mark| (seen(&truth, &camera, &mark, [0.1, 0.03], &mut rng), mark));
    let belief = after(&prior, &sightings);
    let (mean, covariance) = on_a_grid(&prior, &sightings, 40);
    for axis in 0..3 {
        let sigma = covariance[(axis, axis)].sqrt();
        let off = wrap_angle(belief.mean[axis] - mean[axis]).abs();
        assert!(off < 0.03 * sigma, "axis {axis}: {off} of {sigma}");
        let ratio = belief.covariance[(axis, axis)].sqrt() / sigma;
        assert!((ratio - 1.0).abs() < 0.02, "axis {axis}: {ratio}");
    }
    assert!((belief.pose_covariance() - covariance).amax() < 0.03 * covariance.amax());
}

#[test]
fn a_near_mark_is_taken_in_by_iteration_to_where_the_posterior_is_highest() {
    let (prior, camera) = (prior([0.3, 0.3, 0.2]), Pose2::identity());
    let at = prior.pose() * Point2::new(0.8, 0.3);
    let near = mark(at.x, at.y);
    let truth = prior.pose() * pose2(0.25, -0.2, 0.1);
    let sighting = seen(&truth, &camera, &near, [1e-9; 2], &mut rng::stream(4, "near"));
    let sighting = Sighting { noise: Matrix2::from_diagonal(&Vector2::new(4e-4, 4e-4)), ..sighting };
    let belief = after(&prior, &[(sighting, near)]);
    let height = |state: &State| {
        let offset = (state - prior.mean).fixed_rows::<3>(0).into_owned();
        let off = sighting.minus(&expect(&motion::pose_of(state), &camera, &near.at).unwrap().expected);
        let inverse = prior.pose_covariance().try_inverse().unwrap();
        -0.5 * (offset.dot(&(inverse * offset)) + off.dot(&(sighting.noise.try_inverse().unwrap() * off)))
    };
    let unwrapped = |mut state: State| {
        state[2] = prior.mean[2] + wrap_angle(state[2] - prior.mean[2]);
        state
    };
    let top = height(&unwrapped(belief.mean));
    let mut rng = rng::stream(5, "around");
    for _ in 0..2000 {
        let step = State::new(normal(&mut rng), normal(&mut rng), normal(&mut rng), 0.0, 0.0) * 0.01;
        assert!(height(&unwrapped(belief.mean + step)) <= top + 1e-9);
    }
}

#[test]
fn an_unsure_mark_counts_less_and_one_that_is_sure_for_ever_keeps_the_covariance_sound() {
    let (prior, mut rng) = (prior([0.2, 0.2, 0.1]), rng::stream(6, "many"));
    let sure = mark(-3.0, 1.0);
    let unsure = KnownMark { covariance: Matrix2::identity() * 4.0, ..sure };
    let sighting = seen(&prior.pose(), &Pose2::identity(), &sure, [0.05, 0.01], &mut rng);
    let [first, other] = [sure, unsure].map(|mark| after(&prior, &[(sighting, mark)]).pose_covariance());
    assert!(first.trace() < 0.8 * other.trace() && other.trace() < prior.pose_covariance().trace());
    let mut belief = prior;
    for _ in 0..20_000 {
        assert!(belief.correct(&sighting, &sure));
    }
    let least = belief.pose_covariance().symmetric_eigenvalues().min();
    assert!(least >= 0.0, "{least:e}");
    assert!(belief.distance(&sighting, &sure) < GATE);
}
