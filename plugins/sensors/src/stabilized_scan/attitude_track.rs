//! How the base was tilted over the last moments.

use crate::tilt::{without_yaw, world_from_base};
use nalgebra::{UnitQuaternion, Vector3};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::Imu;
use rumbo_core::time::{Span, Time};
use std::collections::VecDeque;

/// One attitude of the base.
#[derive(Debug, Clone, Copy)]
struct Attitude {
    stamp: Time,
    world_from_base: UnitQuaternion<f64>,
    /// Of the base, in its own frame.
    rates_rad_s: Vector3<f64>,
}

/// The attitude at a time.
#[derive(Debug, Clone, Copy)]
pub struct AttitudeThen {
    /// Roll and pitch of the base, without yaw.
    pub stabilized_from_base: UnitQuaternion<f64>,
    /// How fast the base turned, in its own frame, rad/s.
    pub rates_rad_s: Vector3<f64>,
    /// From the nearest measured attitude.
    pub age: Span,
}

/// The attitudes of the last moments, oldest first.
#[derive(Debug, Default)]
pub struct AttitudeTrack {
    track: VecDeque<Attitude>,
}

impl AttitudeTrack {
    /// More than half a second of the fastest devices.
    const LENGTH: usize = 512;

    /// Rates say nothing about later than this, seconds.
    const CARRY_ON_S: f64 = 0.1;

    /// Takes in a reading of a device on this mount. Returns whether it has an attitude and is newer than what is known.
    pub fn push(&mut self, stamp: Time, base_from_imu: &Pose3, imu: &Imu) -> bool {
        let Some(world_from_base) = world_from_base(base_from_imu, imu) else { return false };
        let rates_rad_s = base_from_imu.rotation * Vector3::from(imu.rates_rad_s);
        let is_finite = world_from_base.coords.iter().chain(rates_rad_s.iter()).all(|v| v.is_finite());
        if !is_finite || self.track.back().is_some_and(|last| last.stamp >= stamp) {
            return false;
        }
        if self.track.len() >= Self::LENGTH {
            self.track.pop_front();
        }
        self.track.push_back(Attitude { stamp, world_from_base, rates_rad_s });
        true
    }

    /// The attitude at a time: in between, or the first one, or the last one carried on by its rates.
    pub fn at(&self, time: Time) -> Option<AttitudeThen> {
        let after = self.track.partition_point(|attitude| attitude.stamp <= time);
        let before = after.checked_sub(1).and_then(|idx| self.track.get(idx));
        let (world_from_base, nearest) = match (before, self.track.get(after)) {
            (Some(a), Some(b)) => {
                let share = (time - a.stamp).as_secs() / (b.stamp - a.stamp).as_secs();
                let turn = (a.world_from_base.inverse() * b.world_from_base).scaled_axis() * share;
                let nearest = if share < 0.5 { a } else { b };
                (a.world_from_base * UnitQuaternion::from_scaled_axis(turn), nearest)
            }
            (Some(last), None) => {
                let seconds = (time - last.stamp).as_secs().min(Self::CARRY_ON_S);
                let turn = UnitQuaternion::from_scaled_axis(last.rates_rad_s * seconds);
                (last.world_from_base * turn, last)
            }
            (None, Some(first)) => (first.world_from_base, first),
            (None, None) => return None,
        };
        Some(AttitudeThen {
            stabilized_from_base: without_yaw(&world_from_base),
            rates_rad_s: nearest.rates_rad_s,
            age: Span((time - nearest.stamp).0.abs()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn imu(roll_rad: f64, pitch_rad: f64, yaw_rad: f64) -> Imu {
        Imu { attitude_rad: Some([roll_rad, pitch_rad, yaw_rad]), ..Imu::default() }
    }

    fn angles(then: &AttitudeThen) -> [f64; 3] {
        let (roll, pitch, yaw) = then.stabilized_from_base.euler_angles();
        [roll, pitch, yaw]
    }

    #[test]
    fn between_two_attitudes_it_is_in_between_and_yaw_is_left_out() {
        let mut track = AttitudeTrack::default();
        assert!(track.at(Time::ZERO).is_none());
        let seat = Pose3::identity();
        assert!(track.push(Time::from_secs(1.0), &seat, &imu(0.0, 0.2, 3.1)));
        assert!(track.push(Time::from_secs(2.0), &seat, &imu(0.0, -0.2, 3.1)));
        assert!(!track.push(Time::from_secs(2.0), &seat, &imu(0.0, 9.0, 0.0)), "not newer");
        assert!(!track.push(Time::from_secs(3.0), &seat, &Imu::default()), "no attitude");
        for (seconds, pitch, age_s) in [(0.5, 0.2, 0.5), (1.25, 0.1, 0.25), (1.75, -0.1, 0.25)] {
            let then = track.at(Time::from_secs(seconds)).unwrap();
            let [roll, found, yaw] = angles(&then);
            assert!(roll.abs() < 1e-12 && yaw.abs() < 1e-12 && (found - pitch).abs() < 1e-12, "{seconds}");
            assert!((then.age.as_secs() - age_s).abs() < 1e-9);
        }
    }

    #[test]
    fn after_the_last_attitude_its_rates_carry_it_on_for_a_while() {
        let mut track = AttitudeTrack::default();
        let turning = Imu { rates_rad_s: [0.0, 0.5, 0.0], ..imu(0.0, 0.1, 0.0) };
        track.push(Time::from_secs(1.0), &Pose3::identity(), &turning);
        assert!((angles(&track.at(Time::from_secs(1.04)).unwrap())[1] - 0.12).abs() < 1e-12);
        assert!((angles(&track.at(Time::from_secs(9.0)).unwrap())[1] - 0.15).abs() < 1e-12);
    }

    #[test]
    fn a_device_that_is_mounted_turned_tells_the_base_all_the_same() {
        let mut track = AttitudeTrack::default();
        let turned = Pose3::from_parts(
            nalgebra::Translation3::identity(),
            UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2),
        );
        // The device looks to the left: the base's pitch of 0.3 is its roll, the other way round.
        let world_from_imu = UnitQuaternion::from_euler_angles(0.0, 0.3, 1.0) * turned.rotation;
        let (roll, pitch, yaw) = world_from_imu.euler_angles();
        let reading = Imu { rates_rad_s: [1.0, 0.0, 0.0], ..imu(roll, pitch, yaw) };
        track.push(Time::ZERO, &turned, &reading);
        let then = track.at(Time::ZERO).unwrap();
        assert!((angles(&then)[1] - 0.3).abs() < 1e-12 && angles(&then)[0].abs() < 1e-12);
        assert!((then.rates_rad_s - Vector3::y()).norm() < 1e-12);
    }

    #[test]
    fn memory_is_bounded() {
        let mut track = AttitudeTrack::default();
        for k in 0..5000 {
            track.push(Time(k), &Pose3::identity(), &imu(0.0, 0.0, 0.0));
        }
        assert_eq!(track.track.len(), AttitudeTrack::LENGTH);
    }
}
