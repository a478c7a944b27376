//! Pure pursuit: the arc from the robot, along its heading, to a point of the path (Coulter 1992, *Implementation of the
//! Pure Pursuit Path Tracking Algorithm*), with speeds that curves and the end of the path allow (Macenski, Singh, Martin
//! and Gines 2023, *Regulated Pure Pursuit for Robot Path Tracking*, section III).
//!
//! Not in the sources: what a robot does that cannot turn in place and has its path behind it, or its end inside its
//! turning circles. It backs up.

use super::maneuver::Direction;
use super::route::Route;
use rumbo_core::frames::{Point2, Pose2, Twist, wrap_angle};

/// Numbers of the pursuit, meters, radians, seconds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PursuitTuning {
    /// The point pursued is this far ahead at the least and at the most.
    pub look_ahead_m: [f64; 2],
    /// And as far as the robot drives in this time.
    pub look_ahead_s: f64,
    /// Fastest speed.
    pub speed_m_s: f64,
    /// Fastest speed backwards.
    pub backing_m_s: f64,
    /// Slowest speed, but for the last centimeters.
    pub least_m_s: f64,
    /// Fastest turn.
    pub turn_rad_s: f64,
    /// Most acceleration to the side in a curve.
    pub to_the_side_m_s2: f64,
    /// Brakes.
    pub braking_m_s2: f64,
    /// Brakes of a turn.
    pub turn_braking_rad_s2: f64,
    /// Smallest radius; 0 where the robot turns in place.
    pub radius_m: f64,
    /// A robot that turns in place does so when the point pursued is farther than this from straight ahead.
    pub turn_above_rad: f64,
    /// And drives again when it is within this.
    pub turn_below_rad: f64,
    /// A heading at the end of the path is good within this.
    pub yaw_within_rad: f64,
    /// It may drive backwards.
    pub backs_up: bool,
}

/// What to do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// Stand: the path is done.
    Arrived,
    /// Turn in place.
    Turn(Twist),
    /// Drive along an arc.
    Drive(Twist),
    /// The path is behind: back up so that the robot turns to it, where there is room for so many meters of that; else back
    /// along the path.
    TurnAround {
        /// Backwards, turning.
        around: Twist,
        /// The way that needs.
        needs_m: f64,
        /// Backwards along the path.
        back: Twist,
    },
    /// This robot cannot follow this path.
    CannotFollow,
}

/// How the robot moves along its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Gait {
    #[default]
    Ahead,
    /// Turning in place to what is ahead.
    Turning,
    /// Backwards, until the path is ahead again.
    Backing,
    /// At the end, turning to its heading.
    Settling,
}

/// A robot on a path.
#[derive(Debug, Clone)]
pub struct Pursuit {
    tuning: PursuitTuning,
    route: Route,
    gait: Gait,
    /// Distance backed without coming along the path, meters; and how far it has come.
    backed_m: f64,
    come_m: f64,
    last: Option<Point2>,
}

impl Pursuit {
    /// The path counts as behind the robot beyond this from straight ahead, and as ahead below the second, radians.
    const BEHIND_RAD: f64 = 1.9;
    const AHEAD_RAD: f64 = 1.0;
    /// Room beyond the turning circles that backing up makes, share of the radius.
    const ROOM: f64 = 0.15;
    /// Whoever has backed up by more than so many radii does not get anywhere.
    const MOST_RADII: f64 = 8.0;

    /// A robot without a path.
    pub fn new(tuning: PursuitTuning) -> Pursuit {
        Pursuit { tuning, route: Route::default(), gait: Gait::Ahead, backed_m: 0.0, come_m: 0.0, last: None }
    }

    /// Begins a path.
    pub fn follow(&mut self, path: &rumbo_core::messages::Path) {
        self.route.follow(path);
        (self.gait, self.backed_m, self.come_m, self.last) = (Gait::Ahead, 0.0, 0.0, None);
    }

    /// What to do at this pose and velocity.
    pub fn steer(&mut self, map_from_base: &Pose2, twist: Twist, arrival_radius_m: f64) -> Motion {
        let position = Point2::from(map_from_base.translation.vector);
        self.route.advance(position);
        let Some(end) = self.route.end() else { return Motion::Arrived };
        let end_m = (end - position).norm();
        let passes_by = self.route.left_m() > self.tuning.look_ahead_m[0];
        if self.gait == Gait::Settling || (end_m <= arrival_radius_m && !passes_by) {
            return self.settle(map_from_base);
        }
        let Some(target) = self.target(map_from_base, twist) else { return Motion::Arrived };
        let bearing_rad = target.y.atan2(target.x);
        self.count_backing(position);
        self.choose_gait(target, bearing_rad, arrival_radius_m);
        match self.gait {
            Gait::Turning => Motion::Turn(Twist::new(0.0, self.turn_rate(bearing_rad))),
            Gait::Backing if !self.tuning.backs_up => Motion::CannotFollow,
            Gait::Backing if self.backed_m > Self::MOST_RADII * self.tuning.radius_m => Motion::CannotFollow,
            Gait::Backing => self.back_up(target, bearing_rad),
            _ => Motion::Drive(self.arc(target, self.route.left_m().max(end_m))),
        }
    }

    /// The point pursued, seen from the robot.
    fn target(&self, map_from_base: &Pose2, twist: Twist) -> Option<Point2> {
        let look_ahead_m = (twist.speed_m_s() * self.tuning.look_ahead_s)
            .clamp(self.tuning.look_ahead_m[0], self.tuning.look_ahead_m[1]);
        Some(map_from_base.inverse() * self.route.ahead(look_ahead_m)?)
    }

    /// What a robot that turns to and fro would turn to: the bearing of the point pursued, and the arc to it with the way
    /// along it that must be free, meters.
    pub fn ahead(&self, map_from_base: &Pose2, twist: Twist) -> Option<(f64, Twist, f64)> {
        let target = self.target(map_from_base, twist)?;
        let left_m = self.route.left_m().max(target.coords.norm());
        let needs_m = left_m.min(self.tuning.look_ahead_m[1]);
        Some((target.y.atan2(target.x), self.arc(target, left_m), needs_m))
    }

    /// Turning left (`tightness` above 0) or right, on the smallest circle where that is 1 or -1, straight on where it is 0.
    pub fn turning(&self, tightness: f64, direction: Direction) -> Twist {
        let curvature = tightness / self.tuning.radius_m.max(1e-9);
        match direction {
            Direction::Back => self.backwards(-curvature),
            Direction::Ahead => {
                let twist = self.backwards(curvature);
                Twist::new(-twist.forward_m_s, -twist.turn_rad_s)
            }
        }
    }

    /// It turns to and fro where it must: it cannot turn in place, and may drive backwards.
    pub fn maneuvers(&self) -> bool {
        self.tuning.radius_m > 0.0 && self.tuning.backs_up
    }

    /// Half of the smallest circle, meters.
    pub fn half_turn_m(&self) -> f64 {
        std::f64::consts::PI * self.tuning.radius_m
    }

    /// How far along its path the robot has come, meters.
    pub fn come_m(&self) -> f64 {
        self.route.come_m()
    }

    /// Goes on ahead, with the way that was backed forgotten.
    pub fn go_ahead(&mut self) {
        (self.gait, self.backed_m) = (Gait::Ahead, 0.0);
    }

    fn count_backing(&mut self, position: Point2) {
        let moved_m = self.last.replace(position).map_or(0.0, |last| (position - last).norm());
        // Along the path backwards it gets somewhere.
        let is_in_vain = self.gait == Gait::Backing && self.route.come_m() <= self.come_m;
        self.come_m = self.route.come_m();
        self.backed_m = if is_in_vain { self.backed_m + moved_m } else { 0.0 };
    }

    fn choose_gait(&mut self, target: Point2, bearing_rad: f64, arrival_radius_m: f64) {
        let (tuning, off_rad) = (&self.tuning, bearing_rad.abs());
        if tuning.radius_m <= 0.0 {
            let is_far = off_rad > tuning.turn_above_rad;
            let is_near = off_rad < tuning.turn_below_rad;
            self.gait = match self.gait {
                Gait::Turning if !is_near => Gait::Turning,
                _ if is_far => Gait::Turning,
                _ => Gait::Ahead,
            };
            return;
        }
        let inside_m =
            |radius_m: f64| radius_m - (target - Point2::new(0.0, radius_m.copysign(target.y))).norm();
        self.gait = match self.gait {
            Gait::Backing => {
                let has_room = inside_m(tuning.radius_m * (1.0 + Self::ROOM)) <= 0.0;
                if off_rad < Self::AHEAD_RAD && has_room { Gait::Ahead } else { Gait::Backing }
            }
            _ if off_rad > Self::BEHIND_RAD => Gait::Backing,
            // A point inside a turning circle is passed by, unless it is the path itself that leads around.
            _ if inside_m(tuning.radius_m) > arrival_radius_m / 2.0 && self.is_at_the_end(target) => {
                Gait::Backing
            }
            _ => Gait::Ahead,
        };
    }

    /// The point pursued is the end of the path.
    fn is_at_the_end(&self, target: Point2) -> bool {
        self.route.left_m() <= target.coords.norm()
    }

    /// Ahead along the arc that leads to a point.
    fn arc(&self, target: Point2, left_m: f64) -> Twist {
        let tuning = &self.tuning;
        let curvature = self.feasible(2.0 * target.y / target.coords.norm_squared().max(1e-6));
        let to_stop_m_s = (2.0 * tuning.braking_m_s2 * left_m).sqrt();
        let in_curve_m_s = (tuning.to_the_side_m_s2 / curvature.abs().max(1e-9)).sqrt();
        let as_turn_m_s = tuning.turn_rad_s / curvature.abs().max(1e-9);
        let wanted_m_s = tuning.speed_m_s.min(to_stop_m_s).min(in_curve_m_s).max(tuning.least_m_s);
        let speed_m_s = wanted_m_s.min(as_turn_m_s).min(tuning.speed_m_s);
        Twist::new(speed_m_s, speed_m_s * curvature)
    }

    /// Backwards: straight where the point is ahead but too near, else so that the robot turns towards it, or after it.
    fn back_up(&self, target: Point2, bearing_rad: f64) -> Motion {
        let tuning = &self.tuning;
        let is_behind = bearing_rad.abs() > Self::BEHIND_RAD;
        if bearing_rad.abs() < Self::AHEAD_RAD {
            return Motion::Drive(self.backwards(0.0));
        }
        let around = self.backwards(-1.0f64.copysign(bearing_rad) / tuning.radius_m);
        if !is_behind {
            return Motion::Drive(around);
        }
        let back = self.backwards(self.feasible(2.0 * target.y / target.coords.norm_squared().max(1e-6)));
        if target.coords.norm() <= 2.0 * tuning.radius_m && self.is_at_the_end(target) {
            return Motion::Drive(back);
        }
        let needs_m = (bearing_rad.abs() - Self::AHEAD_RAD) * tuning.radius_m;
        Motion::TurnAround { around, needs_m, back }
    }

    fn backwards(&self, curvature: f64) -> Twist {
        let speed_m_s = self.tuning.backing_m_s.min(self.tuning.turn_rad_s / curvature.abs().max(1e-9));
        Twist::new(-speed_m_s, -speed_m_s * curvature)
    }

    fn feasible(&self, curvature: f64) -> f64 {
        let most = if self.tuning.radius_m > 0.0 { 1.0 / self.tuning.radius_m } else { f64::INFINITY };
        curvature.clamp(-most, most)
    }

    /// As fast as the brakes of the turn allow.
    fn turn_rate(&self, left_rad: f64) -> f64 {
        let to_stop_rad_s = (2.0 * self.tuning.turn_braking_rad_s2 * left_rad.abs()).sqrt();
        to_stop_rad_s.min(self.tuning.turn_rad_s).copysign(left_rad)
    }

    /// At the end: turns to its heading, if it has one and the robot can.
    fn settle(&mut self, map_from_base: &Pose2) -> Motion {
        self.gait = Gait::Settling;
        let Some(yaw_rad) = self.route.end_yaw_rad().filter(|_| self.tuning.radius_m <= 0.0) else {
            return Motion::Arrived;
        };
        let left_rad = wrap_angle(yaw_rad - map_from_base.rotation.angle());
        if left_rad.abs() <= self.tuning.yaw_within_rad {
            return Motion::Arrived;
        }
        Motion::Turn(Twist::new(0.0, self.turn_rate(left_rad)))
    }
}
