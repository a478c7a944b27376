use super::*;
use rumbo_core::frames::pose2;
use rumbo_core::time::{Span, Time};
use std::f64::consts::PI;

fn poses(bytes: &[u8]) -> Result<RecordedPoses, LogError> {
    read_poses(&TempFile::new(bytes).0)
}

#[test]
fn a_file_of_poses_is_read_whatever_else_stands_in_its_lines() {
    let text = "# t x y theta\n976053557.767368 4.78 -5.84 -1.69\n976053558.437199 1 2 3 0.034 0.025\n\nx\n";
    for bytes in [text.as_bytes().to_vec(), gzip(text.as_bytes())] {
        let found = poses(&bytes).unwrap();
        assert_eq!(found.track.len(), 2);
        assert_eq!(
            found.track.first(),
            Some((Time::from_secs(976_053_557.767_368), pose2(4.78, -5.84, -1.69)))
        );
        assert_eq!(found.tally.n_faults(), 1);
    }
    let cut = poses(&text.as_bytes()[..text.len() - 6]).unwrap();
    assert_eq!(cut.tally.damage.map(|damage| (damage.line, damage.is_truncated)), Some((3, true)));
    assert_eq!(cut.track.len(), 1, "the cut may go through a number");
    let error = poses(b"one two\n").unwrap_err().to_string();
    assert!(
        error.contains("no pose (skipped 1 line with no number, first line 1: pose.t is `one`"),
        "{error}"
    );
}

#[test]
fn the_poses_inside_a_log_are_those_of_its_vertices_or_laser_messages() {
    let laser = |t| format!("ROBOTLASER1 0 -1.5 3 0.01 50 0.1 0 1 1 0 0 0 0 5 6 0.7 0 0 0 0 0 {t} x 0\n");
    let text = format!("VERTEX2 0 7 8 0.9\n{}{}", laser(1.0), flaser(3, "2.0"));
    let found: Vec<_> = poses(text.as_bytes()).unwrap().track.iter().collect();
    let expected =
        [(Time::from_secs(1.0), pose2(7.0, 8.0, 0.9)), (Time::from_secs(2.0), pose2(1.0, 2.0, 0.5))];
    assert_eq!(found, expected);
}

#[test]
fn poses_between_two_lie_on_the_straight_line_and_turn_the_short_way() {
    let mut track = PoseTrack::default();
    track.push(Time::from_secs(2.0), pose2(1.0, 0.0, -PI + 0.1));
    track.push(Time::from_secs(1.0), pose2(0.0, 2.0, PI - 0.1));
    track.push(Time::from_secs(2.0), pose2(9.0, 9.0, 0.0));
    let middle = track.between(Time::from_secs(1.25), Span::from_secs(1.0)).unwrap();
    assert!((middle.translation.x - 0.25).abs() < 1e-12 && (middle.translation.y - 1.5).abs() < 1e-12);
    assert!((middle.rotation.angle() - (PI - 0.05)).abs() < 1e-12);
    assert_eq!(track.between(Time::from_secs(1.25), Span::from_secs(0.9)), None, "a gap");
    assert_eq!(track.between(Time::from_secs(0.9), Span::from_secs(9.0)), None, "before");
    assert_eq!(track.between(Time::from_secs(2.1), Span::from_secs(9.0)), None, "after");
    assert_eq!(track.between(Time::from_secs(2.0), Span::from_secs(9.0)), Some(pose2(1.0, 0.0, -PI + 0.1)));
    assert_eq!(track.exact(Time::from_secs(2.000_09), Span(100_000)), Some(pose2(1.0, 0.0, -PI + 0.1)));
    assert_eq!(track.exact(Time::from_secs(2.000_11), Span(100_000)), None);
    let twist = track.twist(Time::from_secs(1.5));
    assert!((twist.turn_rad_s - 0.2).abs() < 1e-12 && (twist.speed_m_s() - 5_f64.sqrt()).abs() < 1e-12);
    track.forget_before(Time::from_secs(3.0));
    assert_eq!(track.len(), 1);
}
