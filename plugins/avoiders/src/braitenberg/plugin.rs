//! The avoider: the law, and brakes.

use super::BraitenbergParams;
use super::vehicle::Vehicle;
use crate::clear_way::ClearWay;
use crate::lookout::Lookout;
use crate::near_points::{NearTuning, Sight};
use crate::nearest::{Stimulus, nearest};
use crate::wheels::{track_m, within_limits};
use rumbo_core::frames::Twist;
use rumbo_core::messages::ObservationKind;
use rumbo_core::registry::{Manifest, Plugin};
use rumbo_core::robot::{DriveKind, Robot};
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
    /// The way ahead is closed, and the robot turns until it is not.
    is_held: bool,
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
            params: params.clone(),
            is_held: false,
        })
    }

    /// What the law wants in front of the nearest thing.
    fn wanted(&mut self, nearest: Option<Stimulus>, robot: &Robot) -> Twist {
        within_limits(self.vehicle.steer(nearest).twist(self.track_m), robot)
    }

    /// The law's motion where the brakes allow it; else what is in the way counts as very near.
    fn drive(&mut self, robot: &Robot) -> Twist {
        let stimulus = nearest(self.lookout.near.points(self.params.memory.repel));
        let at_stop = Stimulus {
            distance_m: self.params.stop_distance_m,
            bearing_rad: stimulus.map_or(0.0, |stimulus| stimulus.bearing_rad),
        };
        let straight = Twist::new(self.params.vehicle(robot).speed_m_s, 0.0);
        let near = self.lookout.near.points(self.params.memory.rotation_check);
        self.is_held = self.is_held && self.clear.allowed(straight, robot, near).is_none();
        let wanted = self.wanted(if self.is_held { Some(at_stop) } else { stimulus }, robot);
        let near = self.lookout.near.points(self.params.memory.rotation_check);
        if let Some(allowed) = self.clear.allowed(wanted, robot, near) {
            return allowed;
        }
        self.is_held = true;
        let spin = self.wanted(Some(at_stop), robot);
        let near = self.lookout.near.points(self.params.memory.rotation_check);
        let either = [spin, spin.scaled(-1.0)];
        either.into_iter().find(|spin| self.clear.stops_in_time(*spin, robot, near)).unwrap_or(Twist::ZERO)
    }
}

impl Avoider for Braitenberg {
    fn steer(&mut self, cx: &mut Cx<'_>, input: &AvoidInput<'_>) -> Result<Steering, AvoidError> {
        self.lookout.look(cx.now, input)?;
        if self.lookout.near.sight(cx.now)? == Sight::Blind {
            return Ok(Steering::Drive(Twist::ZERO));
        }
        Ok(Steering::Drive(self.drive(input.robot)))
    }
}

impl Plugin<dyn Avoider> for BraitenbergParams {
    fn manifest(&self) -> Manifest {
        let eyes = vec![ObservationKind::PointCloud, ObservationKind::LaserScan, ObservationKind::RangeRing];
        Manifest {
            consumes: vec![eyes],
            drives: vec![DriveKind::Differential],
            default_rate_hz: Some(20.0),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Avoider>, BuildError> {
        let avoider = Braitenberg::new(self, &context.robot).ok_or_else(|| {
            let kind = context.robot.drive.kind().name();
            BuildError::at(
                "",
                format!("steers the two wheels of a differential drive, and the robot's is {kind}"),
            )
        })?;
        Ok(Box::new(avoider))
    }
}
