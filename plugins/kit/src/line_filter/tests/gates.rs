//! Which line is which wall: just inside and just outside of each limit (ML-A12).

use super::{close, seen, sure};
use crate::line_filter::*;
use crate::lines::SensedLine;
use nalgebra::Vector5;
use rumbo_core::map::Line;

/// A wall 5 m ahead, from 2 m to the right to 2 m to the left, known exactly.
fn ahead() -> Line {
    Line { from: [5.0, 2.0], to: [5.0, -2.0], covariance: [0.0; 3] }
}

fn on_map(lines: &[Line]) -> LineFilter {
    let (robot, covariance) = sure();
    LineFilter::on_map(FilterSettings::default(), robot, &covariance, &WallMap::new(lines))
}

fn is_matched(filter: &LineFilter, line: SensedLine) -> bool {
    !filter.clone().read_lines(&[line], &Mount::default()).matches.is_empty()
}

#[test]
fn the_layer_has_walls_to_the_left_of_their_way() {
    let filter = on_map(&[ahead()]);
    close(filter.state().walls[0][0], 5.0, 1e-12, "rho");
    close(filter.state().walls[0][1], 0.0, 1e-12, "phi");
    assert_eq!(filter.layer(), [ahead()]);
    let behind = Line { from: [5.0, -2.0], to: [5.0, 2.0], covariance: [0.0; 3] };
    let other_face = on_map(&[behind]);
    close(other_face.state().walls[0][0], -5.0, 1e-12, "rho of the other face");
    assert!(!is_matched(&other_face, seen(5.0, 0.0, [-2.0, 2.0])), "it faces away");
    assert!(is_matched(&filter, seen(5.0, 0.0, [-2.0, 2.0])));
    assert!(WallMap::new(&[Line { from: [1.0; 2], to: [1.0; 2], covariance: [0.0; 3] }]).is_empty());
    assert!(WallMap::new(&[Line { from: [f64::NAN; 2], to: [1.0; 2], covariance: [0.0; 3] }]).is_empty());
}

#[test]
fn the_distance_gate_is_where_the_chi_square_says() {
    let filter = on_map(&[ahead()]);
    // The robot's own 1e-6 adds to the line's 1e-4, and 1e-6 of its heading to 1e-5.
    let limit = (9.0 * (1e-4 + 1e-6f64)).sqrt();
    assert!(is_matched(&filter, seen(5.0 + 0.999 * limit, 0.0, [-2.0, 2.0])));
    assert!(!is_matched(&filter, seen(5.0 + 1.001 * limit, 0.0, [-2.0, 2.0])));
    let limit = (9.0 * (1e-5 + 1e-6f64)).sqrt();
    assert!(is_matched(&filter, seen(5.0, 0.999 * limit, [-2.0, 2.0])));
    assert!(!is_matched(&filter, seen(5.0, -1.001 * limit, [-2.0, 2.0])));
}

#[test]
fn meters_and_radians_have_limits_of_their_own() {
    let filter = on_map(&[ahead()]);
    let unsure = |distance_m: f64, normal_rad: f64, along_m| SensedLine {
        covariance: [1.0, 0.0, 1.0],
        ..seen(distance_m, normal_rad, along_m)
    };
    assert!(is_matched(&filter, unsure(5.79, 0.0, [-1.0, 1.0])));
    assert!(!is_matched(&filter, unsure(5.81, 0.0, [-1.0, 1.0])));
    let limit = 20f64.to_radians();
    assert!(is_matched(&filter, unsure(5.0, limit - 1e-6, [-1.0, 1.0])));
    assert!(!is_matched(&filter, unsure(5.0, limit + 1e-6, [-1.0, 1.0])));
    assert!(is_matched(&filter, unsure(5.0, -limit + 1e-6, [-1.0, 1.0])));
}

#[test]
fn a_gap_of_a_meter_is_the_same_wall_and_a_wider_one_is_not() {
    let filter = on_map(&[ahead()]);
    assert!(is_matched(&filter, seen(5.0, 0.0, [2.999, 4.0])));
    assert!(!is_matched(&filter, seen(5.0, 0.0, [3.001, 4.0])));
    assert!(is_matched(&filter, seen(5.0, 0.0, [-4.0, -2.999])));
    assert!(!is_matched(&filter, seen(5.0, 0.0, [-4.0, -3.001])));
}

#[test]
fn a_robot_just_behind_a_wall_still_sees_it() {
    let facing = |ahead_m: f64| {
        let (mut robot, covariance) = sure();
        robot[0] = ahead_m;
        let map = WallMap::new(&[ahead()]);
        let filter = LineFilter::on_map(FilterSettings::default(), robot, &covariance, &map);
        let line = SensedLine { covariance: [1.0, 0.0, 1.0], ..seen(0.01, 0.0, [-1.0, 1.0]) };
        is_matched(&filter, line)
    };
    assert!(facing(5.29) && !facing(5.31));
}

#[test]
fn the_nearest_wall_wins_and_pieces_of_one_wall_are_all_taken() {
    let near = Line { from: [5.02, 2.0], to: [5.02, -2.0], ..ahead() };
    let mut filter = on_map(&[ahead(), near]);
    let lines = [seen(5.015, 0.0, [-2.0, -1.0]), seen(5.001, 0.0, [0.0, 1.0]), seen(5.018, 0.0, [1.0, 2.0])];
    let report = filter.read_lines(&lines, &Mount::default());
    let walls: Vec<usize> = report.matches.iter().map(|found| found.wall).collect();
    assert_eq!(walls, [1, 0, 1]);
}

#[test]
fn an_angle_across_the_wrap_is_small() {
    let west = Line { from: [-5.0, -2.0], to: [-5.0, 2.0], covariance: [0.0; 3] };
    let filter = on_map(&[west]);
    close(filter.state().walls[0][1].abs(), std::f64::consts::PI, 1e-12, "phi");
    let pi = std::f64::consts::PI;
    assert!(is_matched(&filter, seen(5.0, pi - 1e-3, [-2.0, 2.0])));
    assert!(is_matched(&filter, seen(5.0, -pi + 1e-3, [-2.0, 2.0])));
}

#[test]
fn a_slipping_wheel_a_slow_robot_and_no_number_are_left_out() {
    let filter = on_map(&[ahead()]);
    let mut slipping = filter.clone();
    assert!(matches!(slipping.read_wheels([0.0, 0.2]), Reading::Slipping(_)));
    assert_eq!(slipping.state(), filter.state());
    for odd in [f64::NAN, f64::INFINITY, 1e300] {
        let mut filter = filter.clone();
        assert!(matches!(filter.read_wheels([odd, 0.0]), Reading::Slipping(_) | Reading::Refused));
        assert!(filter.state().is_finite());
    }
    assert_eq!(slipping.read_steering(0.1), Reading::TooSlow);
    assert!(matches!(slipping.read_wheels([0.01, -0.01]), Reading::Fused(_)));
    let (_, covariance) = sure();
    let moving = Vector5::new(0.0, 0.0, 0.0, 0.51, 0.0);
    let mut moving = LineFilter::building(FilterSettings::default(), moving, &covariance);
    assert!(matches!(moving.read_steering(0.0), Reading::Fused(_)));
    assert_eq!(moving.read_steering(f64::NAN), Reading::Refused);
}

#[test]
fn scans_without_lines_and_impossible_lines_change_nothing() {
    for filter in [on_map(&[ahead()]), on_map(&[])] {
        let mut after = filter.clone();
        assert_eq!(after.read_lines(&[], &Mount::default()), ScanReport::default());
        let odd = [seen(f64::NAN, 0.0, [-1.0, 1.0]), seen(5.0, f64::NAN, [-1.0, 1.0])];
        assert!(after.read_lines(&odd, &Mount::default()).matches.is_empty());
        assert_eq!(after.state(), filter.state());
    }
}
