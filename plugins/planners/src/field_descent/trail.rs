//! Where the robot has been: what tells that it stands still, and which way it is heading.

use nalgebra::Vector2;
use rumbo_core::frames::Point2;

/// The places of a descent.
#[derive(Clone, Debug)]
pub(super) struct Trail {
    points: Vec<Point2>,
    /// Way from the first place to each, meters.
    done_m: Vec<f64>,
}

impl Trail {
    pub fn from(start: Point2) -> Trail {
        Trail { points: vec![start], done_m: vec![0.0] }
    }

    pub fn push(&mut self, next: Point2) {
        let length_m = self.length_m() + (next - self.last()).norm();
        self.points.push(next);
        self.done_m.push(length_m);
    }

    pub fn last(&self) -> Point2 {
        self.points.last().copied().unwrap_or_else(Point2::origin)
    }

    pub fn length_m(&self) -> f64 {
        self.done_m.last().copied().unwrap_or(0.0)
    }

    pub fn n_steps(&self) -> usize {
        self.points.len() - 1
    }

    pub fn into_points(self) -> Vec<Point2> {
        self.points
    }

    /// From the place `n_steps` ago, or the first one, to the last one; and the way between them, meters.
    pub fn since(&self, n_steps: usize) -> (Vector2<f64>, f64) {
        let at = self.n_steps().saturating_sub(n_steps);
        let then = self.points.get(at).copied().unwrap_or_else(|| self.last());
        (self.last() - then, self.length_m() - self.done_m.get(at).copied().unwrap_or(0.0))
    }

    /// Direction of the net displacement over the last steps; where that is shorter than `shortest_m`, of the last
    /// step. None before the first step. A single step says nothing: across a valley the robot zigzags.
    pub fn heading(&self, n_steps: usize, shortest_m: f64) -> Option<Vector2<f64>> {
        let (net, _) = self.since(n_steps);
        let way = if net.norm() >= shortest_m { net } else { self.since(1).0 };
        (self.n_steps() > 0 && way.norm() > 0.0).then(|| way.normalize())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_zigzag_has_the_heading_of_its_net_displacement() {
        let mut trail = Trail::from(Point2::origin());
        assert_eq!(trail.heading(50, 0.005), None);
        for k in 1..=10 {
            trail.push(Point2::new(0.002 * f64::from(k), if k % 2 == 0 { 0.0 } else { 0.02 }));
        }
        assert!((trail.heading(10, 0.005).unwrap() - Vector2::x()).norm() < 1e-12);
        // Too short to say anything: the last step.
        assert!(trail.heading(2, 0.005).unwrap().y < -0.9);
        let (net, way_m) = trail.since(4);
        assert!((net.norm() - 0.008).abs() < 1e-12 && way_m > 0.08);
        assert_eq!(trail.since(99).0, Vector2::new(0.02, 0.0));
    }
}
