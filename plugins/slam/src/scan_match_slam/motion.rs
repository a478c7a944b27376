//! How the robot moved since a scan, before the next one is looked at.

use crate::turning::yaw_rate_rad_s;
use crate::unseen::SILENT_S;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Twist, is_finite2, pose2, wrap_angle};
use rumbo_core::messages::{Data, Odometry, Seen};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::Time;
use std::collections::VecDeque;

/// Where the first guess of a match comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PredictionRule {
    /// The odometer where there is one, the gyroscope's turn where there is one, and otherwise the velocity of the last
    /// matches.
    Odometry,
    /// The velocity of the last matches.
    ConstantVelocity,
    /// The last match.
    LastPose,
}

/// How wrong the guess may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionErrors {
    /// Of an odometer's way, meters a meter.
    pub way_share: f64,
    /// Of an odometer's turn, radians a radian.
    pub turn_share: f64,
    /// Of an odometer's turn, radians a meter.
    pub turn_rad_m: f64,
    /// Of a gyroscope's turn, radians a second.
    pub gyro_rad_s: f64,
    /// Without an odometer: change of speed, m/s².
    pub acceleration_m_s2: f64,
    /// Without an odometer and a gyroscope: change of the turning rate, rad/s².
    pub turn_acceleration_rad_s2: f64,
    /// At least, meters and radians.
    pub least: [f64; 2],
}

/// A motion in the frame of the pose that it begins at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// The later base in the earlier.
    pub before_from_after: Pose2,
    /// Covariance of x, y, yaw in the earlier base's axes.
    pub covariance: Matrix3<f64>,
    /// An odometer said so.
    pub is_by_odometer: bool,
}

/// What a later run needs to go on in the same motion.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MotionState {
    /// The odometer's readings since the last scan, and the one before it.
    pub odometry: Vec<(Time, Pose2)>,
    /// The gyroscope's of the last moments.
    pub rates_rad_s: Vec<(Time, f64)>,
    /// The last scan's pose.
    pub last: Option<(Time, Pose2)>,
    /// The last match's stamp.
    pub matched: Option<Time>,
    /// Of the last matches, once there were two.
    pub velocity: Option<Twist>,
}

/// Beyond this a velocity says nothing, seconds.
const VELOCITY_HOLDS_S: f64 = 1.0;
/// A robot whose velocity is not known yet may move like this, m/s and rad/s.
const UNKNOWN_SPEED: [f64; 2] = [1.5, 1.0];
/// After a pause that is longer an odometer may have begun anew, seconds, ...
const ODOMETER_PAUSE_S: f64 = 1.0;
/// ... and surely has where it would have been faster than this, m/s.
const FASTEST_M_S: f64 = 10.0;
/// Readings of the odometer that are kept between two scans.
const MOST_READINGS: usize = 400;
/// Rates that are kept, for scans that come late.
const MOST_RATES: usize = 4096;
/// A gyroscope that was silent for longer does not know the turn, seconds.
const GYRO_GAP_S: f64 = 0.25;

/// Follows odometer and gyroscope, and the velocity of the matches.
#[derive(Debug)]
pub struct Motion {
    rule: PredictionRule,
    errors: MotionErrors,
    odometry: OdometryTrack,
    /// Those of its readings that a later run needs.
    recent: VecDeque<(Time, Pose2)>,
    is_resumed: bool,
    rates_rad_s: VecDeque<(Time, f64)>,
    last: Option<(Time, Pose2)>,
    matched: Option<Time>,
    velocity: Option<Twist>,
}

impl Motion {
    /// Nothing is known yet.
    pub fn new(rule: PredictionRule, errors: MotionErrors) -> Motion {
        Motion {
            rule,
            errors,
            odometry: OdometryTrack::new(),
            recent: VecDeque::new(),
            is_resumed: false,
            rates_rad_s: VecDeque::new(),
            last: None,
            matched: None,
            velocity: None,
        }
    }

    /// Goes on from what was saved.
    pub fn resumed(rule: PredictionRule, errors: MotionErrors, state: &MotionState) -> Motion {
        let mut motion = Motion::new(rule, errors);
        for (stamp, odom_from_base) in &state.odometry {
            motion
                .read_odometer(*stamp, &Odometry { odom_from_base: *odom_from_base, ..Odometry::default() });
        }
        motion.rates_rad_s.extend(&state.rates_rad_s);
        (motion.last, motion.matched, motion.velocity) = (state.last, state.matched, state.velocity);
        motion.is_resumed = true;
        motion
    }

    /// What a later run needs.
    pub fn state(&self) -> MotionState {
        let since = self.last.map(|(stamp, _)| stamp);
        let first = since.map_or(0, |since| self.rates_rad_s.partition_point(|(t, _)| *t <= since));
        MotionState {
            odometry: self.recent.iter().copied().collect(),
            rates_rad_s: self.rates_rad_s.range(first.saturating_sub(1)..).copied().collect(),
            last: self.last,
            matched: self.matched,
            velocity: self.velocity,
        }
    }

    /// Follows the sensors.
    pub fn take(&mut self, seen: Seen<'_>) {
        for observation in seen.iter().filter(|observation| observation.valid) {
            match &observation.data {
                Data::Odometry(odometry) if is_finite2(&odometry.odom_from_base) => {
                    self.read_odometer(observation.stamp, odometry);
                }
                Data::Imu(imu) => {
                    let rate_rad_s = yaw_rate_rad_s(imu, &observation.base_from_sensor);
                    let is_newer =
                        self.rates_rad_s.back().is_none_or(|(stamp, _)| *stamp < observation.stamp);
                    if is_newer && rate_rad_s.is_finite() {
                        self.rates_rad_s.push_back((observation.stamp, rate_rad_s));
                    }
                    if self.rates_rad_s.len() > MOST_RATES {
                        self.rates_rad_s.pop_front();
                    }
                }
                _ => {}
            }
        }
    }

    fn read_odometer(&mut self, stamp: Time, odometry: &Odometry) {
        let newest = self.recent.back().copied();
        if let Some((before, odom_from_before)) = newest.filter(|_| self.is_resumed) {
            self.is_resumed = false;
            let seconds = (stamp - before).as_secs();
            let way_m = (odom_from_before.inverse() * odometry.odom_from_base).translation.vector.norm();
            if !(0.0..=ODOMETER_PAUSE_S).contains(&seconds) || way_m > FASTEST_M_S * seconds {
                self.odometry = OdometryTrack::new();
                self.recent.clear();
            }
        }
        self.odometry.push(stamp, odometry);
        let at = self.recent.partition_point(|(t, _)| *t <= stamp);
        self.recent.insert(at, (stamp, odometry.odom_from_base));
        if self.recent.len() > MOST_READINGS {
            self.recent.pop_front();
        }
    }

    /// The odometer has spoken lately.
    pub fn hears_wheels(&self, stamp: Time) -> bool {
        self.odometry.stamp().is_some_and(|newest| (stamp - newest).as_secs() < SILENT_S)
    }

    /// The odometer's reading at a time; the identity without an odometer.
    pub fn odom_from_base(&self, stamp: Time) -> Pose2 {
        if self.odometry.stamp().is_some() { self.odometry.at(stamp) } else { Pose2::identity() }
    }

    /// The robot is here, and how it got here is nobody's business: no velocity follows from it.
    pub fn begin(&mut self, stamp: Time, map_from_base: &Pose2) {
        self.last = Some((stamp, *map_from_base));
        self.matched = None;
        self.velocity = None;
    }

    /// The robot is here, by a match or by the prediction itself. Only the way between two matches is a velocity: what a
    /// match corrects after a gap was no motion.
    pub fn arrived(&mut self, stamp: Time, map_from_base: &Pose2, is_matched: bool) {
        let before = self.last.filter(|(before, _)| is_matched && self.matched == Some(*before));
        if let Some((before, map_from_before)) = before {
            let seconds = (stamp - before).as_secs();
            let way = map_from_before.inverse() * map_from_base;
            self.velocity = if seconds > 0.0 && seconds <= VELOCITY_HOLDS_S {
                let turn = way.rotation.angle();
                // The chord of an arc points along its middle.
                let along = pose2(0.0, 0.0, -0.5 * turn) * way.translation.vector / seconds;
                Some(Twist { forward_m_s: along.x, left_m_s: along.y, turn_rad_s: turn / seconds })
            } else {
                None
            };
        }
        if is_matched {
            self.matched = Some(stamp);
        }
        self.last = Some((stamp, *map_from_base));
        while self.recent.get(1).is_some_and(|(next, _)| *next <= stamp) {
            self.recent.pop_front();
        }
    }

    /// How the robot moved from the last scan to this time.
    pub fn predict(&self, stamp: Time) -> Step {
        let Some((before, _)) = self.last else {
            let covariance = Matrix3::identity() * 1e-6;
            return Step { before_from_after: Pose2::identity(), covariance, is_by_odometer: false };
        };
        let seconds = (stamp - before).as_secs().max(0.0);
        let has_odometry = self.rule == PredictionRule::Odometry && self.odometry.stamp().is_some();
        let mut step =
            if has_odometry { self.by_odometry(before, stamp) } else { self.by_velocity(before, seconds) };
        let turned = (self.rule == PredictionRule::Odometry).then(|| self.turned(before, stamp)).flatten();
        if let Some(turn) = turned {
            let way = step.before_from_after.translation;
            step.before_from_after = pose2(way.x, way.y, turn);
            let deviation = self.errors.gyro_rad_s * seconds + self.errors.turn_share * 0.1 * turn.abs();
            step.covariance[(2, 2)] = deviation.powi(2) + self.errors.least[1].powi(2);
        }
        step
    }

    fn by_odometry(&self, before: Time, stamp: Time) -> Step {
        let before_from_after = self.odometry.at(before).inverse() * self.odometry.at(stamp);
        let way = before_from_after.translation.vector.norm();
        let turn = before_from_after.rotation.angle().abs();
        let e = &self.errors;
        let across = 0.5 * way * (e.turn_rad_m * way + e.turn_share * turn);
        let deviations = Vector3::new(
            e.way_share * way,
            e.way_share * way * 0.5 + across,
            e.turn_share * turn + e.turn_rad_m * way,
        );
        Step { before_from_after, covariance: self.with_least(deviations), is_by_odometer: true }
    }

    fn by_velocity(&self, before: Time, seconds: f64) -> Step {
        let age_s = self.matched.map_or(0.0, |matched| (before - matched).as_secs());
        let held_s = seconds.min((VELOCITY_HOLDS_S - age_s).max(0.0));
        let velocity = self.velocity.filter(|_| self.rule != PredictionRule::LastPose);
        let before_from_after = velocity.map_or_else(Pose2::identity, |velocity| velocity.integrate(held_s));
        let unknown = if velocity.is_none() { UNKNOWN_SPEED } else { [0.0, 0.0] };
        let e = &self.errors;
        let speed_change = e.acceleration_m_s2 * seconds + unknown[0];
        let turn_change = e.turn_acceleration_rad_s2 * seconds + unknown[1];
        let way = speed_change * seconds;
        let deviations = Vector3::new(way, way, turn_change * seconds);
        Step { before_from_after, covariance: self.with_least(deviations), is_by_odometer: false }
    }

    fn with_least(&self, deviations: Vector3<f64>) -> Matrix3<f64> {
        let [way, turn] = self.errors.least;
        let least = Vector3::new(way, way, turn);
        Matrix3::from_diagonal(&(deviations.component_mul(&deviations) + least.component_mul(&least)))
    }

    /// The gyroscope's turn, where it spoke all the time.
    fn turned(&self, before: Time, stamp: Time) -> Option<f64> {
        let first = self.rates_rad_s.partition_point(|(t, _)| *t <= before).saturating_sub(1);
        let (mut at, mut rate) = *self.rates_rad_s.get(first)?;
        if (before - at).as_secs().abs() > GYRO_GAP_S {
            return None;
        }
        at = at.max(before);
        let mut turn = 0.0;
        for (next, next_rate) in self.rates_rad_s.range(first + 1..) {
            let until = (*next).min(stamp);
            let seconds = (until - at).as_secs();
            if (*next - at).as_secs() > GYRO_GAP_S {
                return None;
            }
            turn += 0.5 * (rate + next_rate) * seconds.max(0.0);
            (at, rate) = (until, *next_rate);
            if *next >= stamp {
                return Some(wrap_angle(turn));
            }
        }
        let rest_s = (stamp - at).as_secs();
        (rest_s <= GYRO_GAP_S).then(|| wrap_angle(turn + rate * rest_s.max(0.0)))
    }
}
