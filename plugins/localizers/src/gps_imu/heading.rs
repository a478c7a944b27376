//! The yaw of a robot that takes it from its inertial measurement unit as it is, and from its wheels in between.

use nalgebra::Rotation3;
use rumbo_core::frames::{Pose2, Pose3, wrap_angle};

/// A yaw with its variance; none before somebody has said it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Heading {
    /// Yaw (rad) and its variance (rad²).
    known: Option<(f64, f64)>,
}

impl Heading {
    /// At a start that somebody named.
    pub fn of(yaw_rad: f64, variance_rad2: f64) -> Heading {
        Heading { known: Some((yaw_rad, variance_rad2)) }
    }

    /// Yaw (rad) and its variance (rad²).
    pub fn known(&self) -> Option<(f64, f64)> {
        self.known
    }

    /// The wheels turned; `noise` is what they claim over a meter or radian.
    pub fn turn(&mut self, step: &Pose2, noise: [f64; 3]) {
        if let Some((yaw_rad, variance_rad2)) = &mut self.known {
            let (way_m, turn_rad) = (step.translation.vector.norm(), step.rotation.angle());
            *yaw_rad = wrap_angle(*yaw_rad + turn_rad);
            *variance_rad2 += noise[1].powi(2) * way_m + noise[2].powi(2) * turn_rad.abs();
        }
    }

    /// The unit says so.
    pub fn set(&mut self, yaw_rad: f64, variance_rad2: f64) {
        self.known = Some((wrap_angle(yaw_rad), variance_rad2));
    }

    /// It may have turned this far without anybody knowing.
    pub fn widen(&mut self, reach_rad: f64) {
        if let Some((_, variance_rad2)) = &mut self.known {
            *variance_rad2 += reach_rad * reach_rad;
        }
    }
}

/// The yaw of the base when a sensor that is mounted like this has this attitude (roll, pitch, yaw), radians.
pub(super) fn base_yaw_rad(attitude_rad: [f64; 3], base_from_sensor: &Pose3) -> f64 {
    let [roll, pitch, yaw] = attitude_rad;
    let map_from_sensor = Rotation3::from_euler_angles(roll, pitch, yaw);
    let map_from_base = map_from_sensor * base_from_sensor.rotation.to_rotation_matrix().inverse();
    let (_, _, yaw) = map_from_base.euler_angles();
    yaw
}
