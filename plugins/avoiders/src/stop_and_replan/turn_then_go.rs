//! Turn-then-go control: stop, turn in place to the next checkpoint, drive straight, stop at every checkpoint, and at
//! the last one turn to the wanted heading (Hernández Alamilla 2005, section 6.1, equations 6.1 and 6.2).
//!
//! Progress is measured on the robot's estimated pose, so an estimate that moves does no harm: a movement ends where
//! the estimate says, and is repeated from there when it missed.

mod forecast;

use super::checkpoints::{first_target, keep_corners};
use super::lane::Lane;
use super::straight::{Place, Straight};
use super::tuning::Tuning;
use rumbo_core::frames::{Point2, Pose2, Twist, wrap_angle};
use rumbo_core::messages::Path;
use rumbo_core::time::{Span, Time};
use std::f64::consts::{PI, TAU};

/// What the wheels shall do until the next call.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Stand.
    Stand,
    /// Turn in place at this rate, rad/s.
    Turn(f64),
    /// Drive ahead, with a slight correction of the heading.
    Ahead {
        /// The velocity.
        twist: Twist,
        /// Way left to the checkpoint, meters.
        left_m: f64,
    },
    /// The path's end is reached.
    Arrived,
}

#[derive(Debug, Clone, Copy)]
enum Phase {
    /// Coming to a stop before the next movement.
    Stopping {
        since: Time,
    },
    /// `left_rad` keeps counting through the half turn; `side` is 1 for counter-clockwise, -1 for clockwise.
    Turning {
        heading_rad: f64,
        left_rad: f64,
        side: f64,
        length_rad: f64,
    },
    Driving(Straight),
    Arrived,
}

/// The controller with the path that it follows.
#[derive(Debug)]
pub struct TurnThenGo {
    tuning: Tuning,
    corners: Vec<Point2>,
    target: usize,
    final_heading_rad: Option<f64>,
    /// The end of the path was reached; only the final heading is left.
    at_end: bool,
    /// Turns made for one movement: each widens the tolerance, so that a noisy estimate cannot make it endless.
    n_turns: u32,
    phase: Phase,
    /// A straight piece that goes on after a turn away from what stands beside the robot.
    resumed: Option<Straight>,
}

/// The smaller of both turns, clockwise where they are equal (equation 6.1).
pub fn smaller_turn(from_rad: f64, to_rad: f64) -> f64 {
    let turn = wrap_angle(to_rad - from_rad);
    // Half turns that rounding put on the other side.
    if turn > PI - 1e-9 { turn - TAU } else { turn }
}

impl TurnThenGo {
    /// So many calls in a row must see the robot off its course: one may be noise.
    const OFF_COURSE_CALLS: u32 = 3;
    /// A stop that takes longer is taken for done: the odometer may see motion that is none.
    const STOP_LIMIT: Span = Span(1_000_000_000);
    /// Slower than this is standing, m/s.
    const STANDING_M_S: f64 = 0.01;
    /// Slower than this is standing, rad/s.
    const STANDING_RAD_S: f64 = 0.02;
    /// Part of a new offset that is taken up in one call: noise of the scanner shall not shake the robot.
    const ASIDE_GAIN: f64 = 0.3;

    /// A controller without a path.
    pub fn new(tuning: Tuning) -> TurnThenGo {
        let phase = Phase::Arrived;
        let corners = Vec::with_capacity(256);
        TurnThenGo {
            tuning,
            corners,
            target: 0,
            final_heading_rad: None,
            at_end: false,
            n_turns: 0,
            phase,
            resumed: None,
        }
    }

    /// Takes on a new path, of which points within `merge_within_m` of a straight piece are no checkpoints. A robot that
    /// drives towards its first checkpoint already does not stop for it.
    pub fn follow(&mut self, now: Time, path: &Path, map_from_base: &Pose2, merge_within_m: f64) {
        keep_corners(path.points(), merge_within_m, &mut self.corners);
        let position = Point2::from(map_from_base.translation.vector);
        self.target = first_target(&self.corners, position, self.tuning.max_lateral_error_m);
        self.final_heading_rad = path.end().yaw_rad;
        self.at_end = false;
        self.n_turns = 0;
        self.resumed = None;
        self.phase = match self.phase {
            Phase::Driving(straight) => self.continued(&straight).map(Phase::Driving),
            _ => None,
        }
        .unwrap_or(Phase::Stopping { since: now });
    }

    /// The present straight piece with the new checkpoint at its end, where that lies in the same direction.
    fn continued(&self, straight: &Straight) -> Option<Straight> {
        let renewed = Straight::between(straight.from, self.checkpoint()?);
        let bend_rad = wrap_angle(renewed.heading_rad - straight.heading_rad);
        let fits = bend_rad.abs() <= self.tuning.heading_tolerance_rad;
        fits.then_some(Straight { aside_m: straight.aside_m, ..renewed })
    }

    /// Way done of the straight piece that the robot drives on: so far back it came, meters.
    pub fn done_m(&self) -> f64 {
        if let Phase::Driving(straight) = self.phase { straight.length_m - straight.left_m } else { 0.0 }
    }

    /// Way left to the checkpoint, while the robot drives there.
    pub fn left_m(&self) -> Option<f64> {
        if let Phase::Driving(straight) = self.phase { Some(straight.left_m) } else { None }
    }

    /// Gives way to what stands beside a robot that drives.
    pub fn give_way(&mut self, lane: Lane) {
        if let Phase::Driving(straight) = &mut self.phase {
            straight.lane = lane;
        }
    }

    /// The checkpoint that the robot goes to.
    pub fn checkpoint(&self) -> Option<Point2> {
        self.corners.get(self.target).copied()
    }

    /// A robot that is held beside a wall turns in place to where it must steer to give way, and then drives on. Returns
    /// whether that is a turn at all.
    pub fn turn_away(&mut self, yaw_rad: f64) -> bool {
        let Phase::Driving(mut straight) = self.phase else { return false };
        straight.aside_m = self.tuning.wanted_aside_m(&straight);
        let aim_m = self.tuning.aim_m(self.tuning.straight.levels[0], straight.left_m);
        let left_rad = straight.heading_error_rad(straight.aside_m, aim_m, yaw_rad);
        if self.tuning.heading_gain_per_s <= 0.0 || left_rad.abs() <= self.tuning.heading_tolerance_rad {
            return false;
        }
        let (side, length_rad) = (left_rad.signum(), left_rad.abs());
        self.phase = Phase::Turning { heading_rad: yaw_rad + left_rad, left_rad, side, length_rad };
        self.resumed = Some(straight);
        true
    }

    /// What to do until the next call.
    pub fn steer(&mut self, now: Time, map_from_base: &Pose2, twist: Twist, arrival_radius_m: f64) -> Motion {
        let position = Point2::from(map_from_base.translation.vector);
        let yaw_rad = map_from_base.rotation.angle();
        if let Phase::Stopping { since } = self.phase {
            let moves =
                twist.speed_m_s() > Self::STANDING_M_S || twist.turn_rad_s.abs() > Self::STANDING_RAD_S;
            if moves && now - since < Self::STOP_LIMIT {
                return Motion::Stand;
            }
            self.phase = self.next_movement(position, yaw_rad, arrival_radius_m);
        }
        match self.phase {
            Phase::Stopping { .. } => Motion::Stand,
            Phase::Arrived => Motion::Arrived,
            Phase::Turning { heading_rad, left_rad, side, length_rad } => {
                let left_rad = left_rad + wrap_angle(smaller_turn(yaw_rad, heading_rad) - left_rad);
                self.turn(now, heading_rad, left_rad, (side, length_rad))
            }
            Phase::Driving(straight) => self.drive(now, straight, position, yaw_rad, arrival_radius_m),
        }
    }

    /// Distance at which the present checkpoint counts as reached.
    fn radius_m(&self, arrival_radius_m: f64) -> f64 {
        if self.target + 1 >= self.corners.len() { arrival_radius_m } else { self.tuning.checkpoint_radius_m }
    }

    fn next_movement(&mut self, position: Point2, yaw_rad: f64, arrival_radius_m: f64) -> Phase {
        if let Some(straight) = self.resumed.take() {
            return Phase::Driving(straight);
        }
        while !self.at_end {
            let Some(checkpoint) = self.checkpoint() else { return Phase::Arrived };
            let straight = Straight::between(position, checkpoint);
            if straight.length_m > self.radius_m(arrival_radius_m) {
                return self.turn_to(yaw_rad, straight.heading_rad).unwrap_or(Phase::Driving(straight));
            }
            self.reached();
        }
        self.final_heading_rad.and_then(|heading| self.turn_to(yaw_rad, heading)).unwrap_or(Phase::Arrived)
    }

    /// On to the next checkpoint.
    fn reached(&mut self) {
        self.n_turns = 0;
        if self.target + 1 >= self.corners.len() {
            self.at_end = true;
        } else {
            self.target += 1;
        }
    }

    /// The turn to a heading; none where the robot has it already.
    fn turn_to(&mut self, yaw_rad: f64, heading_rad: f64) -> Option<Phase> {
        let left_rad = smaller_turn(yaw_rad, heading_rad);
        let widened_rad = self.tuning.heading_tolerance_rad * f64::from(1 + self.n_turns);
        let most_rad = self.tuning.max_heading_error_rad.max(self.tuning.heading_tolerance_rad);
        if left_rad.abs() <= widened_rad.min(most_rad) {
            self.n_turns = 0;
            return None;
        }
        self.n_turns += 1;
        let (side, length_rad) = (left_rad.signum(), left_rad.abs());
        Some(Phase::Turning { heading_rad, left_rad, side, length_rad })
    }

    fn turn(&mut self, now: Time, heading_rad: f64, left_rad: f64, (side, length_rad): (f64, f64)) -> Motion {
        let t = &self.tuning;
        let to_go_rad = left_rad * side;
        if to_go_rad <= t.turn.levels[0] * t.period_s / 4.0 {
            self.phase = Phase::Stopping { since: now };
            return Motion::Stand;
        }
        let rate = t.turn_rate(to_go_rad, length_rad);
        self.phase = Phase::Turning { heading_rad, left_rad, side, length_rad };
        Motion::Turn(side * rate)
    }

    fn drive(
        &mut self,
        now: Time,
        mut straight: Straight,
        position: Point2,
        yaw_rad: f64,
        arrival_radius_m: f64,
    ) -> Motion {
        let t = self.tuning;
        let Some(checkpoint) = self.checkpoint() else { return Motion::Arrived };
        let Place { left_m, lateral_m } = straight.place_of(position);
        (straight.left_m, straight.lateral_m) = (left_m, lateral_m);
        straight.aside_m += Self::ASIDE_GAIN * (self.tuning.wanted_aside_m(&straight) - straight.aside_m);
        // The end of a path is reached exactly, whatever stands beside it; on the way there is room to give.
        let is_last = self.target + 1 >= self.corners.len();
        let aside_m =
            if is_last { straight.aside_m * (left_m - 0.2).clamp(0.0, 0.3) / 0.3 } else { straight.aside_m };
        let distance_m = (checkpoint - position).norm();
        let radius_m = self.radius_m(arrival_radius_m) + if is_last { 0.0 } else { aside_m.abs() };
        straight.touched |= distance_m <= radius_m;
        if left_m <= t.straight.levels[0] * t.period_s / 4.0 {
            if distance_m <= radius_m || (straight.touched && distance_m <= 2.0 * radius_m) {
                self.reached();
            }
            self.phase = Phase::Stopping { since: now };
            return Motion::Stand;
        }
        let speed = t.speed(left_m, straight.length_m);
        let aim_m = t.aim_m(speed, left_m);
        let error_rad = straight.heading_error_rad(aside_m, aim_m, yaw_rad);
        // A heading error matters by the miss it leads to: near the checkpoint every small offset is a large angle.
        let misses = error_rad.abs() > t.max_heading_error_rad
            && aim_m * error_rad.sin().abs() > t.checkpoint_radius_m;
        let off_course = (lateral_m - aside_m).abs() > t.max_lateral_error_m || misses;
        straight.n_off_course = if off_course { straight.n_off_course + 1 } else { 0 };
        if straight.n_off_course >= Self::OFF_COURSE_CALLS {
            self.phase = Phase::Stopping { since: now };
            return Motion::Stand;
        }
        self.phase = Phase::Driving(straight);
        let most = t.turn.levels[0];
        let turn_rad_s = (t.heading_gain_per_s * error_rad).clamp(-most, most);
        Motion::Ahead { twist: Twist::new(speed, turn_rad_s), left_m }
    }
}

#[cfg(test)]
mod tests;
