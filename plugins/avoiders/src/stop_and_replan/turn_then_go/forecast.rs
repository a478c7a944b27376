//! Where the robot will be if nothing stops it.

use super::{Phase, TurnThenGo};
use crate::stop_and_replan::straight::Straight;
use rumbo_core::frames::{Point2, wrap_angle};

/// The robot some time ahead.
struct Ahead {
    at: Point2,
    yaw_rad: f64,
    /// It stands between two movements for so long.
    pause_s: f64,
    /// What is left of a turn, and all of it, radians.
    turn: Option<[f64; 2]>,
    piece: Option<Straight>,
    target: usize,
}

impl TurnThenGo {
    /// From the end of a movement to the beginning of the next, seconds.
    const PAUSE_S: f64 = 0.3;
    /// Less than this is left of a movement that is at its end, meters and radians.
    const END: f64 = 0.005;

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
        let target = self.target;
        let mut ahead = Ahead { at: position, yaw_rad, pause_s: 0.0, turn: None, piece: None, target };
        match self.phase {
            Phase::Arrived => return,
            Phase::Stopping { .. } => ahead.pause_s = Self::PAUSE_S,
            Phase::Turning { heading_rad, left_rad, length_rad, .. } => {
                ahead.yaw_rad = heading_rad;
                ahead.turn = Some([left_rad.abs(), length_rad]);
            }
            Phase::Driving(straight) => ahead.piece = Some(straight),
        }
        for _ in 0..n_steps {
            self.advance(&mut ahead, step_s, part);
            places.push(ahead.at);
        }
    }

    /// One step of one movement; what is left of it when the movement ends is lost, as in every period of the control.
    fn advance(&self, ahead: &mut Ahead, step_s: f64, part: f64) {
        if ahead.pause_s > 0.0 {
            ahead.pause_s -= step_s;
        } else if let Some([left_rad, length_rad]) = ahead.turn {
            let left_rad = left_rad - self.tuning.turn_rate(left_rad, length_rad) * step_s;
            let is_over = left_rad <= Self::END;
            ahead.turn = (!is_over).then_some([left_rad, length_rad]);
            ahead.pause_s = if is_over { Self::PAUSE_S } else { 0.0 };
        } else if let Some(piece) = &mut ahead.piece {
            let way_m = (part * self.tuning.speed(piece.left_m, piece.length_m) * step_s).min(piece.left_m);
            let (sin, cos) = piece.heading_rad.sin_cos();
            ahead.at += nalgebra::Vector2::new(cos, sin) * way_m;
            piece.left_m -= way_m;
            if piece.left_m <= Self::END {
                (ahead.piece, ahead.target, ahead.pause_s) = (None, ahead.target + 1, Self::PAUSE_S);
            }
        } else if let Some(corner) = self.corners.get(ahead.target) {
            let piece = Straight::between(ahead.at, *corner);
            let turn_rad = wrap_angle(piece.heading_rad - ahead.yaw_rad).abs();
            let is_turn = turn_rad > self.tuning.heading_tolerance_rad;
            ahead.turn = is_turn.then_some([turn_rad, turn_rad]);
            ahead.yaw_rad = piece.heading_rad;
            ahead.piece = Some(piece);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::stop_and_replan::StopAndReplanParams;
    use crate::stop_and_replan::turn_then_go::{Motion, TurnThenGo};
    use rumbo_core::frames::{Point2, Pose2, Twist, pose2};
    use rumbo_core::messages::Path;
    use rumbo_core::robot::Robot;
    use rumbo_core::time::Time;

    const PERIOD_S: f64 = 0.1;
    const STEP_S: f64 = 0.2;
    const N_STEPS: usize = 20;

    /// Where it is on the way, against where it comes to.
    #[test]
    fn the_forecast_is_where_the_robot_comes_to() {
        let corners = [(0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.3, 1.8)].map(|(x, y)| Point2::new(x, y));
        let path = Path::through(corners, 0.0).unwrap();
        let tuning = StopAndReplanParams::default().tuning(&Robot::default(), PERIOD_S);
        let mut control = TurnThenGo::new(tuning);
        let mut pose: Pose2 = pose2(0.0, 0.0, 0.6);
        control.follow(Time::ZERO, &path, &pose, 0.02);
        let mut twist = Twist::ZERO;
        let (mut trail, mut forecasts) = (Vec::new(), Vec::new());
        for k in 0..1200 {
            let position = Point2::from(pose.translation.vector);
            trail.push(position);
            let now = Time::from_secs(PERIOD_S * f64::from(k));
            twist = match control.steer(now, &pose, twist, 0.1) {
                Motion::Arrived => break,
                Motion::Stand => Twist::ZERO,
                Motion::Turn(rate) => Twist::new(0.0, rate),
                Motion::Ahead { twist, .. } => twist,
            };
            let mut places = Vec::new();
            control.forecast((position, pose.rotation.angle()), STEP_S, N_STEPS, 1.0, &mut places);
            forecasts.push(places);
            pose *= twist.integrate(PERIOD_S);
        }
        assert!(trail.len() < 1200, "arrives");
        let each = (STEP_S / PERIOD_S) as usize;
        let mut off_m = Vec::new();
        for (k, places) in forecasts.iter().enumerate() {
            for (step, place) in places.iter().enumerate() {
                let then = (k + (step + 1) * each).min(trail.len() - 1);
                off_m.push((place - trail[then]).norm());
            }
        }
        let mean_m = off_m.iter().sum::<f64>() / off_m.len() as f64;
        let worst_m = off_m.iter().copied().fold(0.0, f64::max);
        assert!(mean_m < 0.03 && worst_m < 0.2, "mean {mean_m}, worst {worst_m}");
    }
}
