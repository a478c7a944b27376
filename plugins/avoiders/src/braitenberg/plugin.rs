//! The avoider: the law, and brakes.

use super::BraitenbergParams;
use super::vehicle::Vehicle;
use crate::clear_way::ClearWay;
use crate::lookout::Lookout;
use crate::memory_params::MemoryParams;
use crate::near_points::{NearTuning, Sight};
use crate::nearest::{Side, Stimulus, nearest};
use crate::pulse::Pulse;
use crate::two_wheeled;
use crate::wheels::{WheelPair, searching, track_m, within_limits};
use rumbo_core::frames::Twist;
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, BuildContext, BuildError, Cx, Steering};
use rumbo_core::time::Span;

rumbo_core::register_avoider!(
    BraitenbergParams,
    "braitenberg",
    "wanders without a goal and flees from what depth cameras, lasers and sonars see"
);

/// See [`BraitenbergParams`].
#[derive(Debug)]
pub struct Braitenberg {
    params: BraitenbergParams,
    track_m: f64,
    vehicle: Vehicle,
    lookout: Lookout,
    clear: ClearWay,
    pulse: Pulse,
    /// The way ahead is closed, and the robot turns until it is not.
    is_held: bool,
    /// Which way it turned last while something has been near.
    held: Option<Side>,
}

impl Braitenberg {
    /// Readings are kept at least this far, so that a wall met squarely shows on which side there is room, meters.
    const KEEP_M: f64 = 4.0;

    /// An avoider for this robot; none for a robot without two driven wheels.
    pub fn new(params: &BraitenbergParams, robot: &Robot) -> Option<Braitenberg> {
        let brakes_m = robot.stopping_m(params.speed_m_s.min(robot.max_speed_m_s));
        let lookout = Lookout::new(NearTuning {
            keep_m: (robot.hull().outer_radius_m() + params.clearance_m + brakes_m).max(Self::KEEP_M),
            band_m: [params.floor_m, robot.height_m + params.headroom_m],
            stale_after: Span::from_secs(params.stale_after_s),
            memory: Span::from_secs(params.memory.seconds),
        });
        Some(Braitenberg {
            track_m: track_m(robot)?,
            vehicle: Vehicle::new(params.vehicle(robot)),
            lookout,
            clear: ClearWay::new(robot.hull(), params.clearance_m),
            pulse: Pulse::default(),
            params: params.clone(),
            is_held: false,
            held: None,
        })
    }

    /// What the law wants in front of the nearest thing.
    fn wanted(&mut self, nearest: Option<Stimulus>, robot: &Robot) -> Twist {
        within_limits(self.vehicle.steer(nearest).twist(self.track_m), robot)
    }

    /// The law's motion where the brakes allow it; else a turn in place until they allow to go straight on.
    fn drive(&mut self, robot: &Robot) -> Twist {
        let MemoryParams { rotation_check, repel, .. } = self.params.memory;
        let half_view_rad = self.params.view_deg.to_radians() / 2.0;
        let stimulus = nearest(self.lookout.near.points(repel), half_view_rad);
        if !self.params.brakes {
            return self.wanted(stimulus, robot);
        }
        let law = self.params.vehicle(robot);
        let near = self.lookout.near.points(rotation_check);
        let (wheels, straight) = (self.pulse.wheels(robot), Twist::new(law.speed_m_s, 0.0));
        let is_free = stimulus.is_none_or(|stimulus| stimulus.distance_m > law.slow_distance_m);
        self.held = self.held.filter(|_| !is_free);
        self.is_held = self.is_held && self.clear.allowed(straight, &wheels, near).is_none();
        if !self.is_held {
            let wanted = self.wanted(stimulus, robot);
            let wanted = if wanted.forward_m_s == 0.0 { searching(wanted, robot) } else { wanted };
            let near = self.lookout.near.points(rotation_check);
            if let Some(allowed) = self.clear.allowed(wanted, &wheels, near) {
                return allowed;
            }
            self.is_held = true;
        }
        // The same way as long as anything is near: else a corner would turn it to and fro.
        let near = self.lookout.near.points(rotation_check);
        let met = self.clear.first_met(straight, robot, near);
        let away = Side::away_from(met.map_or(0.0, |point| point.y.atan2(point.x)));
        let spin = WheelPair::spin(self.held.get_or_insert(away).sign() * law.spin_m_s);
        let spin = searching(within_limits(spin.twist(self.track_m), robot), robot);
        self.clear.either_way(spin, &wheels, near).unwrap_or(Twist::ZERO)
    }
}

impl Avoider for Braitenberg {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        self.lookout.look(cx.now, input)?;
        self.pulse.beat(cx.now);
        let is_blind = self.lookout.near.sight(cx.now)? == Sight::Blind;
        let twist = if is_blind { Twist::ZERO } else { self.drive(input.robot) };
        Ok(self.pulse.answer(Steering::Drive(twist), input.robot))
    }
}

impl Plugin<dyn Avoider> for BraitenbergParams {
    fn manifest(&self) -> Manifest {
        two_wheeled::manifest()
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        let avoider =
            Braitenberg::new(self, &context.robot).ok_or_else(|| two_wheeled::other_drive(&context.robot))?;
        Ok(Box::new(avoider))
    }
}
