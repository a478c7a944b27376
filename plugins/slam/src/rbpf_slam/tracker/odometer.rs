//! Steps between scans: by the odometer, or where there is none by the velocity so far.

use super::Counters;
use super::gyro::Turns;
use crate::rbpf_slam::motion::Step;
use rumbo_core::frames::{Pose2, Twist};
use rumbo_core::messages::{Check, Odometry};
use rumbo_core::time::{Span, Time};
use rumbo_kit::odometry_history::{OdometryHistory, Reading, is_jump};

/// What the odometer said.
#[derive(Debug, Clone)]
pub struct Odometer {
    history: OdometryHistory,
    max_jump_m: f64,
    /// What an inertial unit says.
    pub(in crate::rbpf_slam) turns: Turns,
    /// The pose at the last scan, where the odometer knows it.
    pub(in crate::rbpf_slam) at_scan: Option<Pose2>,
    /// Variances that the next step has beside its own.
    pub(in crate::rbpf_slam) stray: [f64; 2],
    /// As the scans have it.
    pub(in crate::rbpf_slam) velocity: Twist,
}

/// A scan waits so long for the odometer, seconds.
const PATIENCE_S: f64 = 0.5;
/// Standard deviations of speed and turning rate that nobody measured, m/s and rad/s.
const UNMEASURED: [f64; 2] = [0.5, 0.5];
/// What they come to at most, meters and radians.
const MOST_STRAY: [f64; 2] = [1.0, 0.5];
/// After a jump of the odometer the heading has this standard deviation, radians.
const JUMP_RAD: f64 = 0.35;
/// What a robot can drive at most, m/s.
const FASTEST_M_S: f64 = 3.0;

/// Variances of x, y, yaw after a time in which nobody measured the motion, m² and rad².
pub(super) fn unmeasured(seconds: f64) -> [f64; 3] {
    let [way, turn] = UNMEASURED.map(|speed| (speed * seconds).powi(2));
    [way, way, turn]
}

impl Odometer {
    /// Nothing was said yet.
    pub fn new(max_jump_m: f64) -> Odometer {
        let history = OdometryHistory::default();
        let (turns, velocity) = (Turns::default(), Twist::ZERO);
        Odometer { history, max_jump_m, turns, at_scan: None, stray: [0.0; 2], velocity }
    }

    /// Takes in a reading.
    pub fn take(&mut self, stamp: Time, odometry: &Odometry, counters: &mut Counters) {
        if odometry.check().is_err() {
            counters.odometry_dropped += 1;
            return;
        }
        let last = self.history.newest().or(self.at_scan.map(|pose| (stamp, pose)));
        if let Some((before, odom_from_last)) = last.filter(|(before, _)| stamp >= *before) {
            let elapsed_s = (stamp - before).as_secs();
            let most_m = self.max_jump_m + FASTEST_M_S * elapsed_s;
            if is_jump(&odom_from_last, &odometry.odom_from_base, most_m) {
                counters.odometry_jumps += 1;
                self.begin_anew();
            }
        }
        if self.history.push(stamp, odometry.odom_from_base) == Reading::Stale {
            counters.odometry_dropped += 1;
        }
    }

    /// The odometer was restarted or lifted: the robot is about where it was.
    pub fn begin_anew(&mut self) {
        self.history.clear();
        self.at_scan = None;
        self.stray[0] += self.max_jump_m * self.max_jump_m;
        self.stray[1] += JUMP_RAD * JUMP_RAD;
    }

    /// Nothing better will be known of this time.
    pub fn is_ready(&self, stamp: Time, now: Time) -> bool {
        let is_silent = self.history.newest().is_none();
        (is_silent || self.history.is_past(stamp)) && self.turns.gyro.is_past(stamp)
            || now - stamp > Span::from_secs(PATIENCE_S)
    }

    /// The step from the last scan, if there was one, to a scan of this time; its turn by the gyroscope where there is one.
    pub fn step_to(&mut self, stamp: Time, last: Option<Time>) -> Step {
        let mut step = self.step_of_wheels(stamp, last);
        if let Some((turn_rad, variance)) = self.turns.turn_to(stamp, last) {
            step.before_from_after.rotation = nalgebra::UnitComplex::new(turn_rad);
            step.measured_turn = Some(variance);
        }
        step
    }

    fn step_of_wheels(&mut self, stamp: Time, last: Option<Time>) -> Step {
        let at_scan = self.history.at(stamp);
        let before = std::mem::replace(&mut self.at_scan, at_scan);
        let stray = std::mem::take(&mut self.stray);
        let elapsed_s = last.map_or(0.0, |last| (stamp - last).as_secs());
        if let (Some(before), Some(after)) = (before, at_scan) {
            return Step { before_from_after: before.inverse() * after, stray, ..Step::default() };
        }
        let most = |k: usize| (UNMEASURED[k] * elapsed_s).min(MOST_STRAY[k]).powi(2);
        let stray = [stray[0] + most(0), stray[1] + most(1)];
        // Longer than a moment nobody drives on as before.
        let moving_s = elapsed_s.min(1.0);
        Step { before_from_after: self.velocity.integrate(moving_s), stray, ..Step::default() }
    }

    /// The robot was followed over this way in this time.
    pub fn learn_velocity(&mut self, before_from_after: &Pose2, seconds: f64) {
        let way = before_from_after.translation;
        let speed = |v: f64| v / seconds;
        let twist = Twist {
            forward_m_s: speed(way.x),
            left_m_s: speed(way.y),
            turn_rad_s: speed(before_from_after.rotation.angle()),
        };
        let is_sound = seconds > 0.0 && twist.is_finite() && twist.speed_m_s() <= FASTEST_M_S;
        self.velocity = if is_sound { twist } else { Twist::ZERO };
    }

    /// What comes next has nothing to do with what came before, and the robot is where it is said to be.
    pub fn forget(&mut self) {
        self.history.clear();
        self.turns.forget();
        (self.at_scan, self.stray, self.velocity) = (None, [0.0; 2], Twist::ZERO);
    }

    /// The time that is known best, and the step to it from the last scan: by readings that are newer.
    pub fn ahead(&self, scan: Option<Time>, now: Time) -> (Time, Step) {
        let newest = self.history.newest().filter(|(stamp, _)| *stamp <= now);
        let stamp = scan.unwrap_or(now).min(now);
        match (newest, self.at_scan) {
            (Some((newest, odom_from_base)), Some(odom_from_scan)) if newest > stamp => {
                let before_from_after = odom_from_scan.inverse() * odom_from_base;
                (newest, Step { before_from_after, stray: self.stray, ..Step::default() })
            }
            _ => (stamp, Step::default()),
        }
    }

    /// The pose of the odometer at a time, or the last before it; at the origin where it never spoke.
    pub fn newest_pose(&self, stamp: Time) -> Pose2 {
        let known = self.history.at(stamp).or(self.at_scan);
        known.or(self.history.newest().map(|(_, pose)| pose)).unwrap_or_else(Pose2::identity)
    }
}
