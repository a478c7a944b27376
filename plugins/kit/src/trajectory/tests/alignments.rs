use super::*;

/// Pairs whose estimate is the truth seen through a transform and a scale.
fn displaced(rng: &mut Xoshiro256PlusPlus, truth_from_estimate: &Pose3, scale: f64) -> Vec<PosePair> {
    let pair_of = |idx| {
        let truth = random_pose(rng);
        let mut estimate = truth_from_estimate.inverse() * truth;
        estimate.translation.vector /= scale;
        pair(f64::from(idx), truth, estimate)
    };
    (0..12).map(pair_of).collect()
}

fn assert_same(found: &Pose3, expected: &Pose3) {
    assert!((found.translation.vector - expected.translation.vector).norm() < 1e-9);
    assert!(found.rotation.angle_to(&expected.rotation) < 1e-7);
}

#[test]
fn any_rigid_transform_and_scale_is_found_again() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(8);
    for _ in 0..200 {
        let (transform, scale) = (random_pose(&mut rng), rng.random_range(0.1..10.0));
        let pairs = displaced(&mut rng, &transform, scale);
        let found = align(&pairs, Alignment::Sim3).unwrap();
        assert!((found.scale / scale - 1.0).abs() < 1e-9);
        assert_same(&found.truth_from_estimate, &transform);
        assert!(absolute_errors(&pairs, &found).iter().all(|error| *error < 1e-9));
        let rigid = displaced(&mut rng, &transform, 1.0);
        for how in [Alignment::Se3, Alignment::First] {
            assert_same(&align(&rigid, how).unwrap().truth_from_estimate, &transform);
        }
    }
}

#[test]
fn a_turn_on_the_floor_is_found_again_and_nothing_tilts() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
    for _ in 0..100 {
        let yaw = rng.random_range(-3.1..3.1);
        let transform = pose(3.0, -4.0, 0.5, [0.0, 0.0, yaw]);
        let pairs = displaced(&mut rng, &transform, 1.0);
        assert_same(&align(&pairs, Alignment::Yaw).unwrap().truth_from_estimate, &transform);
    }
}

#[test]
fn no_turn_nor_shift_near_the_alignment_is_better() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(10);
    let mut pairs = displaced(&mut rng, &pose(1.0, 2.0, 3.0, [0.3, -0.2, 2.0]), 1.3);
    for pair in &mut pairs {
        pair.estimate.translation.vector += random_pose(&mut rng).translation.vector * 0.05;
    }
    let cost =
        |similarity: &Similarity| absolute_errors(&pairs, similarity).iter().map(|e| e * e).sum::<f64>();
    for how in [Alignment::Yaw, Alignment::Se3, Alignment::Sim3] {
        let best = align(&pairs, how).unwrap();
        for _ in 0..300 {
            let mut near = best;
            let mut nudge = || rng.random_range(-1e-3..1e-3);
            let (roll, pitch) = if how == Alignment::Yaw { (0.0, 0.0) } else { (nudge(), nudge()) };
            let step = pose(nudge(), nudge(), nudge(), [roll, pitch, nudge()]);
            near.truth_from_estimate = step * near.truth_from_estimate;
            if how == Alignment::Sim3 {
                near.scale *= 1.0 + nudge();
            }
            assert!(cost(&near) >= cost(&best), "{how:?}");
        }
    }
}

#[test]
fn a_flat_trajectory_and_its_mirror_image_are_turned_not_mirrored() {
    let corners = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 2.0, 0.0], [0.0, 2.0, 1.0]];
    for mirror in [1.0, -1.0] {
        let place = |[x, y, z]: [f64; 3], sign: f64| pose(x, y, z * sign, [0.0; 3]);
        let pairs: Vec<PosePair> =
            corners.iter().map(|at| pair(0.0, place(*at, 1.0), place(*at, mirror))).collect();
        let found = align(&pairs, Alignment::Se3).unwrap();
        let matrix = found.truth_from_estimate.rotation.to_rotation_matrix();
        assert!((matrix.matrix().determinant() - 1.0).abs() < 1e-9);
    }
    let flat: Vec<PosePair> = corners
        .iter()
        .map(|[x, y, _]| pair(0.0, pose(*x, *y, 0.0, [0.0; 3]), pose(-*y, *x, 0.0, [0.0; 3])))
        .collect();
    let found = align(&flat, Alignment::Se3).unwrap();
    assert!(absolute_errors(&flat, &found).iter().all(|error| *error < 1e-12));
}

#[test]
fn positions_that_do_not_decide_are_refused_with_what_to_do() {
    let still = pair(0.0, pose(1.0, 2.0, 3.0, [0.0; 3]), pose(0.0, 1.0, 0.0, [0.0; 3]));
    let error = align(&[still, still], Alignment::Se3).unwrap_err();
    assert_eq!(error, AlignmentError::OnePlace { which: "the truth" });
    assert!(error.to_string().contains("align with `first`"));
    let moved = PosePair { truth: Pose3::identity(), ..still };
    assert_eq!(
        align(&[still, moved], Alignment::Yaw),
        Err(AlignmentError::OnePlace { which: "the estimate" })
    );
    let line: Vec<PosePair> = (0..5)
        .map(|x| pair(0.0, pose(f64::from(x), 0.0, 0.0, [0.0; 3]), pose(0.0, f64::from(x), 0.0, [0.0; 3])))
        .collect();
    assert_eq!(align(&line, Alignment::Sim3), Err(AlignmentError::OnOneLine));
    assert!(align(&line, Alignment::Yaw).is_ok() && align(&line, Alignment::First).is_ok());
    assert_eq!(align(&[], Alignment::None), Err(AlignmentError::NoPairs));
}
