use super::*;

/// Poses at x = 0, 1, 3, 6, 10 and t = 0, 1, 2, 4, 8.
fn pairs() -> Vec<PosePair> {
    let places = [0.0, 1.0, 3.0, 6.0, 10.0];
    let stamps = [0.0, 1.0, 2.0, 4.0, 8.0];
    let at = |x: f64| pose(x, 0.0, 0.0, [0.0; 3]);
    stamps.iter().zip(places).map(|(t, x)| pair(*t, at(2.0 * x), at(x))).collect()
}

#[test]
fn steps_in_frames_seconds_and_meters_end_at_the_first_pose_that_is_far_enough() {
    use PairChoice::{All, Consecutive, EveryStart};
    for (step, choice, expected) in [
        (Step::Frames(2), EveryStart, vec![(0, 2), (1, 3), (2, 4)]),
        (Step::Frames(2), Consecutive, vec![(0, 2), (2, 4)]),
        (Step::Seconds(2.0), EveryStart, vec![(0, 2), (1, 3), (2, 3), (3, 4)]),
        (Step::Seconds(2.0), Consecutive, vec![(0, 2), (2, 3), (3, 4)]),
        (Step::Meters(3.0), EveryStart, vec![(0, 2), (1, 3), (2, 3), (3, 4)]),
        (Step::Meters(4.0), Consecutive, vec![(0, 3), (3, 4)]),
        (Step::Meters(11.0), EveryStart, vec![]),
        (Step::Frames(5), Consecutive, vec![]),
        (Step::Frames(0), Consecutive, vec![(0, 1), (1, 2), (2, 3), (3, 4)]),
    ] {
        assert_eq!(index_pairs(&pairs(), step, choice), expected, "{step:?} {choice:?}");
    }
    assert_eq!(index_pairs(&pairs(), Step::Frames(9), All).len(), 10);
    assert_eq!(index_pairs(&[], Step::Frames(1), All), []);
}

#[test]
fn a_step_error_is_what_the_step_is_off_by_hand() {
    let as_it_is = align(&pairs(), Alignment::None).unwrap();
    let errors = relative_errors(&pairs(), &as_it_is, &[(0, 1), (1, 4)]);
    assert_eq!(errors.translation_m, [1.0, 9.0]);
    assert_eq!(errors.rotation_rad, [0.0, 0.0]);
    let turned = [
        pair(0.0, Pose3::identity(), pose(5.0, 5.0, 0.0, [0.0, 0.0, 3.0])),
        pair(1.0, Pose3::identity(), pose(5.0, 5.0, 0.0, [0.0, 0.0, -3.0])),
    ];
    let around = relative_errors(&turned, &as_it_is, &[(0, 1), (0, 7)]);
    assert!((around.rotation_rad[0] - (2.0 * std::f64::consts::PI - 6.0)).abs() < 1e-12);
    assert_eq!(around.rotation_rad.len(), 1, "a pose that does not exist is in no step");
}

#[test]
fn relative_errors_do_not_depend_on_a_rigid_alignment() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
    let random: Vec<PosePair> =
        (0..9).map(|idx| pair(f64::from(idx), random_pose(&mut rng), random_pose(&mut rng))).collect();
    let compared = index_pairs(&random, Step::Frames(1), PairChoice::All);
    let of = |how| relative_errors(&random, &align(&random, how).unwrap(), &compared);
    let (plain, aligned) = (of(Alignment::None), of(Alignment::Se3));
    for (a, b) in plain.translation_m.iter().zip(&aligned.translation_m) {
        assert!((a - b).abs() < 1e-9);
    }
    for (a, b) in plain.rotation_rad.iter().zip(&aligned.rotation_rad) {
        assert!((a - b).abs() < 1e-6);
    }
}
