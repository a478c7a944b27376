//! The avoider: pursuit, brakes, and when the way is blocked.

use super::PurePursuitParams;
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
    /// The path is blocked, and this was said.
    is_blocked: bool,
    /// Standing in front of something since then.
    standing_since: Option<Time>,
    listening: Listening,
}

/// How near things slow the robot.
#[derive(Debug, Clone, Copy)]
struct Caution {
    least_m_s: f64,
    slow_within_m: f64,
    clearance_m: f64,
}

impl Caution {
    /// How much of the speed is left beside something this near.
    fn beside_m_s(&self, beside_m: f64, wanted_m_s: f64) -> f64 {
        let room_m = (beside_m - self.clearance_m).max(0.0);
        let most_m = (self.slow_within_m - self.clearance_m).max(1e-9);
        (wanted_m_s * (room_m / most_m)).max(self.least_m_s)
    }
}

impl PurePursuit {
    /// Readings are kept this much farther than anything looks, meters.
    const MARGIN_M: f64 = 1.0;
    /// The robot's velocity explains where it was at most this long ago, seconds.
    const OLDEST_S: f64 = 1.0;
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
            Motion::Drive(twist) => self.drive(cx.now, twist, input, &odom_from_base),
            Motion::TurnAround { around, needs_m, back } => {
                let has_room = self.way.free(around).along_m >= needs_m;
                self.drive(cx.now, if has_room { around } else { back }, input, &odom_from_base)
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
