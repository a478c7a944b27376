use super::*;

/// Every possible pair in the order of its gap, each pose once.
fn brute_force(truth: &Trajectory, estimate: &Trajectory, max_gap: Span) -> Vec<(usize, usize)> {
    let mut all = Vec::new();
    for (i, a) in truth.poses().iter().enumerate() {
        for (j, b) in estimate.poses().iter().enumerate() {
            let gap = (a.stamp - b.stamp).0.abs();
            if gap < max_gap.0 {
                all.push((gap, i, j));
            }
        }
    }
    all.sort_unstable();
    let mut pairs: Vec<(usize, usize)> = Vec::new();
    for (_, i, j) in all {
        if pairs.iter().all(|(a, b)| *a != i && *b != j) {
            pairs.push((i, j));
        }
    }
    pairs.sort_unstable();
    pairs
}

#[test]
fn pairs_are_those_of_brute_force_for_any_gap() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for round in 0..400 {
        // Whole milliseconds, so that there are ties.
        let mut some = |most: usize| -> Vec<f64> {
            let n = rng.random_range(0..most);
            (0..n).map(|_| f64::from(rng.random_range(0..60)) * 1e-3).collect()
        };
        let (truth, estimate) = (at(&some(30)), at(&some(20)));
        for gap_s in [0.001, 0.0025, 0.008, 1.0] {
            let max_gap = Span::from_secs(gap_s);
            let found = associate(&truth, &estimate, max_gap);
            assert_eq!(found, brute_force(&truth, &estimate, max_gap), "round {round}, {gap_s} s");
        }
    }
}

#[test]
fn a_gap_as_large_as_the_limit_is_too_large() {
    assert_eq!(associate(&at(&[1.0]), &at(&[1.02]), Span::from_secs(0.02)), []);
    assert_eq!(associate(&at(&[1.0]), &at(&[1.019_999]), Span::from_secs(0.02)), [(0, 0)]);
    assert_eq!(associate(&at(&[]), &at(&[1.0]), Span::from_secs(9.0)), []);
}

#[test]
fn poses_are_sorted_and_of_equal_stamps_the_first_stays() {
    let poses = [2.0, 1.0, 2.0, 0.5].map(|t| stamped(t, pose(t, 0.0, 0.0, [0.0; 3])));
    let mut poses = poses.to_vec();
    poses[2].world_from_body.translation.x = 7.0;
    let (found, repairs) = Trajectory::of(poses);
    assert_eq!(repairs, Repairs { n_out_of_order: 2, n_repeated: 1 });
    let places: Vec<f64> = found.poses().iter().map(|pose| pose.world_from_body.translation.x).collect();
    assert_eq!(places, [0.5, 1.0, 2.0]);
    assert_eq!(found.length_m(), 1.5);
}

#[test]
fn the_nearest_pose_of_two_equally_near_ones_is_the_earlier() {
    let line = at(&[1.0, 2.0, 4.0]);
    for (asked, nearest) in [(0.0, 1.0), (1.5, 1.0), (1.6, 2.0), (3.5, 4.0), (9.0, 4.0), (2.0, 2.0)] {
        assert_eq!(line.nearest(Time::from_secs(asked)).unwrap().stamp, Time::from_secs(nearest), "{asked}");
    }
    assert_eq!(at(&[]).nearest(Time::ZERO), None);
}

#[test]
fn a_pose_between_two_moves_straight_and_turns_evenly() {
    let line = trajectory(vec![
        stamped(1.0, pose(0.0, 0.0, 1.0, [0.0, 0.0, 3.0])),
        stamped(2.0, pose(4.0, 0.0, 1.0, [0.0, 0.0, -3.0])),
    ]);
    let middle = line.between(Time::from_secs(1.25), Span::from_secs(1.0)).unwrap();
    assert!((middle.translation.vector - Vector3::new(1.0, 0.0, 1.0)).norm() < 1e-12);
    let turn = 2.0 * (std::f64::consts::PI - 3.0) / 4.0;
    assert!((middle.rotation.euler_angles().2 - (3.0 + turn)).abs() < 1e-9);
    assert_eq!(line.between(Time::from_secs(1.25), Span::from_secs(0.9)), None, "a gap");
    assert_eq!(line.between(Time::from_secs(0.5), Span::from_secs(9.0)), None, "before");
    assert_eq!(line.between(Time::from_secs(2.5), Span::from_secs(9.0)), None, "after");
}
