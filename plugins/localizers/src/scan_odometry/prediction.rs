//! How the base probably moved from one scan to the next: what a match begins from.

use super::params::Prediction;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, Twist};
use rumbo_core::messages::{Imu, Odometry};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::{Span, Time};
use std::collections::VecDeque;

/// How the base probably moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Guess {
    /// The base after it, seen from before it.
    pub step: Pose2,
    /// Covariance of its x, y, yaw, beside what the velocity's own is.
    pub covariance: Matrix3<f64>,
    /// It is the velocity carried on.
    pub is_by_velocity: bool,
    /// Where a gyro told the turn: how far it may be off, rad/s.
    pub turn_deviation_rad_s: Option<f64>,
    /// The velocity is too old to be known.
    pub is_anywhere: bool,
}

/// What gyro, wheels and the velocity so far say of the motion.
#[derive(Debug)]
pub struct Motion {
    prediction: Prediction,
    /// A velocity is carried on for at most so long, seconds.
    carry_on_s: f64,
    /// How far a gyro may be off, rad/s.
    gyro_rad_s: f64,
    /// Turning rates about the vertical, rad/s, each up to the next.
    gyro: VecDeque<(Time, f64)>,
    wheels: OdometryTrack,
    wheel_noise: [f64; 3],
}

/// Long enough for a scan that is two seconds late at 200 readings a second.
const N_GYRO: usize = 400;

/// A rate holds for at most so long, seconds: a gap of the gyro is not bridged.
const GYRO_GAP_S: f64 = 0.2;

/// No robot turns as fast, rad/s: such a reading is wrong.
const FASTEST_TURN_RAD_S: f64 = 35.0;

/// What wheels may be off by in any case, meters and radians.
const WHEELS_FLOOR: [f64; 2] = [0.002, 0.002];

/// What a velocity carried on may be off by in any case, meters and radians: stamps are not exact, and real wheels jerk.
const CARRIED_FLOOR: [f64; 2] = [0.02, 0.02];

/// A turn by a gyro may be off by this in any case, radians.
const GYRO_FLOOR_RAD: f64 = 0.002;

impl Motion {
    /// Before anything was heard.
    pub fn new(prediction: Prediction, carry_on_s: f64, gyro_rad_s: f64) -> Motion {
        Motion {
            prediction,
            carry_on_s,
            gyro_rad_s,
            gyro: VecDeque::with_capacity(N_GYRO + 1),
            wheels: OdometryTrack::new(),
            wheel_noise: [0.0; 3],
        }
    }

    /// Takes in a reading of a gyro; whether it can be true and is used.
    pub fn take_imu(&mut self, stamp: Time, base_from_sensor: &Pose3, imu: &Imu) -> bool {
        let rate_rad_s = (base_from_sensor.rotation * Vector3::from(imu.rates_rad_s)).z;
        let is_new = self.gyro.back().is_none_or(|(last, _)| stamp > *last);
        if !(is_new && rate_rad_s.abs() <= FASTEST_TURN_RAD_S && self.prediction.has_gyro()) {
            return false;
        }
        self.gyro.push_back((stamp, rate_rad_s));
        if self.gyro.len() > N_GYRO {
            self.gyro.pop_front();
        }
        true
    }

    /// Takes in a reading of the wheels; whether they are looked at.
    pub fn take_wheels(&mut self, stamp: Time, odometry: &Odometry) -> bool {
        let is_used = self.prediction.has_wheels();
        if is_used {
            self.wheels.push(stamp, odometry);
            self.wheel_noise = odometry.noise;
        }
        is_used
    }

    /// The newest reading from which the robot can be predicted beyond the last scan.
    pub fn newest(&self) -> Option<Time> {
        match self.prediction {
            Prediction::Gyro => self.gyro.back().map(|(stamp, _)| *stamp),
            Prediction::Wheels | Prediction::Either => self.wheels.stamp(),
            Prediction::ConstantVelocity | Prediction::None => None,
        }
    }

    /// How the base moved within a time, where it had this velocity as of the last scan that matched, so long ago.
    pub fn guess(&self, from: Time, to: Time, twist: Twist, age: Option<Span>) -> Guess {
        if self.prediction.has_wheels() && self.wheels.stamp().is_some() {
            return self.guess_of_wheels(from, to);
        }
        self.guess_of_velocity(from, to, twist, age)
    }

    /// A second opinion on that, where one is asked for.
    pub fn other_guess(&self, from: Time, to: Time, twist: Twist, age: Option<Span>) -> Option<Guess> {
        let has_both = self.prediction == Prediction::Either && self.wheels.stamp().is_some();
        has_both.then(|| self.guess_of_velocity(from, to, twist, age))
    }

    fn guess_of_velocity(&self, from: Time, to: Time, twist: Twist, age: Option<Span>) -> Guess {
        let seconds = (to - from).as_secs().max(0.0);
        // A robot that nobody has seen for a while is taken to stand.
        let age_s = age.map_or(f64::INFINITY, Span::as_secs);
        let is_known = age_s < self.carry_on_s && self.prediction != Prediction::None;
        let carried_s = if is_known { seconds.min(self.carry_on_s - age_s.max(0.0)) } else { 0.0 };
        let [floor_m, floor_rad] = CARRIED_FLOOR;
        let mut guess = Guess {
            step: if is_known { twist.integrate(carried_s) } else { Pose2::identity() },
            covariance: diagonal(floor_m, floor_rad),
            is_by_velocity: true,
            turn_deviation_rad_s: None,
            is_anywhere: carried_s < seconds,
        };
        if seconds > 0.0
            && let Some(turn_rad) = self.turn_of_gyro(from, to)
        {
            // The way of the carried time on an arc of the whole turn.
            let carried = if is_known { twist.scaled(carried_s / seconds) } else { Twist::ZERO };
            guess.step = Twist { turn_rad_s: turn_rad / seconds, ..carried }.integrate(seconds);
            guess.turn_deviation_rad_s = Some(self.gyro_rad_s);
            guess.covariance = diagonal(floor_m, GYRO_FLOOR_RAD);
        }
        guess
    }

    fn guess_of_wheels(&self, from: Time, to: Time) -> Guess {
        let step = self.wheels.at(from).inverse() * self.wheels.at(to);
        let (way_m, turn_rad) = (step.translation.vector.norm(), step.rotation.angle().abs());
        let [distance, direction, turn] = self.wheel_noise;
        let deviation_rad = (direction * way_m).hypot(turn * turn_rad) + WHEELS_FLOOR[1];
        Guess {
            step,
            covariance: diagonal(distance * way_m + WHEELS_FLOOR[0], deviation_rad),
            is_by_velocity: false,
            turn_deviation_rad_s: None,
            is_anywhere: false,
        }
    }

    /// The turn by the gyro; none where it does not cover the time.
    fn turn_of_gyro(&self, from: Time, to: Time) -> Option<f64> {
        let after = self.gyro.partition_point(|(stamp, _)| *stamp <= from);
        let (mut at, mut sum_rad) = (from, 0.0);
        let (mut since, mut rate) = *self.gyro.get(after.checked_sub(1)?)?;
        for (stamp, next_rate) in self.gyro.iter().skip(after).chain([&(to, 0.0)]) {
            let until = (*stamp).min(to);
            if (until - since).as_secs() > GYRO_GAP_S {
                return None;
            }
            sum_rad += rate * (until - at).as_secs();
            (at, since, rate) = (until, *stamp, *next_rate);
            if *stamp >= to {
                break;
            }
        }
        Some(sum_rad)
    }
}

fn diagonal(deviation_m: f64, deviation_rad: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(deviation_m, deviation_m, deviation_rad).map(|v| v * v))
}
