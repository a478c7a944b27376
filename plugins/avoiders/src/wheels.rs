//! The two wheels of a differential drive: Valverde Moreno (2015), equations 4.11 to 4.17.

use rumbo_core::frames::Twist;
use rumbo_core::robot::{Drive, Robot};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Speeds of the wheels over the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelPair {
    /// Left wheel, m/s.
    pub left_m_s: f64,
    /// Right wheel, m/s.
    pub right_m_s: f64,
}

/// What is done with wheels that should be faster than they can.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Saturation {
    /// Both are slowed by one factor: the curve stays.
    #[default]
    Scale,
    /// Each is cut by itself, as published: the curve gets wider.
    Clamp,
}

impl WheelPair {
    /// Both wheels alike.
    pub fn straight(speed_m_s: f64) -> WheelPair {
        WheelPair { left_m_s: speed_m_s, right_m_s: speed_m_s }
    }

    /// Turning in place, counter-clockwise for a positive speed of the right wheel.
    pub fn spin(right_m_s: f64) -> WheelPair {
        WheelPair { left_m_s: -right_m_s, right_m_s }
    }

    /// Equations 4.16 and 4.17 with a signed turn: `v_r = V (v + e/π)` and `v_l = V (v - e/π)`, not saturated.
    pub fn toward(full_m_s: f64, speed_factor: f64, turn_error_rad: f64) -> WheelPair {
        let turn = turn_error_rad / PI;
        WheelPair { left_m_s: full_m_s * (speed_factor - turn), right_m_s: full_m_s * (speed_factor + turn) }
    }

    /// Neither wheel faster than `most_m_s`.
    pub fn saturated(self, most_m_s: f64, saturation: Saturation) -> WheelPair {
        let WheelPair { left_m_s, right_m_s } = self;
        match saturation {
            Saturation::Clamp => WheelPair {
                left_m_s: left_m_s.clamp(-most_m_s, most_m_s),
                right_m_s: right_m_s.clamp(-most_m_s, most_m_s),
            },
            Saturation::Scale => {
                let fastest_m_s = left_m_s.abs().max(right_m_s.abs());
                let factor = if fastest_m_s > most_m_s { most_m_s / fastest_m_s } else { 1.0 };
                WheelPair { left_m_s: left_m_s * factor, right_m_s: right_m_s * factor }
            }
        }
    }

    /// Equations 4.11 and 4.12: `v = (v_r + v_l)/2`, `ω = (v_r - v_l)/b`.
    pub fn twist(self, track_m: f64) -> Twist {
        let WheelPair { left_m_s, right_m_s } = self;
        Twist::new((left_m_s + right_m_s) / 2.0, (right_m_s - left_m_s) / track_m)
    }
}

/// Distance between the wheels, meters; none for another drive.
pub fn track_m(robot: &Robot) -> Option<f64> {
    match robot.drive {
        Drive::Differential { track_m } => Some(track_m),
        _ => None,
    }
}

/// The twist as slow as the robot's limits want it, its curve kept.
///
/// Wheels that turn a Pioneer P3-DX in place at 1.2 m/s would turn it faster than it can: its 300 degrees/s are 0.864 m/s.
pub fn within_limits(twist: Twist, robot: &Robot) -> Twist {
    let by_speed = robot.max_speed_m_s / twist.speed_m_s().max(1e-12);
    let by_turn = robot.max_turn_rad_s() / twist.turn_rad_s.abs().max(1e-12);
    twist.scaled(by_speed.min(by_turn).min(1.0))
}

/// The fastest turn that still ends where it should, rad/s: wheels cannot stop a turn at once.
pub fn turn_in_time_rad_s(error_rad: f64, wanted_rad_s: f64, slowing_rad_s2: f64) -> f64 {
    let most_rad_s = (2.0 * slowing_rad_s2 * error_rad.abs()).sqrt();
    wanted_rad_s.clamp(-most_rad_s, most_rad_s)
}

/// A turn in place to look for a way: it can end while the way is still ahead.
pub fn searching(spin: Twist, robot: &Robot) -> Twist {
    const STILL_AHEAD_RAD: f64 = 0.5;
    let turn_rad_s = turn_in_time_rad_s(STILL_AHEAD_RAD, spin.turn_rad_s, robot.max_turn_accel_rad_s2());
    Twist { turn_rad_s, ..spin }
}

/// Wheels on the move: what they can do next.
#[derive(Debug, Clone, Copy)]
pub struct Wheels<'a> {
    /// The robot that they carry.
    pub robot: &'a Robot,
    /// What they were told last.
    pub last: Twist,
    /// Until they are told again, seconds.
    pub period_s: f64,
}

impl Wheels<'_> {
    /// As much of the change as motors and brakes do in one period, by the rule of the guard.
    pub fn reach(&self, wanted: Twist) -> Twist {
        let (robot, last) = (self.robot, self.last);
        let is_slower = wanted.speed_m_s() < last.speed_m_s();
        let brakes_m_s2 = robot.braking_m_s2.max(robot.max_accel_m_s2);
        let accel_m_s2 = if is_slower { brakes_m_s2 } else { robot.max_accel_m_s2 };
        let forward_m_s = wanted.forward_m_s - last.forward_m_s;
        let turn_rad_s = wanted.turn_rad_s - last.turn_rad_s;
        let by_speed = accel_m_s2 * self.period_s / forward_m_s.abs().max(1e-12);
        let by_turn = robot.max_turn_accel_rad_s2() * self.period_s / turn_rad_s.abs().max(1e-12);
        let part = by_speed.min(by_turn);
        if part >= 1.0 {
            return wanted;
        }
        Twist::new(last.forward_m_s + forward_m_s * part, last.turn_rad_s + turn_rad_s * part)
    }

    /// What is left of the motion after a period of braking.
    pub fn braked(&self) -> Twist {
        let slowed = |speed: f64, by: f64| speed.signum() * (speed.abs() - by * self.period_s).max(0.0);
        let brakes_m_s2 = self.robot.braking_m_s2.max(self.robot.max_accel_m_s2);
        Twist::new(
            slowed(self.last.forward_m_s, brakes_m_s2),
            slowed(self.last.turn_rad_s, self.robot.max_turn_accel_rad_s2()),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec_samples::rows;

    #[test]
    fn wheels_are_those_of_the_samples_before_and_after_saturation() {
        for row in rows(include_str!("../tests/data/dc_wheel_samples.csv")) {
            let of = |key: &str| row.number(key);
            let free = WheelPair::toward(1.2, of("speed_factor"), of("turn_error"));
            let clamped = free.saturated(1.2, Saturation::Clamp);
            let scaled = free.saturated(1.2, Saturation::Scale);
            for (wheels, name) in [(free, "unsaturated"), (clamped, "clamp"), (scaled, "scale")] {
                assert!((wheels.left_m_s - of(&format!("v_left_{name}"))).abs() < 1e-6, "{row:?}");
                assert!((wheels.right_m_s - of(&format!("v_right_{name}"))).abs() < 1e-6, "{row:?}");
            }
        }
    }

    #[test]
    fn a_pioneer_that_turns_in_place_has_wheels_of_864_mm_a_second() {
        let drive = Drive::Differential { track_m: 0.33 };
        let robot = Robot { drive, max_speed_m_s: 1.2, max_turn_deg_s: 300.0, ..Robot::default() };
        let twist = within_limits(WheelPair::spin(-1.2).twist(0.33), &robot);
        assert!((twist.turn_rad_s + 300f64.to_radians()).abs() < 1e-12 && twist.forward_m_s == 0.0);
        let wheel_m_s = twist.turn_rad_s.abs() * 0.33 / 2.0;
        assert!((wheel_m_s - 0.864).abs() < 5e-4, "{wheel_m_s}");
        let slow = Twist::new(0.3, -0.2);
        assert_eq!(within_limits(slow, &robot), slow);
    }
}
