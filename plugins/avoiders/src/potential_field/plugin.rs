//! The avoider: field, near rule, brakes, and when the way is blocked.

use super::PotentialFieldParams;
use super::aim::Progressing;
use super::descent::{Descent, Place};
use super::detour::Detour;
use super::near_rule::{NearControl, Pull};
use super::turn::turn_error_rad;
use crate::clear_way::ClearWay;
use crate::effort::Effort;
use crate::explained::is_near_occupied;
use crate::lookout::Lookout;
use crate::near_points::{NearTuning, Sight};
use crate::nearest::{Side, nearest};
use crate::pulse::Pulse;
use crate::two_wheeled;
use crate::wheels::{WheelPair, searching, track_m, turn_in_time_rad_s, within_limits};
use rumbo_core::frames::{Point2, Pose2, Twist};
use rumbo_core::messages::{Obstacle, Path};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, BuildContext, BuildError, Cx, Steering};
use rumbo_core::time::{Span, Time};
use std::f64::consts::PI;

rumbo_core::register_avoider!(
    PotentialFieldParams,
    "potential_field",
    "drawn by the path and pushed off by what depth cameras, lasers and sonars see, with waypoints or a planner"
);

/// See [`PotentialFieldParams`].
#[derive(Debug)]
pub struct PotentialField {
    params: PotentialFieldParams,
    track_m: f64,
    descent: Descent,
    control: NearControl,
    lookout: Lookout,
    clear: ClearWay,
    detour: Detour,
    effort: Effort,
    pulse: Pulse,
    along: Progressing,
    following: Option<u64>,
    is_at_end: bool,
    /// The path is blocked, and this was said.
    is_blocked: bool,
}

/// Where field and near rule want to go.
#[derive(Debug, Clone, Copy)]
struct Wish {
    pull: Pull,
    twist: Twist,
    /// Something stands in the corridor ahead.
    is_blocked: bool,
}

impl PotentialField {
    /// Readings are kept this much farther than the field reaches, for the way until the next, meters.
    const MARGIN_M: f64 = 0.5;
    /// What is told to be in the way is at most this far from the hull, meters.
    const IN_THE_WAY_M: f64 = 0.6;

    /// An avoider for this robot; none for a robot without two driven wheels.
    pub fn new(params: &PotentialFieldParams, robot: &Robot) -> Option<PotentialField> {
        let full_m_s = params.full_m_s(robot);
        let brakes_m = robot.hull().outer_radius_m() + params.clearance_m + robot.stopping_m(full_m_s);
        let lookout = Lookout::new(NearTuning {
            keep_m: brakes_m.max(params.push_law().reach_m()) + Self::MARGIN_M,
            band_m: [params.floor_m, robot.height_m + params.headroom_m],
            stale_after: Span::from_secs(params.stale_after_s),
            memory: Span::from_secs(params.memory.seconds),
        });
        Some(PotentialField {
            track_m: track_m(robot)?,
            descent: params.descent(),
            control: NearControl::new(params.near(robot)),
            lookout,
            clear: ClearWay::new(robot.hull(), params.clearance_m),
            effort: Effort::new(Span::from_secs(params.stuck_after_s), robot.hull().outer_radius_m()),
            detour: Detour::default(),
            pulse: Pulse::default(),
            along: Progressing::default(),
            params: params.clone(),
            following: None,
            is_at_end: false,
            is_blocked: false,
        })
    }

    /// The path of the input; none where there is nothing to follow.
    fn followed<'a>(&mut self, input: &AvoidInput<'a>) -> Option<&'a Path> {
        let Some(path) = input.path else {
            self.following = None;
            return None;
        };
        if self.following != Some(input.path_number) {
            self.following = Some(input.path_number);
            (self.is_blocked, self.is_at_end) = (false, false);
            self.along = Progressing::default();
            self.detour.end();
        }
        (!self.is_blocked).then_some(path)
    }

    fn stand(&mut self) -> Steering {
        self.effort.rest();
        Steering::Drive(Twist::ZERO)
    }

    /// At the end of the path only its heading is left to do.
    fn at_end(&mut self, path: &Path, yaw_rad: f64, robot: &Robot) -> Option<Twist> {
        let error_rad = turn_error_rad(yaw_rad, path.end().yaw_rad?);
        if error_rad.abs() <= self.params.yaw_within_deg.to_radians() {
            return None;
        }
        let wanted_rad_s = robot.max_turn_rad_s() * error_rad.signum();
        Some(Twist::new(
            0.0,
            turn_in_time_rad_s(error_rad, wanted_rad_s, robot.max_turn_accel_rad_s2() / 2.0),
        ))
    }

    /// Where the field, and what is very near, want to go.
    fn wanted(&mut self, path: &Path, input: &AvoidInput<'_>) -> Wish {
        let position = Point2::from(input.map_from_base.translation.vector);
        let place = Place {
            position,
            yaw_rad: input.map_from_base.rotation.angle(),
            aim: self.along.aim(path, position, self.params.passed_within_m),
            arrival_radius_m: input.arrival_radius_m,
        };
        let points = self.lookout.near.points(self.params.memory.repel);
        let (strength, turn_error_rad) = self.descent.pull(&place, points);
        let pull = Pull { strength, turn_error_rad, nearest: nearest(points, PI) };
        let is_blocked = self.control.is_blocked(points);
        let twist = self.twist(&pull, is_blocked, input.robot);
        if is_blocked {
            return Wish { pull, twist: searching(twist, input.robot), is_blocked };
        }
        // Wheels that cannot stop a turn at once begin to end it in time.
        let slowing_rad_s2 = input.robot.max_turn_accel_rad_s2();
        let turn_rad_s = turn_in_time_rad_s(turn_error_rad, twist.turn_rad_s, slowing_rad_s2);
        Wish { pull, twist: Twist { turn_rad_s, ..twist }, is_blocked }
    }

    fn twist(&mut self, pull: &Pull, is_blocked: bool, robot: &Robot) -> Twist {
        within_limits(self.control.steer(pull, is_blocked).twist(self.track_m), robot)
    }

    /// What may be driven of what is wanted: else a turn in place, to one side or the other.
    fn allowed(&mut self, wish: &Wish, robot: &Robot, odom_from_base: &Pose2) -> Option<Twist> {
        let Wish { pull, twist: wanted, is_blocked } = *wish;
        if !self.params.brakes {
            return Some(wanted);
        }
        let wheels = self.pulse.wheels(robot);
        let near = self.lookout.near.points(self.params.memory.rotation_check);
        if is_blocked {
            return self.clear.either_way(wanted, &wheels, near);
        }
        let is_on_detour = self.detour.is_on(odom_from_base);
        // Turning back to the way that is closed does not open it.
        let leads_on = wanted.forward_m_s > 0.0 || !is_on_detour;
        if let Some(allowed) = self.clear.allowed(wanted, &wheels, near).filter(|_| leads_on) {
            self.detour.end();
            return Some(allowed);
        }
        if !is_on_detour && wanted.forward_m_s <= 0.0 {
            return self.clear.either_way(wanted, &wheels, near);
        }
        let corridor = self.params.corridor;
        let straight = within_limits(Twist::new(corridor.beside_m_s, 0.0), robot);
        if let Some(on) = self.clear.allowed(straight, &wheels, near).filter(|_| is_on_detour) {
            return Some(on);
        }
        let met = self.clear.first_met(wanted, robot, near).map(|point| point.y.atan2(point.x));
        let seen = pull.nearest.map_or(0.0, |nearest| nearest.bearing_rad);
        let side = self.detour.begin(odom_from_base, Side::away_from(met.unwrap_or(seen)));
        let spin = WheelPair::spin(side.sign() * corridor.spin_m_s).twist(self.track_m);
        self.clear.either_way(searching(within_limits(spin, robot), robot), &wheels, near)
    }

    fn drive(&mut self, now: Time, path: &Path, input: &AvoidInput<'_>, odom_from_base: &Pose2) -> Steering {
        let wish = self.wanted(path, input);
        let wanted = wish.twist;
        let allowed = self.allowed(&wish, input.robot, odom_from_base);
        // A robot that may not move, and one that is held although it may, are stuck alike.
        let told = allowed.unwrap_or(wanted);
        if told != Twist::ZERO && self.effort.is_in_vain(now, told, odom_from_base) {
            self.is_blocked = true;
            self.effort.rest();
            return Steering::Blocked { obstacles: self.in_the_way(input) };
        }
        Steering::Drive(allowed.unwrap_or(Twist::ZERO))
    }

    fn on_its_way(
        &mut self,
        now: Time,
        input: &AvoidInput<'_>,
        odom_from_base: &Pose2,
    ) -> Result<Steering, AvoidError> {
        let Some(path) = self.followed(input) else { return Ok(self.stand()) };
        if self.lookout.near.sight(now)? == Sight::Blind {
            return Ok(self.stand());
        }
        let left = path.end().position - Point2::from(input.map_from_base.translation.vector);
        self.is_at_end |= left.norm() <= input.arrival_radius_m;
        if self.is_at_end {
            self.effort.rest();
            let turn = self.at_end(path, input.map_from_base.rotation.angle(), input.robot);
            return Ok(turn.map_or(Steering::Arrived, Steering::Drive));
        }
        Ok(self.drive(now, path, input, odom_from_base))
    }

    /// What sensors see just ahead and the map does not show.
    fn in_the_way(&self, input: &AvoidInput<'_>) -> Vec<Obstacle> {
        let hull = input.robot.hull();
        let ahead = self.lookout.near.points(false).iter();
        let ahead = ahead
            .filter(|near| near.in_base.x > 0.0 && hull.distance_m(near.in_base) <= Self::IN_THE_WAY_M)
            .map(|near| (input.map_from_base * near.in_base, near.stamp));
        let is_known = |point: Point2| {
            let within_m = self.params.expected_within_m;
            input.grid.is_some_and(|grid| is_near_occupied(grid, point, within_m))
        };
        let unknown = ahead.filter(|(point, _)| !is_known(*point));
        unknown.map(|(position, stamp)| Obstacle { position, radius_m: 0.0, stamp }).collect()
    }
}

impl Avoider for PotentialField {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        let odom_from_base = self.lookout.look(cx.now, input)?;
        self.pulse.beat(cx.now);
        let steering = self.on_its_way(cx.now, input, &odom_from_base)?;
        Ok(self.pulse.answer(steering, input.robot))
    }
}

impl Plugin<dyn Avoider> for PotentialFieldParams {
    fn manifest(&self) -> Manifest {
        two_wheeled::manifest()
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        let avoider = PotentialField::new(self, &context.robot)
            .ok_or_else(|| two_wheeled::other_drive(&context.robot))?;
        Ok(Box::new(avoider))
    }
}
