//! Where a wall begins and ends, which the filter does not estimate; and walls as a layer of the map.

use super::state::{State, wrapped};
use nalgebra::Matrix2;
use rumbo_core::map::Line;

/// Ends of a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wall {
    /// Both ends in the map, meters: seen from the free side the first is to the right.
    pub ends_m: [[f64; 2]; 2],
}

/// A line of the map as axes: across it along the normal, and along it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes {
    rho: f64,
    sin: f64,
    cos: f64,
}

impl Axes {
    pub fn new([rho, phi]: [f64; 2]) -> Axes {
        let (sin, cos) = phi.sin_cos();
        Axes { rho, sin, cos }
    }

    /// Where a point is along the line, from the foot of the normal, meters.
    pub fn along_m(&self, [x, y]: [f64; 2]) -> f64 {
        y * self.cos - x * self.sin
    }

    /// How far behind the line a point is, meters.
    pub fn across_m(&self, [x, y]: [f64; 2]) -> f64 {
        x * self.cos + y * self.sin - self.rho
    }

    /// The point of the line that is so far along it.
    pub fn at(&self, along_m: f64) -> [f64; 2] {
        [self.rho * self.cos - along_m * self.sin, self.rho * self.sin + along_m * self.cos]
    }

    /// From where to where a piece goes along the line.
    pub fn extent_m(&self, ends_m: &[[f64; 2]; 2]) -> [f64; 2] {
        let [one, other] = ends_m.map(|end| self.along_m(end));
        [one.min(other), one.max(other)]
    }

    /// Free space between two pieces along the line, meters; negative where they overlap.
    pub fn gap_m(&self, one: &[[f64; 2]; 2], other: &[[f64; 2]; 2]) -> f64 {
        let ([from, to], [other_from, other_to]) = (self.extent_m(one), self.extent_m(other));
        from.max(other_from) - to.min(other_to)
    }

    /// The piece from the first to the last end of two.
    pub fn union(&self, one: &[[f64; 2]; 2], other: &[[f64; 2]; 2]) -> [[f64; 2]; 2] {
        let ([from, to], [other_from, other_to]) = (self.extent_m(one), self.extent_m(other));
        [self.at(from.min(other_from)), self.at(to.max(other_to))]
    }
}

impl Wall {
    /// Follows its line, which has moved.
    pub(super) fn follow(&mut self, axes: &Axes) {
        let [from, to] = axes.extent_m(&self.ends_m);
        self.ends_m = [axes.at(from), axes.at(to)];
    }

    /// Reaches as far as another piece of the same line.
    pub(super) fn extend(&mut self, axes: &Axes, ends_m: &[[f64; 2]; 2]) {
        self.ends_m = axes.union(&self.ends_m, ends_m);
    }

    /// The middle.
    pub(super) fn middle(&self) -> [f64; 2] {
        let [[x, y], [other_x, other_y]] = self.ends_m;
        [(x + other_x) / 2.0, (y + other_y) / 2.0]
    }
}

/// A wall of the map layer: `[rho, phi]`, its ends and its covariance. None where its ends are at one place, or a number is
/// not finite.
pub(super) fn from_layer(line: &Line) -> Option<([f64; 2], Wall, Matrix2<f64>)> {
    let ([x, y], [to_x, to_y]) = (line.from, line.to);
    let (dx, dy) = (to_x - x, to_y - y);
    let length_m = dx.hypot(dy);
    let [rho2, both, phi2] = line.covariance;
    let is_sane = length_m > 0.0 && [length_m, x, y, rho2, both, phi2].iter().all(|v| v.is_finite());
    // The wall is to the left of the way from end to end, and so the normal.
    let phi = wrapped(dx.atan2(-dy));
    let axes = Axes::new([0.0, phi]);
    let rho = axes.across_m(line.from);
    is_sane.then(|| ([rho, phi], Wall { ends_m: [line.to, line.from] }, Matrix2::new(rho2, both, both, phi2)))
}

/// Walls as lines of the map layer.
pub(super) fn to_layer(state: &State, walls: &[Wall]) -> Vec<Line> {
    let line = |(wall, Wall { ends_m: [right, left] }): (usize, &Wall)| {
        let covariance = state.between(wall, wall);
        let covariance = [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]];
        Line { from: *left, to: *right, covariance }
    };
    walls.iter().enumerate().map(line).collect()
}
