//! The way along the path: how far the robot is, and the point ahead that it goes for.

use rumbo_core::frames::Point2;
use rumbo_core::messages::Path;

/// A path with the robot's place on it.
#[derive(Debug, Default)]
pub struct Route {
    points: Vec<Point2>,
    /// Piece on which the robot was last, and how much of it lay behind, from 0 to 1.
    piece: usize,
    along: f64,
}

/// Where the robot is on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ahead {
    /// The point to go for.
    pub target: Point2,
    /// From the robot along the path to its end, meters.
    pub left_m: f64,
}

/// How much of the path beyond the robot's last place is searched for the nearest point, meters: a path that comes back
/// to the same place must not be cut short.
const SEARCHED_M: f64 = 2.0;

impl Route {
    /// Takes a new path.
    pub fn follow(&mut self, path: &Path) {
        self.points.clear();
        self.points.extend(path.points().iter().map(|point| point.position));
        (self.piece, self.along) = (0, 0.0);
    }

    /// The point `look_ahead_m` along the path from the place nearest to the robot.
    pub fn ahead(&mut self, robot: Point2, look_ahead_m: f64) -> Ahead {
        let mut nearest = (f64::INFINITY, self.piece, self.along);
        let behind_m =
            self.pieces().nth(self.piece).map_or(0.0, |(_, (from, to))| (to - from).norm() * self.along);
        let mut walked_m = -behind_m;
        for (idx, (from, to)) in self.pieces().skip(self.piece) {
            let (along, distance_m) = project(robot, from, to);
            // At a corner both pieces are as near: the later one leads on.
            if distance_m <= nearest.0 {
                nearest = (distance_m, idx, along);
            }
            walked_m += (to - from).norm();
            if walked_m > SEARCHED_M {
                break;
            }
        }
        let (_, piece, along) = nearest;
        (self.piece, self.along) = (piece, along);
        let end = self.points.last().copied().unwrap_or(robot);
        let (mut target, mut left_m) = (None, 0.0);
        for (idx, (from, to)) in self.pieces().skip(piece) {
            let length_m = (to - from).norm();
            let begins_m = if idx == piece { along * length_m } else { 0.0 };
            let until_m = begins_m + look_ahead_m - left_m;
            if target.is_none() && until_m <= length_m {
                target = Some(from + (to - from) * (until_m / length_m.max(1e-9)).min(1.0));
            }
            left_m += length_m - begins_m;
        }
        // Beside the end of the path the straight way counts.
        Ahead { target: target.unwrap_or(end), left_m: left_m.max((end - robot).norm()) }
    }

    fn pieces(&self) -> impl Iterator<Item = (usize, (Point2, Point2))> {
        self.points.iter().copied().zip(self.points.iter().copied().skip(1)).enumerate()
    }
}

/// Share of the piece, from 0 to 1, at which it is nearest, and how far that is.
fn project(point: Point2, from: Point2, to: Point2) -> (f64, f64) {
    let (piece, to_point) = (to - from, point - from);
    let along = (to_point.dot(&piece) / piece.norm_squared().max(1e-18)).clamp(0.0, 1.0);
    (along, (to_point - piece * along).norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(points: &[(f64, f64)]) -> Route {
        let mut route = Route::default();
        let path = Path::through(points.iter().map(|(x, y)| Point2::new(*x, *y)), 0.0).unwrap();
        route.follow(&path);
        route
    }

    #[test]
    fn the_point_ahead_goes_around_corners_and_ends_at_the_end() {
        let mut route = route(&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)]);
        let at = route.ahead(Point2::new(0.7, 0.1), 0.5);
        assert!((at.target - Point2::new(1.0, 0.2)).norm() < 1e-12, "{at:?}");
        assert!((at.left_m - 1.3).abs() < 1e-12);
        let at = route.ahead(Point2::new(1.0, 0.8), 0.5);
        assert!((at.target - Point2::new(1.0, 1.0)).norm() < 1e-12 && (at.left_m - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_long_piece_is_left_at_its_end() {
        let mut route = route(&[(0.0, 0.0), (4.0, 0.0), (4.0, 3.0)]);
        for k in 0..40 {
            route.ahead(Point2::new(0.1 * f64::from(k), 0.0), 0.5);
        }
        let at = route.ahead(Point2::new(4.0, 0.6), 0.5);
        assert!((at.target - Point2::new(4.0, 1.1)).norm() < 1e-12, "{at:?}");
    }

    #[test]
    fn a_path_that_comes_back_is_not_cut_short() {
        let mut route = route(&[(0.0, 0.0), (5.0, 0.0), (5.0, 0.2), (0.0, 0.2)]);
        let at = route.ahead(Point2::new(1.0, 0.15), 0.5);
        assert!((at.target - Point2::new(1.5, 0.0)).norm() < 1e-12, "{at:?}");
    }

    #[test]
    fn a_path_of_one_point_is_a_place_to_go_to() {
        let at = route(&[(2.0, 0.0)]).ahead(Point2::origin(), 0.5);
        assert_eq!(at, Ahead { target: Point2::new(2.0, 0.0), left_m: 2.0 });
    }
}
