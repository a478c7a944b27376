//! Ways of particles against whole histories that are copied.

use crate::rbpf_slam::diary::Diary;
use crate::rbpf_slam::lineage::Lineage;
use rumbo_core::frames::{Pose2, flatten, pose2};
use rumbo_core::rng::{RngExt as _, stream};
use rumbo_core::time::Time;

#[test]
fn every_particle_has_the_way_that_it_would_have_kept_itself() {
    let mut rng = stream(2, "ways");
    for n in [1usize, 2, 7, 30] {
        let mut lineage = Lineage::default();
        lineage.begin(n);
        let mut ways: Vec<Vec<Pose2>> = vec![Vec::new(); n];
        let mut most_kept = 0;
        for k in 0..200 {
            let poses: Vec<Pose2> = (0..n).map(|idx| pose2(f64::from(k), idx as f64, rng.random())).collect();
            lineage.push(poses.iter().copied());
            ways.iter_mut().zip(&poses).for_each(|(way, pose)| way.push(*pose));
            if rng.random_range(0..3) == 0 {
                let mut ancestors: Vec<usize> = (0..n).map(|_| rng.random_range(0..n)).collect();
                ancestors.sort_unstable();
                lineage.resample(&ancestors);
                ways = ancestors.iter().map(|ancestor| ways[*ancestor].clone()).collect();
            }
            for (idx, way) in ways.iter().enumerate() {
                assert_eq!(&lineage.way_of(idx), way, "{n} particles, step {k}, particle {idx}");
            }
            most_kept = most_kept.max(lineage.layers.len());
        }
        assert_eq!(lineage.len(), 200);
        assert!(n > 7 || most_kept < 100, "what all share is kept once: {most_kept} layers of {n}");
    }
}

#[test]
fn scans_between_two_steps_share_what_the_filter_drew_differently() {
    let mut diary = Diary::default();
    let at = Time::from_secs;
    diary.step(at(0.0), &Pose2::identity());
    diary.note(at(1.0), &pose2(1.0, 0.0, 0.0));
    diary.note(at(0.5), &pose2(9.0, 0.0, 0.0));
    diary.step(at(2.0), &pose2(2.0, 0.0, 0.0));
    diary.note(at(3.0), &pose2(1.0, 0.0, 0.0));
    let way = [pose2(10.0, 0.0, 0.0), pose2(12.2, 0.4, 0.2)];
    let poses: Vec<(f64, Pose2)> =
        diary.trajectory(&way).iter().map(|p| (p.stamp.as_secs(), flatten(&p.map_from_base))).collect();
    let expected =
        [(0.0, way[0]), (1.0, pose2(11.1, 0.2, 0.1)), (2.0, way[1]), (3.0, way[1] * pose2(1.0, 0.0, 0.0))];
    assert_eq!(poses.len(), expected.len(), "a scan that is late is left out");
    for ((stamp, pose), (expected_stamp, expected)) in poses.iter().zip(expected) {
        assert_eq!(*stamp, expected_stamp);
        let off = expected.inverse() * pose;
        assert!(off.translation.vector.norm() < 1e-9 && off.rotation.angle().abs() < 1e-9, "{stamp}: {pose}");
    }
}
