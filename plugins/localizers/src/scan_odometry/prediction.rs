//! How the base probably moved from one scan to the next: what a match begins from.

use super::params::Prediction;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, Pose3, Twist};
use rumbo_core::messages::{Imu, Odometry};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::Time;
use std::collections::VecDeque;

/// How far predictions may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionNoise {
    /// A velocity is carried on for at most so long, seconds.
    pub carry_on_s: f64,
    /// Of a speed, m/s.
    pub speed_m_s: f64,
    /// Of a turn without a gyro, rad/s.
    pub turn_rad_s: f64,
    /// Of a gyro, rad/s.
    pub gyro_rad_s: f64,
    /// What the robot can do: m/s and rad/s.
    pub fastest: [f64; 2],
}

/// What gyro, wheels and the scans so far say of the motion.
#[derive(Debug)]
pub struct Motion {
    noise: MotionNoise,
    prediction: Prediction,
    /// Turning rates about the vertical, rad/s, each up to the next.
    gyro: VecDeque<(Time, f64)>,
    wheels: OdometryTrack,
    wheel_noise: [f64; 3],
    /// Between the last two scans that matched.
    twist: Twist,
    /// When the twist was true.
    twist_stamp: Option<Time>,
}

/// Long enough for a scan that is two seconds late at 200 readings a second.
const N_GYRO: usize = 400;

/// A rate holds for at most so long, seconds: a gap of the gyro is not bridged.
const GYRO_GAP_S: f64 = 0.2;

/// No robot turns as fast, rad/s: such a reading is wrong.
const FASTEST_TURN_RAD_S: f64 = 35.0;

/// What wheels may be off by in any case, meters and radians.
const WHEELS_FLOOR: [f64; 2] = [0.002, 0.002];

impl Motion {
    /// Before anything was heard.
    pub fn new(prediction: Prediction, noise: MotionNoise) -> Motion {
        Motion {
            noise,
            prediction,
            gyro: VecDeque::with_capacity(N_GYRO + 1),
            wheels: OdometryTrack::new(),
            wheel_noise: [0.0; 3],
            twist: Twist::ZERO,
            twist_stamp: None,
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

    /// The step between the last two scans, if they matched.
    pub fn learn(&mut self, step: &Pose2, from: Time, to: Time) {
        let seconds = (to - from).as_secs();
        if seconds <= 0.0 {
            return;
        }
        // A step of an arc: the way along the chord is that of the twist turned by half of it.
        let turn_rad = step.rotation.angle();
        let half_rad = turn_rad / 2.0;
        let longer = if half_rad.abs() < 1e-6 { 1.0 } else { half_rad / half_rad.sin() };
        let way = nalgebra::UnitComplex::new(-half_rad) * step.translation.vector * longer;
        self.twist =
            Twist { forward_m_s: way.x / seconds, left_m_s: way.y / seconds, turn_rad_s: turn_rad / seconds };
        self.twist_stamp = Some(to);
    }

    /// The newest reading from which the robot can be predicted beyond the last scan.
    pub fn newest(&self) -> Option<Time> {
        match self.prediction {
            Prediction::Gyro => self.gyro.back().map(|(stamp, _)| *stamp),
            Prediction::Wheels | Prediction::Either => self.wheels.stamp(),
            Prediction::ConstantVelocity | Prediction::None => None,
        }
    }

    /// The base after a time seen from the base before it, with the covariance of x, y, yaw.
    pub fn step(&self, from: Time, to: Time) -> (Pose2, Matrix3<f64>) {
        if self.prediction.has_wheels() && self.wheels.stamp().is_some() {
            return self.step_of_wheels(from, to);
        }
        self.step_of_velocity(from, to)
    }

    /// A second opinion on that, where one is asked for.
    pub fn other_step(&self, from: Time, to: Time) -> Option<(Pose2, Matrix3<f64>)> {
        let has_both = self.prediction == Prediction::Either && self.wheels.stamp().is_some();
        has_both.then(|| self.step_of_velocity(from, to))
    }

    fn step_of_velocity(&self, from: Time, to: Time) -> (Pose2, Matrix3<f64>) {
        let seconds = (to - from).as_secs().max(0.0);
        // As of the last match; a robot that nobody has seen since then is taken to stand after a while.
        let age_s = self.twist_stamp.map_or(f64::INFINITY, |stamp| (from - stamp).as_secs());
        let is_known = age_s < self.noise.carry_on_s && self.prediction != Prediction::None;
        let mut twist = if is_known { self.twist } else { Twist::ZERO };
        let carried_s = if is_known { seconds.min(self.noise.carry_on_s - age_s.max(0.0)) } else { 0.0 };
        let [fastest_m_s, fastest_rad_s] = self.noise.fastest;
        let mut deviation_m = self.noise.speed_m_s * carried_s + fastest_m_s * (seconds - carried_s);
        let mut deviation_rad = self.noise.turn_rad_s * carried_s + fastest_rad_s * (seconds - carried_s);
        if self.twist_stamp.is_none() {
            (deviation_m, deviation_rad) = (fastest_m_s * seconds, fastest_rad_s * seconds);
        }
        let step = match self.turn_of_gyro(from, to) {
            Some(turn_rad) => {
                deviation_rad = self.noise.gyro_rad_s * seconds;
                // The way of the carried time on an arc of the whole turn.
                if seconds > 0.0 {
                    twist = Twist { turn_rad_s: turn_rad / seconds, ..twist.scaled(carried_s / seconds) };
                }
                twist.integrate(seconds)
            }
            None => twist.integrate(carried_s),
        };
        (step, diagonal(deviation_m, deviation_rad))
    }

    fn step_of_wheels(&self, from: Time, to: Time) -> (Pose2, Matrix3<f64>) {
        let step = self.wheels.at(from).inverse() * self.wheels.at(to);
        let (way_m, turn_rad) = (step.translation.vector.norm(), step.rotation.angle().abs());
        let [distance, direction, turn] = self.wheel_noise;
        let deviation_rad = (direction * way_m).hypot(turn * turn_rad) + WHEELS_FLOOR[1];
        (step, diagonal(distance * way_m + WHEELS_FLOOR[0], deviation_rad))
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
