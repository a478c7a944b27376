use super::*;
use nalgebra::Vector3;

/// Equations of points on two walls along x, and on as many as wanted across.
fn walls(n_across: usize) -> Equations {
    let mut equations = Equations::default();
    for k in 0..40 {
        let line = Line { normal: [0.0, 1.0], distance_m: 2.0, normal_rad2: 0.0 };
        equations.add(&line, [0.2 * f64::from(k) - 4.0, 2.0], 0.01, 1.0);
    }
    for k in 0..n_across {
        let line = Line { normal: [1.0, 0.0], distance_m: 3.0, normal_rad2: 0.0 };
        equations.add(&line, [3.0, 0.1 * k as f64], -0.02, 1.0);
    }
    equations
}

#[test]
fn where_all_is_observed_step_and_covariance_are_those_of_the_inverse() {
    let (equations, rule) = (walls(12), DegeneracyRule::default());
    let split = Split::new(&equations, &rule).unwrap();
    assert!(split.observes_all());
    let inverse = equations.information.try_inverse().unwrap();
    assert!((split.step(&equations.gradient) + inverse * equations.gradient).norm() < 1e-12);
    let covariance = split.covariance(4e-4, &Matrix3::identity(), &rule);
    assert!((covariance - inverse * 4e-4).norm() < 1e-12);
}

#[test]
fn an_unobserved_direction_is_left_alone_with_the_priors_variance_up_to_the_limit() {
    let (equations, rule) = (walls(0), DegeneracyRule::default());
    let split = Split::new(&equations, &rule).unwrap();
    assert!(split.observes_any() && !split.observes_all());
    assert_eq!(split.unobserved_axes(), [true, false, false]);
    assert_eq!(split.step(&equations.gradient).x, 0.0);
    for (told, expected) in [(0.04, 0.04), (25.0, 1.0)] {
        let prior = Matrix3::from_diagonal(&Vector3::new(told, 1.0, 1.0));
        let covariance = split.covariance(4e-4, &prior, &rule);
        assert!((covariance[(0, 0)] - expected).abs() < 1e-9, "{covariance}");
        assert!(covariance[(1, 1)] < 1e-3);
    }
}

#[test]
fn what_wrong_directions_pretend_is_not_observed() {
    let mut equations = Equations::default();
    let deviation_rad = 0.1f64;
    for k in 0..40 {
        let tilt_rad = if k % 2 == 0 { deviation_rad } else { -deviation_rad };
        let normal = [tilt_rad.sin(), tilt_rad.cos()];
        let line = Line { normal, distance_m: 2.0, normal_rad2: deviation_rad.powi(2) };
        equations.add(&line, [0.2 * f64::from(k) - 4.0, 2.0], 0.0, 1.0);
    }
    let rule = DegeneracyRule::default();
    assert!(!Split::new(&equations, &rule).unwrap().observes_all());
    let published = DegeneracyRule { pretended_share: 1.0, ..rule };
    assert!(Split::new(&equations, &published).unwrap().observes_all());
    equations.gradient.x = f64::NAN;
    assert!(Split::new(&equations, &rule).is_none());
}
