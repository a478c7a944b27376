//! Which point of the path draws the robot.

use rumbo_core::frames::Point2;
use rumbo_core::messages::Path;

/// How far along its path the robot is.
#[derive(Debug, Clone, Copy, Default)]
pub struct Progressing {
    passed: usize,
}

/// Where to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aim {
    /// The point of the path that draws the robot, in the map.
    pub target: Point2,
    /// Way to the end of the path through this point, meters.
    pub left_m: f64,
}

impl Progressing {
    /// Goes on to the first point of the path that is farther than `passed_within_m`, or its last.
    pub fn aim(&mut self, path: &Path, position: Point2, passed_within_m: f64) -> Aim {
        let points = path.points();
        let last = points.len() - 1;
        let near = points
            .iter()
            .take(last)
            .skip(self.passed)
            .take_while(|point| (point.position - position).norm() < passed_within_m);
        self.passed += near.count();
        let target = points.get(self.passed).map_or(path.end().position, |point| point.position);
        let onward = points.iter().skip(self.passed);
        let beyond_m: f64 =
            onward.clone().zip(onward.skip(1)).map(|(from, to)| (to.position - from.position).norm()).sum();
        Aim { target, left_m: (target - position).norm() + beyond_m }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_passed_within_the_radius_and_the_last_one_stays() {
        let path = Path::through([(0.0, 0.0), (1.0, 0.0), (1.0, 2.0)].map(|(x, y)| Point2::new(x, y)), 0.0);
        let (path, mut progress) = (path.unwrap(), Progressing::default());
        let at = |progress: &mut Progressing, x: f64, y: f64| progress.aim(&path, Point2::new(x, y), 0.7);
        assert_eq!(at(&mut progress, 0.0, 0.0), Aim { target: Point2::new(1.0, 0.0), left_m: 3.0 });
        assert_eq!(at(&mut progress, 0.4, 0.0).target, Point2::new(1.0, 2.0));
        // What is passed stays passed.
        assert_eq!(at(&mut progress, 0.0, 0.0).target, Point2::new(1.0, 2.0));
        assert_eq!(at(&mut progress, 1.0, 2.0), Aim { target: Point2::new(1.0, 2.0), left_m: 0.0 });
    }
}
