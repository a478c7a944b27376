//! A path as a robot goes along it: how far it has come, and where a point some way ahead is.

use rumbo_core::frames::Point2;
use rumbo_core::messages::Path;

/// A polyline, and how far along it the robot is.
#[derive(Debug, Clone, Default)]
pub struct Route {
    /// Corners, each with its distance along the path, meters.
    corners: Vec<(Point2, f64)>,
    /// Distance along the path of the point that the robot is nearest to; never falls.
    come_m: f64,
    yaw_rad: Option<f64>,
}

impl Route {
    /// The nearest point of the path is looked for this far ahead of the last: a path may come near itself again, meters.
    const SEARCH_M: f64 = 2.0;

    /// Begins a path anew.
    pub fn follow(&mut self, path: &Path) {
        self.corners.clear();
        self.come_m = 0.0;
        self.yaw_rad = path.end().yaw_rad;
        let mut along_m = 0.0;
        for point in path.points() {
            if let Some((last, _)) = self.corners.last() {
                let step_m = (point.position - last).norm();
                if step_m == 0.0 {
                    continue;
                }
                along_m += step_m;
            }
            self.corners.push((point.position, along_m));
        }
    }

    /// Moves on to the point of the path nearest to the robot.
    pub fn advance(&mut self, position: Point2) {
        let (from_m, until_m) = (self.come_m, self.come_m + Self::SEARCH_M);
        let mut nearest_m = f64::INFINITY;
        for pair in self.corners.windows(2) {
            let [(a, a_m), (b, b_m)] = *pair else { continue };
            if b_m < from_m || a_m > until_m {
                continue;
            }
            let length_m = b_m - a_m;
            let along = (position - a).dot(&(b - a)) / (length_m * length_m);
            let along_m = (a_m + along * length_m).clamp(a_m.max(from_m), b_m.min(until_m));
            let distance_m = (a + (b - a) * ((along_m - a_m) / length_m) - position).norm();
            if distance_m < nearest_m {
                (nearest_m, self.come_m) = (distance_m, along_m);
            }
        }
    }

    /// The point so far ahead of the robot along the path; its end where the path is shorter.
    pub fn ahead(&self, distance_m: f64) -> Option<Point2> {
        let wanted_m = self.come_m + distance_m;
        let beyond = self.corners.iter().position(|(_, along_m)| *along_m >= wanted_m);
        let Some(idx) = beyond else { return self.end() };
        let (b, b_m) = *self.corners.get(idx)?;
        let Some((a, a_m)) = idx.checked_sub(1).and_then(|idx| self.corners.get(idx)).copied() else {
            return Some(b);
        };
        Some(a + (b - a) * ((wanted_m - a_m) / (b_m - a_m)))
    }

    /// Where it ends.
    pub fn end(&self) -> Option<Point2> {
        self.corners.last().map(|(end, _)| *end)
    }

    /// Which way the robot shall look there, radians.
    pub fn end_yaw_rad(&self) -> Option<f64> {
        self.yaw_rad
    }

    /// How far along the path the robot has come, meters.
    pub fn come_m(&self) -> f64 {
        self.come_m
    }

    /// From the nearest point to the end, along the path, meters.
    pub fn left_m(&self) -> f64 {
        self.corners.last().map_or(0.0, |(_, along_m)| along_m - self.come_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(points: &[(f64, f64)]) -> Route {
        let path = Path::through(points.iter().map(|(x, y)| Point2::new(*x, *y)), 0.0).unwrap();
        let mut route = Route::default();
        route.follow(&path);
        route
    }

    #[test]
    fn points_ahead_lie_on_the_path_around_its_corners() {
        let mut route = route(&[(0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0, 3.0)]);
        assert_eq!(route.ahead(1.0), Some(Point2::new(1.0, 0.0)));
        route.advance(Point2::new(1.5, 0.3));
        assert!((route.left_m() - 3.5).abs() < 1e-12);
        assert_eq!(route.ahead(1.0), Some(Point2::new(2.0, 0.5)));
        assert_eq!(route.ahead(100.0), Some(Point2::new(2.0, 3.0)));
        route.advance(Point2::new(0.0, 0.0));
        assert!((route.left_m() - 3.5).abs() < 1e-12, "it never goes back");
    }

    #[test]
    fn a_path_that_comes_near_itself_is_not_cut_short() {
        let mut route = route(&[(0.0, 0.0), (4.0, 0.0), (4.0, 0.4), (0.0, 0.4)]);
        route.advance(Point2::new(0.0, 0.3));
        assert!((route.left_m() - 8.4).abs() < 1e-12, "{}", route.left_m());
    }

    #[test]
    fn a_path_of_one_point_is_its_own_end() {
        let mut route = route(&[(1.0, 2.0)]);
        route.advance(Point2::new(5.0, 5.0));
        assert_eq!((route.ahead(0.5), route.left_m()), (Some(Point2::new(1.0, 2.0)), 0.0));
        assert_eq!(Route::default().ahead(1.0), None);
    }
}
