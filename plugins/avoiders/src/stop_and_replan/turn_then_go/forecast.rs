//! Where the robot will be if nothing stops it.

use super::{Phase, TurnThenGo};
use crate::stop_and_replan::straight::Straight;
use rumbo_core::frames::{Point2, wrap_angle};

impl TurnThenGo {
    /// From the end of a movement to the beginning of the next, seconds.
    const PAUSE_S: f64 = 0.4;
    /// Less than this is left of a piece that is at its end, meters.
    const END_M: f64 = 0.01;

    /// The places after each `step_s` from here, with speeds that are `part` of the usual ones.
    pub fn forecast(
        &self,
        (position, yaw_rad): (Point2, f64),
        step_s: f64,
        n_steps: usize,
        part: f64,
        places: &mut Vec<Point2>,
    ) {
        places.clear();
        let mut ahead = Ahead { at: position, yaw_rad, busy_s: 0.0, piece: None, target: self.target };
        match self.phase {
            Phase::Arrived => return,
            Phase::Stopping { .. } => ahead.busy_s = Self::PAUSE_S,
            Phase::Turning { heading_rad, left_rad, .. } => {
                ahead.yaw_rad = heading_rad;
                ahead.busy_s = Self::PAUSE_S + left_rad.abs() / self.tuning.turn.levels[2];
            }
            Phase::Driving(straight) => ahead.piece = Some(straight),
        }
        for _ in 0..n_steps {
            self.advance(&mut ahead, step_s, part);
            places.push(ahead.at);
        }
    }

    fn advance(&self, ahead: &mut Ahead, step_s: f64, part: f64) {
        if ahead.busy_s >= step_s {
            ahead.busy_s -= step_s;
            return;
        }
        let free_s = step_s - ahead.busy_s;
        ahead.busy_s = 0.0;
        let Some(piece) = &mut ahead.piece else {
            let Some(corner) = self.corners.get(ahead.target) else { return };
            let piece = Straight::between(ahead.at, *corner);
            let turn_rad = wrap_angle(piece.heading_rad - ahead.yaw_rad).abs();
            if turn_rad > self.tuning.heading_tolerance_rad {
                ahead.busy_s = Self::PAUSE_S + turn_rad / self.tuning.turn.levels[2];
            }
            ahead.yaw_rad = piece.heading_rad;
            ahead.piece = Some(piece);
            return;
        };
        let way_m = (part * self.tuning.speed(piece.left_m, piece.length_m) * free_s).min(piece.left_m);
        let (sin, cos) = piece.heading_rad.sin_cos();
        ahead.at += nalgebra::Vector2::new(cos, sin) * way_m;
        piece.left_m -= way_m;
        if piece.left_m <= Self::END_M {
            (ahead.piece, ahead.target) = (None, ahead.target + 1);
        }
    }
}

/// The robot some time ahead.
struct Ahead {
    at: Point2,
    yaw_rad: f64,
    /// It turns or stops for so long.
    busy_s: f64,
    piece: Option<Straight>,
    target: usize,
}
