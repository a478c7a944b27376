//! FC-A11 without the filter: the lines that were extracted from the published log's scans, put on a map with the true poses.

use super::maps::on_lines;
use super::queries::request;
use nalgebra::Vector2;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::map::{Line, Lines, Map};
use rumbo_core::registry::Plugin;
use rumbo_core::stages::BuildContext;
use rumbo_planners::field_descent::Grouping;
use std::collections::BTreeMap;

/// Segments of one wall: normals within this, ends off its line by at most this, and no wider gap.
const SAME_ANGLE_RAD: f64 = 0.1;
const SAME_OFFSET_M: f64 = 0.15;
const WIDEST_GAP_M: f64 = 1.0;

fn rows(text: &str) -> impl Iterator<Item = Vec<f64>> + '_ {
    text.lines().skip(1).map(|line| line.split(',').map(|word| word.trim().parse().unwrap()).collect())
}

/// Lines of all scans, those of one wall made one.
fn walls() -> Vec<[Point2; 2]> {
    let poses: BTreeMap<u64, Pose2> = rows(include_str!("../data/potential/ekf_log_truth.csv"))
        .map(|v| (v[0] as u64, pose2(v[2], v[3], v[4])))
        .collect();
    let mut walls: Vec<[Point2; 2]> = Vec::new();
    for v in rows(include_str!("../data/potential/ekf_log_lines.csv")) {
        let pose = poses[&(v[0] as u64)];
        let seen = [pose * Point2::new(v[6], v[7]), pose * Point2::new(v[8], v[9])];
        match walls.iter_mut().find(|wall| is_same(wall, &seen)) {
            Some(wall) => *wall = joined(wall, &seen),
            None => walls.push(seen),
        }
    }
    walls
}

fn along([from, to]: &[Point2; 2]) -> Vector2<f64> {
    (to - from).normalize()
}

fn is_same(wall: &[Point2; 2], seen: &[Point2; 2]) -> bool {
    let (along, length_m) = (along(wall), (wall[1] - wall[0]).norm());
    let turn = along.perp(&self::along(seen)).abs().asin();
    let places = seen.map(|end| (end - wall[0]).dot(&along));
    let offsets = seen.map(|end| (end - wall[0]).perp(&along).abs());
    let [first, last] = [places[0].min(places[1]), places[0].max(places[1])];
    turn < SAME_ANGLE_RAD
        && offsets.iter().all(|offset| *offset < SAME_OFFSET_M)
        && first < length_m + WIDEST_GAP_M
        && last > -WIDEST_GAP_M
}

fn joined(wall: &[Point2; 2], seen: &[Point2; 2]) -> [Point2; 2] {
    let along = along(wall);
    let place = |end: &Point2| (end - wall[0]).dot(&along);
    let all = [wall[0], wall[1], seen[0], seen[1]];
    let pick = |k: fn(f64, f64) -> f64| wall[0] + along * all.iter().map(place).reduce(k).unwrap();
    [pick(f64::min), pick(f64::max)]
}

#[test]
fn lines_from_the_logs_scans_are_planned_through_unchanged() {
    let walls = walls();
    // 28 lines are there; the robot drives in the middle of the hall and never sees the far faces of its columns.
    assert!((16..=28).contains(&walls.len()), "{}", walls.len());
    let line =
        |[from, to]: &[Point2; 2]| Line { from: [from.x, from.y], to: [to.x, to.y], ..Line::default() };
    let map = Map {
        lines: Some(Lines { lines: walls.iter().map(line).collect::<Vec<_>>().into() }),
        ..Map::default()
    };
    let request = request(&map, Point2::new(19.5, 10.0), Point2::new(5.0, 10.0));
    for group in [Grouping::Outline, Grouping::Segment] {
        let mut planner = on_lines(group).build(&BuildContext::bare("planner")).unwrap();
        let path = planner.plan(&request).unwrap();
        assert!((14.5..15.5).contains(&path.length_m()), "{}", path.length_m());
        assert_eq!(path.end().position, Point2::new(5.0, 10.0));
    }
}
