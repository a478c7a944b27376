//! The robot on its way: what it believes, what it sees, and what its wheels make of it.

use crate::camera::{Faults, Gives, look};
use crate::place::Place;
use rand::RngExt;
use rumbo_core::frames::{Point2, Pose2, Twist, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::{Estimate, Path, Seen};
use rumbo_core::rng::Rng;
use rumbo_core::robot::{Drive, Robot};
use rumbo_core::stages::{AvoidInput, Avoider, Cx, Steering};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

/// Control period, seconds.
pub const STEP_S: f64 = 0.05;
/// A waypoint that is not the last counts as reached within this, meters.
const SWITCH_RADIUS_M: f64 = 0.7;
/// The last one does within this, meters.
pub const ARRIVAL_RADIUS_M: f64 = 0.55;

/// A Pioneer P3-DX whose wheels do at once what they are told.
pub fn pioneer() -> Robot {
    Robot {
        drive: Drive::Differential { track_m: 0.33 },
        radius_m: 0.267,
        height_m: 0.237,
        max_speed_m_s: 1.2,
        max_turn_deg_s: 300.0,
        max_accel_m_s2: 1e6,
        max_turn_accel_deg_s2: 1e6,
        braking_m_s2: 1e6,
        ..Robot::default()
    }
}

/// The same with the accelerations of a real one: 0.6 m/s² and 2 rad/s².
pub fn heavy_pioneer() -> Robot {
    Robot { max_accel_m_s2: 0.6, braking_m_s2: 0.6, max_turn_accel_deg_s2: 2f64.to_degrees(), ..pioneer() }
}

/// Where the robot believes that it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Belief {
    /// Where it is.
    True,
    /// Mean of the last three fixes, one in every cycle, each axis off by at most so much, meters.
    MeanOfThree(f64),
    /// Odometry with 5 % of noise, and fixes once a second that are off by at most so much, meters.
    Fused(f64),
}

/// A run.
pub struct Run<'a> {
    /// The place.
    pub place: &'a Place,
    /// The robot.
    pub robot: Robot,
    /// What the camera gives.
    pub gives: Gives,
    /// What the camera does not see.
    pub faults: Faults,
    /// Where it believes that it is.
    pub belief: Belief,
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// Where to; nothing for a robot that wanders.
    pub waypoints: Vec<Point2>,
    /// At most so long, seconds.
    pub limit_s: f64,
}

/// What came of it.
#[derive(Debug, Clone)]
pub struct Result {
    /// All waypoints were reached.
    pub is_complete: bool,
    /// Waypoints that were reached.
    pub n_reached: usize,
    /// When it ended, seconds.
    pub time_s: f64,
    /// Way driven, meters.
    pub driven_m: f64,
    /// Middle of the robot to the nearest wall at the least, meters.
    pub least_m: f64,
    /// Root of the mean square of the position's error, meters.
    pub error_m: f64,
    /// Where it ended.
    pub end: Pose2,
    /// First time at which it had not come 0.2 m far for 5 s, and where.
    pub stuck: Option<(f64, Point2)>,
    /// Where it was, every cycle.
    pub way: Vec<Point2>,
    /// What it steered, every cycle.
    pub twists: Vec<Twist>,
}

/// Fixes and odometry, and what the robot makes of them.
struct Believer {
    belief: Belief,
    rng: Rng,
    fixes: Vec<Point2>,
    position: Point2,
    variance_m2: f64,
}

impl Believer {
    fn new(belief: Belief, seed: u64, start: Point2) -> Believer {
        Believer {
            belief,
            rng: rumbo_core::rng::stream(seed, "belief"),
            fixes: Vec::new(),
            position: start,
            variance_m2: 1e-4,
        }
    }

    fn fix(&mut self, truth: Point2, error_m: f64) -> Point2 {
        let mut off = || error_m * (2.0 * self.rng.random::<f64>() - 1.0);
        truth + nalgebra::Vector2::new(off(), off())
    }

    /// The position after another cycle.
    fn think(&mut self, step: usize, truth: Point2, moved: nalgebra::Vector2<f64>) -> Point2 {
        match self.belief {
            Belief::True => truth,
            Belief::MeanOfThree(error_m) => {
                let fix = self.fix(truth, error_m);
                self.fixes.push(fix);
                let last: Vec<_> = self.fixes.iter().rev().take(3).map(|fix| fix.coords).collect();
                if last.len() < 3 {
                    fix
                } else {
                    Point2::from(last.iter().sum::<nalgebra::Vector2<f64>>() / 3.0)
                }
            }
            Belief::Fused(error_m) => {
                let noise = 1.0 + 0.05 * (2.0 * self.rng.random::<f64>() - 1.0) * 3f64.sqrt();
                self.position += moved * noise;
                self.variance_m2 += (0.02 * moved.norm()).powi(2) + 1e-7;
                if step.is_multiple_of(20) {
                    let (fix, fix_m2) = (self.fix(truth, error_m), error_m.powi(2) / 3.0);
                    let gain = self.variance_m2 / (self.variance_m2 + fix_m2);
                    let off = fix - self.position;
                    if off.iter().all(|part| part * part <= 9.0 * (self.variance_m2 + fix_m2)) {
                        self.position += off * gain;
                        self.variance_m2 *= 1.0 - gain;
                    }
                }
                self.position
            }
        }
    }
}

/// As much of the change as the accelerations allow in one cycle.
fn obey(now: Twist, wanted: Twist, robot: &Robot) -> Twist {
    let toward = |now: f64, wanted: f64, most: f64| now + (wanted - now).clamp(-most, most);
    Twist::new(
        toward(now.forward_m_s, wanted.forward_m_s, robot.max_accel_m_s2 * STEP_S),
        toward(now.turn_rad_s, wanted.turn_rad_s, robot.max_turn_accel_rad_s2() * STEP_S),
    )
}

impl Run<'_> {
    /// Drives from a start.
    pub fn drive(&self, avoider: &mut dyn Avoider, start: Pose2) -> Result {
        let (map, trace, mut rng) =
            (Map::default(), Trace::unwatched(), rumbo_core::rng::stream(self.seed, "camera"));
        let place_of = |pose: &Pose2| Point2::from(pose.translation.vector);
        let (mut pose, mut twist, mut goal) = (start, Twist::ZERO, 0);
        let mut believer = Believer::new(self.belief, self.seed, place_of(&start));
        let mut moved = nalgebra::Vector2::zeros();
        let mut path = self.path(goal, place_of(&start));
        let mut result = Result {
            is_complete: false,
            n_reached: 0,
            time_s: self.limit_s,
            driven_m: 0.0,
            least_m: f64::INFINITY,
            error_m: 0.0,
            end: start,
            stuck: None,
            way: Vec::new(),
            twists: Vec::new(),
        };
        let mut squares = 0.0;
        let n_steps = (self.limit_s / STEP_S) as usize;
        for step in 0..n_steps {
            let now = Time::from_secs(STEP_S * step as f64);
            let believed = believer.think(step, place_of(&pose), moved);
            squares += (believed - place_of(&pose)).norm_squared();
            let map_from_base = pose2(believed.x, believed.y, pose.rotation.angle());
            if goal + 1 < self.waypoints.len() && (self.waypoints[goal] - believed).norm() < SWITCH_RADIUS_M {
                goal += 1;
                path = self.path(goal, believed);
            }
            let seen = [look(self.place, &pose, now, self.gives, self.faults, &mut rng)];
            let estimate = Estimate::planar(now, map_from_base, pose, nalgebra::Matrix3::zeros());
            let input = AvoidInput {
                map_from_base,
                estimate: &estimate,
                twist,
                seen: Seen::sorted(&seen),
                map: &map,
                grid: None,
                path: path.as_ref(),
                path_number: goal as u64,
                arrival_radius_m: ARRIVAL_RADIUS_M,
                obstacles: &[],
                robot: &self.robot,
            };
            let steering = avoider.steer(&mut Cx { now, trace: &trace }, &input).unwrap();
            let wanted = match steering {
                Steering::Drive(wanted) => wanted,
                Steering::Arrived => {
                    result.is_complete = true;
                    goal += 1;
                    result.time_s = now.as_secs();
                    break;
                }
                other => panic!("{now}: {other:?}"),
            };
            assert!(
                wanted.speed_m_s() <= 1.2 + 1e-9 && wanted.turn_rad_s.abs() <= 300f64.to_radians() + 1e-9
            );
            twist = obey(twist, wanted, &self.robot);
            result.twists.push(twist);
            let before = place_of(&pose);
            pose *= twist.integrate(STEP_S);
            moved = place_of(&pose) - before;
            result.driven_m += moved.norm();
            result.least_m = result.least_m.min(self.place.clearance_m(place_of(&pose)));
            result.way.push(place_of(&pose));
            let long_ago = result.way.len().checked_sub((5.0 / STEP_S) as usize);
            if let Some(at) = long_ago.filter(|_| result.stuck.is_none()) {
                let since = &result.way[at..];
                let is_stuck = since.iter().all(|other| (other - since[0]).norm() < 0.2);
                result.stuck = is_stuck.then(|| (now.as_secs(), place_of(&pose)));
            }
        }
        result.n_reached = goal;
        result.end = pose;
        result.error_m = (squares / result.way.len().max(1) as f64).sqrt();
        result
    }

    fn path(&self, goal: usize, from: Point2) -> Option<Path> {
        self.waypoints.get(goal).and_then(|goal| Path::through([from, *goal], 0.0))
    }
}
