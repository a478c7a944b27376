//! Speeds of the two wheels of the axle, from what the framework says of wheels and odometers.

use nalgebra::Vector2;
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::messages::WheelSpeeds;
use rumbo_core::robot::Drive;
use rumbo_core::time::{Span, Time};

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

/// A mean over the time between two readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct MeanSpeeds {
    /// Of the left and the right wheel, m/s.
    pub wheels_m_s: [f64; 2],
    /// The middle of that time, for which the mean is right as long as the acceleration is constant.
    pub middle: Time,
}

impl Odometer {
    /// Takes in a reading that is newer than the last; none after the first, and none for an old one.
    pub fn advance(&mut self, stamp: Time, odom_from_base: Pose2, half_track_m: f64) -> Option<MeanSpeeds> {
        if self.stamp.is_some_and(|last| stamp <= last) {
            return None;
        }
        let before = std::mem::replace(self, Odometer { odom_from_base, stamp: Some(stamp) });
        let last = before.stamp?;
        let elapsed = stamp - last;
        let step = before.odom_from_base.inverse() * odom_from_base;
        let turn_rad = wrap_angle(step.rotation.angle());
        let half_rad = turn_rad / 2.0;
        // Along the chord of an arc, which is shorter than the arc.
        let along = step.translation.vector.dot(&Vector2::new(half_rad.cos(), half_rad.sin()));
        let way_m = if half_rad.abs() < 1e-6 { along } else { along * half_rad / half_rad.sin() };
        let (speed, turn) = (way_m / elapsed.as_secs(), turn_rad / elapsed.as_secs());
        Some(MeanSpeeds {
            wheels_m_s: [speed - half_track_m * turn, speed + half_track_m * turn],
            middle: last + Span(elapsed.0 / 2),
        })
    }
}
