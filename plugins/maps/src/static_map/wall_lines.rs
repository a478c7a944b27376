//! Straight pieces of wall in a grid: contours between occupied and free cells, split where they bend (Ramer 1972;
//! Douglas and Peucker 1973), each piece fitted by total least squares.

use nalgebra::{Point2, Vector2};
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::Line;
use rumbo_kit::map_file::MapImage;

/// A contour may stray this far from a straight piece, in cells: the stairs of a slanted wall stray 0.5.
const TOLERANCE_CELLS: f64 = 1.0;
/// Variance of a wall's place inside its cell, in cells squared.
const CELL_VARIANCE: f64 = 1.0 / 12.0;

type Point = Point2<f64>;

/// A side of an occupied cell that faces a free one; sides are counted counter-clockwise from the right.
///
/// Walked so that the wall is on the left: a side starts at its clockwise corner.
#[derive(Clone, Copy)]
struct Side {
    col: i64,
    row: i64,
    side: usize,
}

/// Outward steps of the four sides.
const OUT: [(i64, i64); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

struct Contours<'a> {
    map: &'a MapImage,
}

impl Contours<'_> {
    fn occupancy(&self, col: i64, row: i64) -> i8 {
        match (usize::try_from(col), usize::try_from(row)) {
            (Ok(col), Ok(row)) => self.map.occupancy(col, row),
            _ => rumbo_kit::map_file::UNKNOWN,
        }
    }

    fn is_contour(&self, at: Side) -> bool {
        let (out_col, out_row) = OUT[at.side];
        let free = self.occupancy(at.col + out_col, at.row + out_row);
        self.occupancy(at.col, at.row) > 50 && (0..50).contains(&free)
    }

    /// The contour's next side, if it goes on: outward corner, straight on, or inward corner.
    fn next(&self, at: Side) -> Option<Side> {
        let (out, ahead) = (OUT[at.side], OUT[(at.side + 1) % 4]);
        let next = if self.occupancy(at.col + out.0 + ahead.0, at.row + out.1 + ahead.1) > 50 {
            Side { col: at.col + out.0 + ahead.0, row: at.row + out.1 + ahead.1, side: (at.side + 3) % 4 }
        } else if self.occupancy(at.col + ahead.0, at.row + ahead.1) > 50 {
            Side { col: at.col + ahead.0, row: at.row + ahead.1, side: at.side }
        } else {
            Side { side: (at.side + 1) % 4, ..at }
        };
        self.is_contour(next).then_some(next)
    }

    fn number(&self, at: Side) -> usize {
        (at.row as usize * self.map.width + at.col as usize) * 4 + at.side
    }

    fn all(&self) -> Vec<Side> {
        let (width, height) = (self.map.width as i64, self.map.height as i64);
        let cells = (0..height).flat_map(|row| (0..width).map(move |col| (col, row)));
        cells
            .flat_map(|(col, row)| (0..4).map(move |side| Side { col, row, side }))
            .filter(|side| self.is_contour(*side))
            .collect()
    }

    /// Chains of sides: open ones from their first side, closed ones from any.
    fn chains(&self) -> Vec<Vec<Side>> {
        let sides = self.all();
        let mut follows = vec![false; self.map.width * self.map.height * 4];
        for next in sides.iter().filter_map(|side| self.next(*side)) {
            follows[self.number(next)] = true;
        }
        let (followers, firsts): (Vec<Side>, Vec<Side>) =
            sides.iter().partition(|side| follows[self.number(**side)]);
        let mut seen = vec![false; follows.len()];
        let mut chains = Vec::new();
        for start in firsts.into_iter().chain(followers) {
            let mut chain = Vec::new();
            let mut at = Some(start);
            while let Some(side) = at.filter(|side| !seen[self.number(*side)]) {
                seen[self.number(side)] = true;
                chain.push(side);
                at = self.next(side);
            }
            if !chain.is_empty() {
                chains.push(chain);
            }
        }
        chains
    }
}

impl Side {
    fn middle(self) -> Point {
        let (x, y) = OUT[self.side];
        Point::new(self.col as f64 + 0.5 + 0.5 * x as f64, self.row as f64 + 0.5 + 0.5 * y as f64)
    }

    /// Half of the side, along the walk.
    fn half(self) -> Vector2<f64> {
        let (x, y) = OUT[(self.side + 1) % 4];
        Vector2::new(x as f64, y as f64) / 2.0
    }
}

/// Wall lines of at least `min_line_m`, in the map's frame.
pub fn wall_lines(map: &MapImage, min_line_m: f64) -> Vec<Line> {
    let map_from_grid = pose2(map.origin[0], map.origin[1], map.origin[2]);
    let mut lines = Vec::new();
    for mut chain in (Contours { map }).chains() {
        begin_at_a_corner(&mut chain);
        // Split at the sides' ends, where corners are sharp; fit the sides' middles, which lie evenly about a slanted
        // wall.
        let mut ends: Vec<Point> = chain.iter().map(|side| side.middle() - side.half()).collect();
        ends.extend(chain.last().map(|side| side.middle() + side.half()));
        let middles: Vec<Point> = chain.iter().map(|side| side.middle()).collect();
        for (first, last) in straight_pieces(&ends) {
            if (ends[last] - ends[first]).norm() * map.resolution_m >= min_line_m - 1e-9 {
                let corners = [ends[first], ends[last]];
                lines.push(fit(&middles[first..last], corners, map.resolution_m, &map_from_grid));
            }
        }
    }
    lines
}

/// A closed contour may begin in the middle of a wall; its farthest point from the middle is a corner.
fn begin_at_a_corner(chain: &mut [Side]) {
    let (Some(first), Some(last)) = (chain.first(), chain.last()) else { return };
    let gap = (last.middle() + last.half()) - (first.middle() - first.half());
    if gap.norm() > 0.5 {
        return;
    }
    let sum = chain.iter().fold(Vector2::zeros(), |sum, side| sum + side.middle().coords);
    let center = Point::from(sum / chain.len() as f64);
    let far = |side: &Side| (side.middle() - side.half() - center).norm_squared();
    let corner = (0..chain.len()).max_by(|a, b| far(&chain[*a]).total_cmp(&far(&chain[*b])));
    chain.rotate_left(corner.unwrap_or(0));
}

/// First and last point of each straight piece.
fn straight_pieces(points: &[Point]) -> Vec<(usize, usize)> {
    let mut pieces = Vec::new();
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        let chord = points[last] - points[first];
        let length = chord.norm();
        let stray = |point: &Point| {
            let offset = point - points[first];
            if length < 1e-9 {
                offset.norm()
            } else {
                (chord.x * offset.y - chord.y * offset.x).abs() / length
            }
        };
        let strays = points[first..=last].iter().map(stray).enumerate();
        match strays.max_by(|a, b| a.1.total_cmp(&b.1)) {
            Some((farthest, stray)) if stray > TOLERANCE_CELLS => {
                open.extend([(first, first + farthest), (first + farthest, last)]);
            }
            _ => pieces.push((first, last)),
        }
    }
    pieces
}

/// The line through a piece of contour, from the foot of its first corner to that of its last.
fn fit(points: &[Point], ends: [Point; 2], resolution_m: f64, map_from_grid: &Pose2) -> Line {
    let n = points.len() as f64;
    let center = Point::from(points.iter().fold(Vector2::zeros(), |sum, point| sum + point.coords) / n);
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for offset in points.iter().map(|point| point - center) {
        xx += offset.x * offset.x;
        xy += offset.x * offset.y;
        yy += offset.y * offset.y;
    }
    let angle_rad = 0.5 * (2.0 * xy).atan2(xx - yy);
    let along = Vector2::new(angle_rad.cos(), angle_rad.sin());
    let foot = |end: Point| map_from_grid * ((center + along * (end - center).dot(&along)) * resolution_m);
    let [from, to] = ends.map(foot);
    // Slope and offset of a regression line with equally spaced points, moved from the middle to the map's origin.
    let way = to - from;
    let length_m = way.norm();
    let variance = CELL_VARIANCE * resolution_m * resolution_m / n;
    let angle_variance = 12.0 * variance / (length_m * length_m).max(1e-12);
    // The normal points to the left, into the wall; when it turns, the middle moves along it by this much.
    let middle = nalgebra::center(&from, &to);
    let sideways_m = -middle.coords.dot(&way) / length_m.max(1e-12);
    let covariance =
        [variance + sideways_m * sideways_m * angle_variance, sideways_m * angle_variance, angle_variance];
    Line { from: from.into(), to: to.into(), covariance }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn picture(lines: &[&str]) -> MapImage {
        let (width, height) = (lines[0].len(), lines.len());
        let cell = |byte: u8| match byte {
            b'#' => 100,
            b'?' => -1,
            _ => 0,
        };
        let cells = lines.iter().rev().flat_map(|line| line.bytes().map(cell)).collect();
        MapImage { width, height, resolution_m: 0.1, origin: [1.0, 2.0, 0.0], cells }
    }

    fn sorted(lines: &[Line]) -> Vec<[i64; 4]> {
        let hundredths = |value: f64| (value * 100.0).round() as i64;
        let mut ends: Vec<[i64; 4]> =
            lines.iter().map(|l| [l.from[0], l.from[1], l.to[0], l.to[1]].map(hundredths)).collect();
        ends.sort_unstable();
        ends
    }

    #[test]
    fn a_room_gives_its_four_walls_exactly() {
        let map = picture(&["##########", "#........#", "#........#", "#........#", "##########"]);
        // Inner faces: x from 1.1 to 1.9, y from 2.1 to 2.4; only they face free cells.
        // The wall is to the left of each line.
        let expected =
            [[110, 210, 110, 240], [110, 240, 190, 240], [190, 210, 110, 210], [190, 240, 190, 210]];
        assert_eq!(sorted(&wall_lines(&map, 0.2)), expected);
        assert_eq!(wall_lines(&map, 0.5).len(), 2, "short walls are left out");
    }

    #[test]
    fn a_pillar_is_walked_around_and_unknown_cells_end_a_wall() {
        let map = picture(&["........", "..####..", "..####..", "..####..", "..####..", "........"]);
        assert_eq!(wall_lines(&map, 0.3).len(), 4);
        let map = picture(&["????????", "########", "....????"]);
        assert_eq!(sorted(&wall_lines(&map, 0.3)), [[100, 210, 140, 210]]);
    }

    #[test]
    fn a_slanted_wall_is_one_line_in_spite_of_its_stairs() {
        let n = 60;
        let mut map =
            MapImage { width: n, height: n, resolution_m: 0.05, origin: [0.0; 3], cells: vec![0; n * n] };
        for cell in 0..n * n {
            let (col, row) = (cell % n, cell / n);
            if (row as f64 + 0.5) < 10.0 + 0.3 * (col as f64 + 0.5) {
                map.cells[cell] = 100;
            }
        }
        let lines = wall_lines(&map, 0.5);
        assert_eq!(lines.len(), 1, "{lines:?}");
        let Line { from, to, .. } = lines[0];
        let slope = (to[1] - from[1]) / (to[0] - from[0]);
        assert!((slope - 0.3).abs() < 0.01, "{slope}");
        assert!((from[1] - (0.5 + 0.3 * from[0])).abs() < 0.03 && (to[0] - from[0]).abs() > 2.9);
    }

    #[test]
    fn lines_lie_in_the_frame_of_a_turned_map() {
        let mut map = picture(&["........", "########", "########"]);
        map.origin = [1.0, 2.0, std::f64::consts::FRAC_PI_2];
        // The upper face, y = 0.2 of the grid, is x = 1 - 0.2 of the map.
        assert_eq!(sorted(&wall_lines(&map, 0.3)), [[80, 280, 80, 200]]);
    }

    #[test]
    fn the_covariance_is_that_of_a_wall_that_turns_about_its_middle() {
        // Two faces of one wall, far from the origin: normals up and down.
        let mut map = picture(&["........", "########", "########", "........"]);
        map.origin = [10.0, 20.0, 0.0];
        let lines = wall_lines(&map, 0.3);
        assert_eq!(lines.len(), 2);
        for Line { from, to, covariance: [distance2, both, angle2] } in lines {
            // x of the middle is 10.4. A normal (0, s) that turns by a little angle becomes (-s angle, s), and the distance of
            // the middle along it changes by -s 10.4 angle. The wall lies to the left of the way.
            let s = if to[0] > from[0] { 1.0 } else { -1.0 };
            assert!((both - -s * 10.4 * angle2).abs() < 1e-9, "{from:?} {to:?} {both}");
            assert!((distance2 - 10.4 * 10.4 * angle2 - CELL_VARIANCE * 0.01 / 8.0).abs() < 1e-12);
        }
    }

    #[test]
    fn an_empty_map_has_no_lines() {
        assert!(wall_lines(&picture(&["....", "...."]), 0.1).is_empty());
        assert!(wall_lines(&picture(&["####", "####"]), 0.1).is_empty());
    }
}
