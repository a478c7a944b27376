//! Speeds of the two wheels of the axle, from what the framework says of wheels and odometers.

use nalgebra::Vector2;
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::messages::WheelSpeeds;
use rumbo_core::robot::Drive;
use rumbo_core::time::Time;

/// Left and right speed of the fixed axle, m/s; none where there are not these wheels. A tricycle with three wheels says
/// its steered wheel first; four wheels are two a side.
pub(super) fn of_axle(wheels: &WheelSpeeds, drive: &Drive) -> Option<[f64; 2]> {
    let [a, b, c, d] = wheels.rim_m_s;
    match (drive, wheels.n_wheels) {
        (Drive::Differential { .. } | Drive::Tricycle { .. }, 2) => Some([a, b]),
        (Drive::Tricycle { .. }, 3) => Some([b, c]),
        (Drive::Differential { .. }, 4) => Some([(a + c) / 2.0, (b + d) / 2.0]),
        _ => None,
    }
}

/// The odometer's last reading.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Odometer {
    pub odom_from_base: Pose2,
    /// When it was; none where it came with the start.
    pub stamp: Option<Time>,
}

/// Means over the time between two readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeanMotion {
    /// Speed along the arc, m/s.
    pub forward_m_s: f64,
    /// Turn, rad/s.
    pub turn_rad_s: f64,
    /// That time, seconds.
    pub seconds: f64,
}

impl Odometer {
    /// Takes in a reading that is newer than the last; none after the first, and none for an old one.
    pub fn advance(&mut self, stamp: Time, odom_from_base: Pose2) -> Option<MeanMotion> {
        if self.stamp.is_some_and(|last| stamp <= last) {
            return None;
        }
        let before = std::mem::replace(self, Odometer { odom_from_base, stamp: Some(stamp) });
        let seconds = (stamp - before.stamp?).as_secs();
        let step = before.odom_from_base.inverse() * odom_from_base;
        let turn_rad = wrap_angle(step.rotation.angle());
        let half_rad = turn_rad / 2.0;
        // Along the chord of an arc, which is shorter than the arc.
        let along = step.translation.vector.dot(&Vector2::new(half_rad.cos(), half_rad.sin()));
        let way_m = if half_rad.abs() < 1e-6 { along } else { along * half_rad / half_rad.sin() };
        Some(MeanMotion { forward_m_s: way_m / seconds, turn_rad_s: turn_rad / seconds, seconds })
    }
}
