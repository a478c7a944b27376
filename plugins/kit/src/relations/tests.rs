use super::*;
use crate::trajectory::StampedPose;
use rumbo_core::frames::{lift, pose2};
use std::f64::consts::PI;

fn track(poses: &[(f64, [f64; 3])]) -> Trajectory {
    let stamped = |(t, [x, y, yaw]): &(f64, [f64; 3])| StampedPose {
        stamp: Time::from_secs(*t),
        world_from_body: lift(&pose2(*x, *y, *yaw)),
    };
    Trajectory::of(poses.iter().map(stamped).collect()).0
}

fn relation(from: f64, to: f64, [x, y, yaw]: [f64; 3]) -> Relation {
    let first_from_second = lift(&pose2(x, y, yaw));
    Relation { from: Time::from_secs(from), to: Time::from_secs(to), first_from_second }
}

fn assert_near(found: &[f64], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found}, expected {expected}");
    }
}

const TOLERANCE: Span = Span(20_000);

#[test]
fn an_error_is_what_the_motion_is_off_by_hand() {
    // From the first pose, which looks along y, the second lies 2 m ahead and looks back.
    let poses = track(&[(1.0, [5.0, 5.0, PI / 2.0]), (2.0, [5.0, 7.0, -PI / 2.0]), (3.0, [0.0, 0.0, 0.0])]);
    let relations = [
        relation(1.0, 2.0, [2.0, 0.0, PI]),
        relation(1.0, 2.0, [2.0, 0.3, PI - 0.1]),
        relation(2.0, 1.0, [2.0, 0.0, PI]),
        relation(1.0, 4.0, [0.0, 0.0, 0.0]),
        relation(1.0, 2.000_03, [2.0, 0.0, PI]),
    ];
    let errors = relation_errors(&relations, |stamp| pose_near(&poses, stamp, TOLERANCE));
    assert_near(&errors.translation_m, &[0.0, 0.3, 0.0]);
    assert_near(&errors.rotation_rad, &[0.0, 0.1, 0.0]);
    assert_eq!(errors.n_missed, 2, "no pose at 4 s, and none within the tolerance of 2.00003 s");
}

#[test]
fn odometry_moves_the_nearest_known_pose_on_and_back() {
    // The odometer runs along its own x axis; the world is turned by a quarter.
    let odometry: Vec<(f64, [f64; 3])> =
        (0..=10).map(|t| (f64::from(t) * 0.5, [f64::from(t), 0.0, 0.0])).collect();
    let odometry = track(&odometry);
    let poses = track(&[(1.0, [0.0, 2.0, PI / 2.0]), (4.0, [0.5, 8.0, PI / 2.0])]);
    let corrected = CorrectedOdometry { poses: &poses, odometry: &odometry, tolerance: TOLERANCE };
    for (seconds, place) in [
        (1.0, Some([0.0, 2.0])),
        (0.0, Some([0.0, 0.0])),
        (2.0, Some([0.0, 4.0])),
        (2.25, Some([0.0, 4.5])),
        (3.0, Some([0.5, 6.0])),
        (5.0, Some([0.5, 10.0])),
        (6.0, None),
    ] {
        let found = corrected.pose_at(Time::from_secs(seconds));
        let found = found.map(|pose| [pose.translation.x, pose.translation.y]);
        match (found, place) {
            (Some(found), Some(place)) => assert_near(&found, &place),
            (found, place) => assert_eq!(found, place, "{seconds} s"),
        }
    }
    let gap = track(&[(0.0, [0.0, 0.0, 0.0]), (1.0, [1.0, 0.0, 0.0]), (4.0, [2.0, 0.0, 0.0])]);
    let corrected = CorrectedOdometry { odometry: &gap, ..corrected };
    assert_eq!(corrected.pose_at(Time::from_secs(2.0)), None, "nobody knows what happened in the gap");
}

#[test]
fn a_rounded_stamp_means_that_of_the_log() {
    let odometry = track(&[(1.0, [1.0, 0.0, 0.0]), (1.5, [1.5, 0.0, 0.0]), (2.0, [2.0, 0.0, 0.0])]);
    let poses = track(&[(1.0, [0.0, 0.0, 0.0]), (2.0, [5.0, 0.0, 0.0])]);
    let corrected = CorrectedOdometry { poses: &poses, odometry: &odometry, tolerance: TOLERANCE };
    // As written, 1.500004 s is nearer to the second pose; the log's 1.5 s is as near to both, and the earlier counts.
    let found = corrected.pose_at(Time::from_secs(1.500_004)).unwrap();
    assert_near(&[found.translation.x], &[0.5]);
}

#[test]
fn relations_are_read_and_what_is_none_is_told_with_its_line() {
    let path = std::env::temp_dir().join(format!("rumbo-relations-{}.txt", std::process::id()));
    let read = |text: &str| {
        std::fs::write(&path, text).unwrap();
        let read = read_relations(&path);
        read.map_err(|error| error.to_string().replace(&path.display().to_string(), "FILE"))
    };
    let (relations, notes) = read("# t1 t2 ...\n1.5 2.5 0.1 -0.2 0 0 0 3.0\n1 2 nan 0 0 0 0 0\n").unwrap();
    assert_eq!(relations, [relation(1.5, 2.5, [0.1, -0.2, 3.0])]);
    assert!(notes[0].contains("1 line was left out, first line 3: relation.x is NaN"), "{notes:?}");
    for (text, expected) in [
        ("", "FILE: the file is empty, expected t1 t2 x y z roll pitch yaw"),
        ("# only\n", "FILE: no relation (1 lines, all of them empty or comments), expected lines of `t1 t2"),
        ("1 2 3\n", "FILE:1: relation.y is missing at the end of the line"),
        ("1 2 0 0 0 0 0 0\n1 b 0 0 0 0 0 0\n", "FILE:2: relation.t2 is `b`, expected a number"),
        ("1 2 0 0 0 0 0 0 7\n", "FILE:1: relation.end is followed by 1 more words, expected t1 t2"),
    ] {
        let message = read(text).unwrap_err();
        assert!(message.contains(expected), "{text:?} gave {message}");
    }
    std::fs::remove_file(&path).unwrap();
}
