use super::*;

#[test]
fn along_a_corridor_the_way_is_the_priors_whatever_the_noise() {
    let mut registrar = Registrar::default();
    for (noise_m, yaw_rad) in [(0.0, 0.0), (0.005, 0.3), (0.01, -0.8), (0.02, 1.4), (0.03, 0.0)] {
        let range_noise_m = f64::max(noise_m, 0.01);
        let settings = ScanOdometrySettings { range_noise_m, ..ScanOdometrySettings::default() };
        for seed in 0..5 {
            let mut rng = rng(seed);
            let at = pose2(3.0, 0.2, yaw_rad);
            let step = pose2(0.1, 0.0, 0.03);
            let key = key_of(&seen(&corridor(), &at, 361, noise_m, &mut rng), &settings);
            let points = placed(&seen(&corridor(), &(at * step), 361, noise_m, &mut rng));
            // The prior is 4 cm short along the corridor, and off across and in direction.
            let corridor_from_prior = pose2(-0.04, 0.05, 0.04);
            let turn = pose2(0.0, 0.0, yaw_rad);
            let start = turn.inverse() * corridor_from_prior * turn * step;
            let matched = registrar.register(&key, &points, &prior(start), &settings);
            assert_eq!(matched.status, MatchStatus::Degenerate, "{noise_m} m: {matched:?}");
            let error = turn.rotation * (matched.key_from_base.translation.vector - step.translation.vector);
            let began = turn.rotation * (start.translation.vector - step.translation.vector);
            assert!((error.x - began.x).abs() < 0.015, "along, {noise_m} m: {} from {}", error.x, began.x);
            assert!(error.y.abs() < 0.01, "across, {noise_m} m: {}", error.y);
            let turn_rad = matched.key_from_base.rotation.angle() - 0.03;
            assert!(turn_rad.abs() < 0.008, "direction, {noise_m} m: {turn_rad}");
            let by_axis = turn.rotation.to_rotation_matrix();
            let place = matched.covariance.fixed_view::<2, 2>(0, 0).into_owned();
            let along = by_axis * place * by_axis.transpose();
            assert!((0.05..0.15).contains(&along[(0, 0)].sqrt()), "the prior's 0.1 m: {along}");
            assert!(along[(1, 1)].sqrt() < 0.02, "{along}");
            let expected_axis = if yaw_rad.cos().abs() > yaw_rad.sin().abs() { 0 } else { 1 };
            assert!(matched.unobserved[expected_axis], "{:?}", matched.unobserved);
        }
    }
}

/// What the published rule makes of the same walls.
#[test]
fn with_lines_through_neighbors_noise_pretends_to_see_the_way_along_the_corridor() {
    let published = DegeneracyRule { pretended_share: 1.0, ..DegeneracyRule::default() };
    let with =
        |lines, degeneracy| ScanOdometrySettings { lines, degeneracy, ..ScanOdometrySettings::default() };
    let n_found = [with(LineKind::Neighbor, published), with(LineKind::Fitted, DegeneracyRule::default())]
        .map(|settings| {
            let found = (0..20).filter(|seed| {
                let mut rng = rng(*seed);
                let key = key_of(&seen(&corridor(), &pose2(0.0, 0.2, 0.0), 361, 0.01, &mut rng), &settings);
                let points = placed(&seen(&corridor(), &pose2(0.1, 0.2, 0.0), 361, 0.01, &mut rng));
                let matched =
                    Registrar::default().register(&key, &points, &prior(pose2(0.06, 0.0, 0.0)), &settings);
                matched.status == MatchStatus::Degenerate
            });
            found.count()
        });
    assert_eq!(n_found, [0, 20]);
}
