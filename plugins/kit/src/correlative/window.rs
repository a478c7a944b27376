//! Which poses are looked at.

use rumbo_core::frames::{Point2, Pose2, pose2, wrap_angle};
use std::f64::consts::{PI, TAU};

/// Poses around a guess: whole cells from it along the axes of the grid, and turned in equal steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchWindow {
    /// The guess: the middle of the window.
    pub grid_from_base: Pose2,
    /// Farthest along each axis, meters.
    pub reach_m: f64,
    /// Farthest turn to each side, radians; pi or more is all around.
    pub reach_rad: f64,
    /// From turn to turn, radians; see [`turn_step_rad`].
    pub step_rad: f64,
    /// Poses that fit less than this are no answer, 0 to 1.
    pub least_score: f64,
    /// After so many nodes the search gives up: what a flat map may cost.
    pub most_nodes: usize,
}

/// Leaves out poses near another one: what is the best answer elsewhere?
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// The other one.
    pub grid_from_base: Pose2,
    /// Poses nearer than this ...
    pub distance_m: f64,
    /// ... that are also turned by less than this are left out, radians.
    pub turn_rad: f64,
}

impl Apart {
    /// The pose is left out.
    pub fn excludes(&self, pose: &Pose2) -> bool {
        let off_m = (pose.translation.vector - self.grid_from_base.translation.vector).norm();
        let off_rad = wrap_angle(pose.rotation.angle() - self.grid_from_base.rotation.angle()).abs();
        off_m < self.distance_m && off_rad < self.turn_rad
    }
}

/// The turn that moves the farthest point by one cell (Hess et al. 2016, equation 7); never more than a right angle.
pub fn turn_step_rad(points: &[Point2], resolution_m: f64) -> f64 {
    let farthest_m = points.iter().map(|point| point.coords.norm()).fold(0.0, f64::max);
    if farthest_m <= resolution_m {
        return PI / 2.0;
    }
    (1.0 - 0.5 * (resolution_m / farthest_m).powi(2)).acos().min(PI / 2.0)
}

impl SearchWindow {
    /// Turns of the window, those nearest to the guess first, radians from it.
    pub(super) fn turns_rad(&self) -> Vec<f64> {
        let usable = self.step_rad > 0.0 && self.step_rad.is_finite();
        if !usable || self.reach_rad <= 0.0 {
            return vec![0.0];
        }
        let (n_each_side, n_more, step_rad) = if self.reach_rad >= PI {
            let n = (TAU / self.step_rad).ceil().max(1.0) as usize;
            ((n - 1) / 2, (n - 1) % 2, TAU / n as f64)
        } else {
            ((self.reach_rad / self.step_rad + 1e-9).floor() as usize, 0, self.step_rad)
        };
        let mut turns = vec![0.0];
        turns.extend((1..=n_each_side).flat_map(|k| [k as f64 * step_rad, -(k as f64) * step_rad]));
        turns.extend((0..n_more).map(|_| (n_each_side + 1) as f64 * step_rad));
        turns
    }

    /// Cells to each side of the guess.
    pub(super) fn reach_cells(&self, resolution_m: f64) -> i32 {
        (self.reach_m / resolution_m + 1e-9).floor().clamp(0.0, 1e6) as i32
    }

    /// The pose that many cells and that turn away.
    pub(super) fn pose(&self, cells: [i32; 2], turn_rad: f64, resolution_m: f64) -> Pose2 {
        let middle = self.grid_from_base;
        pose2(
            middle.translation.x + f64::from(cells[0]) * resolution_m,
            middle.translation.y + f64::from(cells[1]) * resolution_m,
            middle.rotation.angle() + turn_rad,
        )
    }
}
