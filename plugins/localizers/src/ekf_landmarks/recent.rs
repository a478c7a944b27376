//! The marks that were seen in the last moments, kept by the odometer: together they tell where a robot is that was lost.

use std::collections::BTreeMap;

use nalgebra::{Matrix2, Vector2};
use rumbo_core::frames::Pose2;
use rumbo_core::time::{Span, Time};

use super::sighting::Sighting;

/// A sighting in the odometer's frame.
#[derive(Debug, Clone, Copy)]
struct Kept {
    stamp: Time,
    odom_from_base: Pose2,
    odom_from_sensor: Pose2,
    measured: Vector2<f64>,
    noise: Matrix2<f64>,
}

/// The newest sighting of each identity.
#[derive(Debug, Default)]
pub struct Recent {
    by_identity: BTreeMap<u32, Kept>,
}

impl Recent {
    /// Older sightings are forgotten.
    const KEPT: Span = Span(5_000_000_000);
    /// Wrong identities have no end of them.
    const MOST: usize = 64;

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.by_identity.clear();
    }

    /// A sighting from where the base is now in the odometer's frame.
    pub fn keep(&mut self, stamp: Time, identity: u32, sighting: &Sighting, odom_from_base: &Pose2) {
        self.by_identity.retain(|_, kept| stamp - kept.stamp <= Self::KEPT);
        if self.by_identity.len() >= Self::MOST && !self.by_identity.contains_key(&identity) {
            return;
        }
        let kept = Kept {
            stamp,
            odom_from_base: *odom_from_base,
            odom_from_sensor: odom_from_base * sighting.base_from_sensor,
            measured: sighting.measured,
            noise: sighting.noise,
        };
        self.by_identity.insert(identity, kept);
    }

    /// All of them as if seen from where the base is now; `noise` is the odometer's, and makes sightings from farther
    /// away less sure.
    pub fn seen_from(&self, odom_from_base: &Pose2, noise: [f64; 3]) -> Vec<(u32, Sighting)> {
        let from_here = |(identity, kept): (&u32, &Kept)| {
            let step = kept.odom_from_base.inverse() * odom_from_base;
            let (way_m, turn_rad) = (step.translation.vector.norm(), step.rotation.angle().abs());
            let [distance, direction, turn] = noise;
            let turned_rad2 = direction.powi(2) * way_m + turn.powi(2) * turn_rad;
            let moved_m2 = distance.powi(2) * way_m + turned_rad2 * way_m.powi(2);
            // A sideways error of the way turns the bearing, the more the nearer the mark is.
            let bearing_rad2 = turned_rad2 + moved_m2 / kept.measured.x.max(0.1).powi(2);
            let extra = Matrix2::new(moved_m2, 0.0, 0.0, bearing_rad2);
            let sighting = Sighting {
                measured: kept.measured,
                noise: kept.noise + extra,
                base_from_sensor: odom_from_base.inverse() * kept.odom_from_sensor,
            };
            (*identity, sighting)
        };
        self.by_identity.iter().map(from_here).collect()
    }
}
