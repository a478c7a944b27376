//! A straight piece on its way, and where the robot is along it.

use super::lane::Lane;
use rumbo_core::frames::{Point2, wrap_angle};

/// A straight piece on its way.
#[derive(Debug, Clone, Copy)]
pub(super) struct Straight {
    /// Where the robot set out.
    pub from: Point2,
    /// Direction of the piece.
    pub heading_rad: f64,
    /// From there to the checkpoint.
    pub length_m: f64,
    /// The checkpoint was within its radius at some time: noise of the estimate must not undo this.
    pub touched: bool,
    /// Calls in a row that saw the robot off its course.
    pub n_off_course: u32,
    /// Way left to the checkpoint at the last call.
    pub left_m: f64,
    /// Beside the line, to the left, at the last call.
    pub lateral_m: f64,
    /// What stands beside the robot.
    pub lane: Lane,
    /// Offset to the left of the line that gives way to it.
    pub aside_m: f64,
}

/// Where a point is along a straight piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Way left to the checkpoint; negative beyond it.
    pub left_m: f64,
    /// Beside the line, to the left.
    pub lateral_m: f64,
}

impl Straight {
    pub fn between(from: Point2, to: Point2) -> Straight {
        let piece = to - from;
        let (heading_rad, length_m) = (piece.y.atan2(piece.x), piece.norm());
        Straight {
            from,
            heading_rad,
            length_m,
            touched: false,
            n_off_course: 0,
            left_m: length_m,
            lateral_m: 0.0,
            lane: Lane::FREE,
            aside_m: 0.0,
        }
    }

    pub fn place_of(&self, position: Point2) -> Place {
        let (sin, cos) = self.heading_rad.sin_cos();
        let done = position - self.from;
        Place {
            left_m: self.length_m - (done.x * cos + done.y * sin),
            lateral_m: done.y * cos - done.x * sin,
        }
    }

    /// From the robot's heading to the one that meets the line, or what is aside of it, `aim_m` ahead.
    pub fn heading_error_rad(&self, aside_m: f64, aim_m: f64, yaw_rad: f64) -> f64 {
        let off_m = self.lateral_m - aside_m;
        wrap_angle(self.heading_rad - (off_m / aim_m).atan() - yaw_rad)
    }
}
