//! Obstacles from wall lines that nobody has grouped.

use super::outline::{parts, turn_rad};
use super::{Group, Piece};
use nalgebra::Point2;
use std::collections::BTreeMap;

/// Ends that agree when rounded to this are one corner, meters.
const SAME_CORNER_M: f64 = 1e-4;

/// Every line is an obstacle of its own: a map of lines that do not meet, as SLAM makes them. Corners count twice, which
/// only strengthens them.
pub fn each_line(lines: &[[Point2<f64>; 2]]) -> Vec<Group> {
    lines.iter().map(|[from, to]| vec![Piece::between(*from, *to)]).collect()
}

/// Lines that close an outline, each corner of exactly two of them, are parted as outlines are: a rack is one obstacle, and
/// the walls of a room are one each. Free space is on the side of an outline where `seen_from` is. All other lines are
/// obstacles of their own.
pub fn outlines_of_lines(lines: &[[Point2<f64>; 2]], seen_from: Point2<f64>) -> Vec<Group> {
    let mut at_corner: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
    let corner = |p: Point2<f64>| [p.x, p.y].map(|v| (v / SAME_CORNER_M).round() as i64);
    for (idx, line) in lines.iter().enumerate() {
        for end in line {
            at_corner.entry(corner(*end)).or_default().push(idx);
        }
    }
    let mut is_used = vec![false; lines.len()];
    let mut groups = Vec::new();
    for first in 0..lines.len() {
        if is_used[first] {
            continue;
        }
        is_used[first] = true;
        match closed_from(first, lines, &at_corner, corner) {
            Some((places, corners)) => {
                places.iter().for_each(|place| is_used[*place] = true);
                groups.extend(parted(corners, seen_from));
            }
            None => groups.push(vec![Piece::between(lines[first][0], lines[first][1])]),
        }
    }
    groups
}

/// The lines and corners of the outline that a line is a part of.
fn closed_from(
    first: usize,
    lines: &[[Point2<f64>; 2]],
    at_corner: &BTreeMap<[i64; 2], Vec<usize>>,
    corner: impl Fn(Point2<f64>) -> [i64; 2],
) -> Option<(Vec<usize>, Vec<Point2<f64>>)> {
    let (mut places, mut corners) = (vec![first], vec![lines[first][0]]);
    let (mut here, mut end) = (first, lines[first][1]);
    if corner(lines[first][0]) == corner(end) {
        return None;
    }
    while places.len() <= lines.len() {
        let [a, b] = at_corner.get(&corner(end))?.as_slice() else { return None };
        let next = if *a == here { *b } else { *a };
        if next == here {
            return None;
        }
        if next == first {
            return (corner(end) == corner(corners[0]) && places.len() > 2).then_some((places, corners));
        }
        corners.push(end);
        places.push(next);
        let [from, to] = lines[next];
        end = if corner(from) == corner(end) { to } else { from };
        here = next;
    }
    None
}

fn parted(mut corners: Vec<Point2<f64>>, seen_from: Point2<f64>) -> Vec<Group> {
    let n = corners.len();
    let twice_area: f64 = (0..n).map(|i| corners[i].coords.perp(&corners[(i + 1) % n].coords)).sum();
    let is_counterclockwise = twice_area > 0.0;
    // Free space on the left: counter-clockwise around what is inside.
    if is_counterclockwise != is_inside(&corners, seen_from) {
        corners.reverse();
    }
    let side = |i: usize| {
        let along = corners[(i + 1) % n] - corners[i % n];
        [along.x, along.y]
    };
    let turns: Vec<f64> = (0..n).map(|i| turn_rad(side(i + n - 1), side(i))).collect();
    let piece = |i: usize| Piece::between(corners[i % n], corners[(i + 1) % n]);
    parts(&turns).into_iter().map(|sides| sides.map(piece).collect()).collect()
}

/// Even-odd rule.
fn is_inside(corners: &[Point2<f64>], at: Point2<f64>) -> bool {
    let pairs = corners.iter().zip(corners.iter().cycle().skip(1));
    let crossings = pairs.filter(|(a, b)| {
        (a.y > at.y) != (b.y > at.y) && at.x < a.x + (at.y - a.y) / (b.y - a.y) * (b.x - a.x)
    });
    crossings.count() % 2 == 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Vec<[Point2<f64>; 2]> {
        let c = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(Point2::from);
        (0..4).map(|i| [c[i], c[(i + 1) % 4]]).collect()
    }

    fn sizes(groups: &[Group]) -> Vec<usize> {
        groups.iter().map(Vec::len).collect()
    }

    #[test]
    fn a_rack_in_a_hall_is_one_obstacle_among_four_walls() {
        let mut lines = rectangle(0.0, 0.0, 10.0, 8.0);
        let mut rack = rectangle(4.0, 4.0, 6.0, 5.0);
        // Neither the order nor the sense of lines matters.
        rack.swap(1, 2);
        rack[3].swap(0, 1);
        lines.extend(rack);
        lines.push([Point2::new(8.0, 1.0), Point2::new(9.0, 1.0)]);
        let groups = outlines_of_lines(&lines, Point2::new(1.0, 1.0));
        assert_eq!(sizes(&groups), [1, 1, 1, 1, 4, 1]);
        // Seen from inside, the rack is a room of its own.
        let groups = outlines_of_lines(&lines, Point2::new(5.0, 4.5));
        assert_eq!(sizes(&groups), [1; 9]);
        assert_eq!(sizes(&each_line(&lines)), [1; 9]);
    }

    #[test]
    fn lines_that_branch_or_end_are_alone() {
        let p = |x: f64, y: f64| Point2::new(x, y);
        let star = [[p(0.0, 0.0), p(1.0, 0.0)], [p(0.0, 0.0), p(0.0, 1.0)], [p(0.0, 0.0), p(-1.0, 0.0)]];
        assert_eq!(sizes(&outlines_of_lines(&star, p(5.0, 5.0))), [1; 3]);
        let point = [[p(2.0, 2.0), p(2.0, 2.0)]];
        assert_eq!(sizes(&outlines_of_lines(&point, p(5.0, 5.0))), [1]);
        let there_and_back = [[p(0.0, 0.0), p(1.0, 0.0)], [p(1.0, 0.0), p(0.0, 0.0)]];
        assert_eq!(sizes(&outlines_of_lines(&there_and_back, p(5.0, 5.0))), [1; 2]);
    }
}
