//! An avoider that drives: what it steers moves the robot, and what the robot meets is what it sees next.

use super::drive::{STEP_S, frame_at, step_time};
use super::law::Trouble;
use super::subject::Subject;
use super::text_world::TextWorld;
use super::turn::Turn;
use nalgebra::Matrix3;
use rumbo_core::frames::{Point2, Pose2, Twist};
use rumbo_core::messages::{Estimate, Observation, Path, Seen};
use rumbo_core::robot::Robot;
use rumbo_core::stages::{AvoidError, AvoidInput, Avoider, Cx, Steering};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

/// Distance at which the path's end counts as reached, meters.
pub const ARRIVAL_RADIUS_M: f64 = 0.1;

/// An avoider in the hall.
pub struct Loop {
    /// The avoider.
    pub avoider: Box<dyn Avoider>,
    /// What the robot can see and touch.
    pub world: TextWorld,
    /// What it follows; none where it wanders.
    pub path: Option<Path>,
    robot: Robot,
    map: rumbo_core::map::Map,
    trace: Trace,
}

/// All that an avoider is told at one time.
#[derive(Debug, Clone)]
pub struct Moment {
    /// When.
    pub now: Time,
    /// Where the robot is.
    pub map_from_base: Pose2,
    /// How its odometer counts.
    pub odom_from_base: Pose2,
    /// How it moves.
    pub twist: Twist,
    /// What it sees.
    pub seen: Vec<Observation>,
}

impl Loop {
    /// A new avoider in the hall, on the way from start to goal.
    pub fn new(subject: &Subject) -> Result<Loop, Trouble> {
        subject.needs_only(&[rumbo_core::map::Layer::Grid])?;
        subject.sees_enough()?;
        let world = TextWorld::hall()?;
        let positions = [world.start.translation.vector.into(), Point2::new(5.0, 3.0), world.goal.position];
        Ok(Loop {
            avoider: subject.build()?,
            path: Path::through(positions, 0.0),
            robot: subject.robot(),
            map: world.map(),
            trace: Trace::unwatched(),
            world,
        })
    }

    /// The same situation from another side, with an avoider of its own.
    pub fn turned(&self, subject: &Subject, turn: Turn) -> Result<Loop, Trouble> {
        let height_m = self.world.height_m();
        let world = self.world.turned(turn)?;
        let positions = self.path.iter().flat_map(|path| path.points());
        let path = Path::through(positions.map(|point| turn.point(point.position, height_m)), 0.0);
        let map = world.map();
        Ok(Loop { world, path, map, ..Loop::new(subject)? })
    }

    /// What the robot sees there and then.
    pub fn moment(&self, k: usize, map_from_base: Pose2, twist: Twist) -> Moment {
        let odom_from_base = self.world.start.inverse() * map_from_base;
        let now = step_time(k);
        let seen = frame_at(&self.world, now, map_from_base, odom_from_base, twist).seen;
        Moment { now, map_from_base, odom_from_base, twist, seen }
    }

    /// The avoider's answer to a moment.
    pub fn steer(&mut self, moment: &Moment) -> Result<Steering, AvoidError> {
        let sure = Matrix3::identity() * 1e-4;
        let estimate = Estimate::planar(moment.now, moment.map_from_base, moment.odom_from_base, sure);
        self.steer_with(moment, &estimate)
    }

    /// The same with an estimate of the caller's own.
    pub fn steer_with(&mut self, moment: &Moment, estimate: &Estimate) -> Result<Steering, AvoidError> {
        let input = AvoidInput {
            map_from_base: moment.map_from_base,
            estimate,
            twist: moment.twist,
            seen: Seen::sorted(&moment.seen),
            map: &self.map,
            grid: self.map.grid.as_ref(),
            path: self.path.as_ref(),
            path_number: u64::from(self.path.is_some()),
            arrival_radius_m: ARRIVAL_RADIUS_M,
            obstacles: &[],
            robot: &self.robot,
        };
        self.avoider.steer(&mut Cx { now: moment.now, trace: &self.trace }, &input)
    }

    /// The robot that is steered.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Drives for at most `n_steps`; `look` sees each moment with its answer and may end the drive.
    pub fn drive(
        &mut self,
        n_steps: usize,
        mut look: impl FnMut(&Moment, &Steering) -> Result<(), Trouble>,
    ) -> Result<End, Trouble> {
        let (mut pose, mut twist) = (self.world.start, Twist::ZERO);
        for k in 0..n_steps {
            let moment = self.moment(k, pose, twist);
            let steering = self.steer(&moment).map_err(|error| {
                Trouble::broken(format!("after {:.1} s: {error}", moment.now.as_secs()), "a twist")
            })?;
            look(&moment, &steering)?;
            match steering {
                Steering::Drive(wanted) => twist = wanted,
                Steering::Arrived => return Ok(End { pose, what: Ended::Arrived }),
                _ => return Ok(End { pose, what: Ended::Blocked }),
            }
            pose *= twist.integrate(STEP_S);
        }
        Ok(End { pose, what: Ended::StillDriving })
    }
}

/// Where a drive ended.
#[derive(Debug, Clone, Copy)]
pub struct End {
    /// The place.
    pub pose: Pose2,
    /// Why.
    pub what: Ended,
}

/// Why a drive ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The avoider said so.
    Arrived,
    /// The avoider wants another path.
    Blocked,
    /// The time was over.
    StillDriving,
}
