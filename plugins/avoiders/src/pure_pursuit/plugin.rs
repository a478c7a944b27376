//! The avoider: pursuit, brakes, and when the way is blocked.

use super::PurePursuitParams;
use super::caution::Caution;
use super::maneuver::{Direction, Maneuver, Tried};
use super::pursuit::{Motion, Pursuit};
use super::way_ahead::{Free, WayAhead};
use crate::listening::Listening;
use crate::progress::Progress;
use crate::sightings::Sightings;
use rumbo_core::frames::{Pose2, Twist, flatten, is_finite2};
use rumbo_core::messages::{Check, MessageFault, ObservationKind};
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::robot::{DriveKind, Robot};
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, BuildContext, BuildError, Cx, Steering};
use rumbo_core::time::{Span, Time};

rumbo_core::register_avoider!(
    PurePursuitParams,
    "pure_pursuit",
    "steers along arcs to a point ahead on the path, for every drive, and stops in front of obstacles"
);

/// See [`PurePursuitParams`].
#[derive(Debug)]
pub struct PurePursuit {
    params: PurePursuitParams,
    pursuit: Pursuit,
    way: WayAhead,
    sightings: Sightings,
    progress: Progress,
    caution: Caution,
    following: Option<u64>,
    /// Turning to and fro.
    maneuver: Option<Maneuver>,
    tried: Tried,
    /// The path is blocked, and this was said.
    is_blocked: bool,
    /// Standing in front of something since then.
    standing_since: Option<Time>,
    listening: Listening,
}

impl PurePursuit {
    /// Readings are kept this much farther than anything looks, meters.
    const MARGIN_M: f64 = 1.0;
    /// The robot's velocity explains where it was at most this long ago, seconds.
    const OLDEST_S: f64 = 1.0;
    /// A turn to and fro may end where the point pursued is this near to straight ahead, radians.
    const TURNED_RAD: f64 = 1.0;
    /// Less free way than this is none, meters.
    const NO_WAY_M: f64 = 0.05;

    /// An avoider for this robot.
    pub fn new(params: &PurePursuitParams, robot: &Robot) -> PurePursuit {
        let way = params.way(robot);
        let keep_m = robot.hull().outer_radius_m() + way.reach_m + way.beside_m + Self::MARGIN_M;
        let caution = Caution {
            least_m_s: params.least_m_s,
            slow_within_m: params.slow_within_m,
            clearance_m: way.clearance_m,
        };
        PurePursuit {
            pursuit: Pursuit::new(params.pursuit(robot)),
            way: WayAhead::new(way),
            sightings: Sightings::new(keep_m),
            progress: Progress::new(Span::from_secs(params.stuck_after_s)),
            params: params.clone(),
            caution,
            following: None,
            maneuver: None,
            tried: Tried::default(),
            is_blocked: false,
            standing_since: None,
            listening: Listening::new(Span::from_secs(params.stale_after_s)),
        }
    }

    fn look(&mut self, now: Time, input: &AvoidInput<'_>, odom_from_base: &Pose2) {
        for observation in input.seen.iter() {
            let age_s = (now - observation.stamp).as_secs().clamp(0.0, Self::OLDEST_S);
            self.sightings.see(observation, &(odom_from_base * input.twist.integrate(-age_s)), &[]);
        }
        self.way.look(&self.sightings, odom_from_base);
    }

    /// Follows the path of the input; false where there is nothing to follow.
    fn follows_a_path(&mut self, input: &AvoidInput<'_>) -> bool {
        let Some(path) = input.path else {
            self.following = None;
            return false;
        };
        if self.following != Some(input.path_number) {
            self.following = Some(input.path_number);
            (self.is_blocked, self.standing_since) = (false, None);
            (self.maneuver, self.tried) = (None, Tried::default());
            self.pursuit.follow(path);
        }
        !self.is_blocked
    }

    fn stand(&mut self) -> Steering {
        self.progress.rest();
        Steering::Drive(Twist::ZERO)
    }

    fn block(&mut self, twist: Twist, input: &AvoidInput<'_>) -> Steering {
        (self.is_blocked, self.standing_since) = (true, None);
        self.progress.rest();
        Steering::Blocked { obstacles: self.way.unexpected(twist, &input.map_from_base, input.grid) }
    }

    /// The wanted arc, as fast as what is near allows.
    fn drive(
        &mut self,
        now: Time,
        wanted: Twist,
        input: &AvoidInput<'_>,
        odom_from_base: &Pose2,
    ) -> Result<Steering, AvoidError> {
        if !self.listening.has_fresh_readings(now, &self.sightings)? {
            return Ok(self.stand());
        }
        let Free { along_m, beside_m } = self.way.free(wanted);
        if along_m < Self::NO_WAY_M {
            if self.begins_to_maneuver(wanted, input) {
                return Ok(self.stand());
            }
            let since = *self.standing_since.get_or_insert(now);
            if now - since >= Span::from_secs(self.params.wait_s) {
                return Ok(self.block(wanted, input));
            }
            return Ok(self.stand());
        }
        self.standing_since = None;
        let wanted_m_s = wanted.forward_m_s.abs();
        let allowed_m_s =
            input.robot.stops_within_m_s(along_m).min(self.caution.beside_m_s(beside_m, wanted_m_s));
        let twist = wanted.scaled((allowed_m_s / wanted_m_s.max(1e-9)).min(1.0));
        if self.progress.is_stuck(now, twist, odom_from_base) {
            return Ok(self.block(wanted, input));
        }
        Ok(Steering::Drive(twist))
    }

    /// What is in the way is on the map: another plan would lead along it again. So the robot turns to its path where it
    /// is, unless it did so here before.
    fn begins_to_maneuver(&mut self, wanted: Twist, input: &AvoidInput<'_>) -> bool {
        if self.maneuver.is_some() || !self.pursuit.maneuvers() || !self.tried.again_at(self.pursuit.come_m())
        {
            return false;
        }
        let is_known = self.way.unexpected(wanted, &input.map_from_base, input.grid).is_empty();
        let ahead = self.pursuit.ahead(&input.map_from_base, input.twist).filter(|_| is_known);
        let Some((bearing_rad, _, _)) = ahead else { return false };
        let direction = if wanted.forward_m_s > 0.0 { Direction::Back } else { Direction::Ahead };
        let at = input.map_from_base.translation.vector.into();
        self.maneuver = Some(Maneuver::begin(at, bearing_rad, direction, self.pursuit.half_turn_m()));
        true
    }

    /// Drives as wanted, or the next leg of a turn to and fro until the arc to the path is free.
    fn go(
        &mut self,
        now: Time,
        wanted: Twist,
        input: &AvoidInput<'_>,
        odom_from_base: &Pose2,
    ) -> Result<Steering, AvoidError> {
        let ahead = self.pursuit.ahead(&input.map_from_base, input.twist);
        let (Some(maneuver), Some((bearing_rad, arc, needs_m))) = (&mut self.maneuver, ahead) else {
            return self.drive(now, wanted, input, odom_from_base);
        };
        if bearing_rad.abs() < Self::TURNED_RAD && self.way.free(arc).along_m >= needs_m {
            self.maneuver = None;
            self.pursuit.go_ahead();
            return self.drive(now, arc, input, odom_from_base);
        }
        let side = maneuver.side();
        let leg = |direction, share: f64| self.pursuit.turning(side * share, direction);
        let next = maneuver.next(input.map_from_base.translation.vector.into(), &|direction, share| {
            self.way.free(leg(direction, share)).along_m
        });
        let Some((direction, share)) = next else {
            self.maneuver = None;
            return Ok(self.block(wanted, input));
        };
        let wanted = leg(direction, share);
        self.drive(now, wanted, input, odom_from_base)
    }

    fn turn(&mut self, now: Time, twist: Twist, input: &AvoidInput<'_>, odom_from_base: &Pose2) -> Steering {
        self.standing_since = None;
        if self.progress.is_stuck(now, twist, odom_from_base) {
            return self.block(Twist::new(self.params.least_m_s, 0.0), input);
        }
        Steering::Drive(twist)
    }
}

impl Avoider for PurePursuit {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        if !is_finite2(&input.map_from_base) {
            let found = format!("{}", input.map_from_base);
            let (message, field, expected) = ("avoid_input", "map_from_base", "finite numbers");
            return Err(MessageFault { message, field, found, expected }.into());
        }
        input.twist.check()?;
        self.listening.note(cx.now);
        let odom_from_base = flatten(&input.estimate.map_from_odom).inverse() * input.map_from_base;
        self.look(cx.now, input, &odom_from_base);
        if !self.follows_a_path(input) {
            return Ok(self.stand());
        }
        match self.pursuit.steer(&input.map_from_base, input.twist, input.arrival_radius_m) {
            Motion::Arrived => Ok(Steering::Arrived),
            Motion::CannotFollow => Ok(self.block(Twist::new(self.params.least_m_s, 0.0), input)),
            Motion::Turn(twist) => Ok(self.turn(cx.now, twist, input, &odom_from_base)),
            Motion::Drive(twist) => self.go(cx.now, twist, input, &odom_from_base),
            Motion::TurnAround { around, needs_m, back } => {
                let has_room = self.way.free(around).along_m >= needs_m;
                self.go(cx.now, if has_room { around } else { back }, input, &odom_from_base)
            }
        }
    }
}

impl Plugin<dyn Avoider> for PurePursuitParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            consumes: vec![vec![ObservationKind::LaserScan, ObservationKind::RangeRing]],
            drives: vec![DriveKind::Differential, DriveKind::Tricycle, DriveKind::Omnidirectional],
            default_rate_hz: Some(20.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        Ok(Box::new(PurePursuit::new(self, &context.robot)))
    }
}
