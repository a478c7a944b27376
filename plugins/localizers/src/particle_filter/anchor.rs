//! The last word of the filter, and how the odometer carries it on.

use super::beams::ScanBeams;
use super::clusters::Cluster;
use super::sureness::candidates;
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Estimate, Status};
use rumbo_core::time::Time;

/// Where the robot was at the last update of the filter.
#[derive(Debug, Clone)]
pub struct Anchor {
    /// The heaviest cluster's mean.
    pub map_from_base: Pose2,
    /// Its covariance.
    pub covariance: Matrix3<f64>,
    /// What the odometer said there.
    pub odom_from_base: Pose2,
    /// Time of the last scan that was weighed.
    pub stamp: Option<Time>,
    /// Scans that were weighed, as seen from the base.
    pub scans: Vec<ScanBeams>,
    /// All clusters, the heaviest first.
    pub clusters: Vec<Cluster>,
    /// Share of their beams that the map explains from here.
    pub explained: Option<f64>,
}

impl Anchor {
    /// Where the robot should be when the odometer says this, with the covariance as it was.
    pub fn expected_at(&self, odom_from_base: &Pose2) -> (Pose2, Matrix3<f64>) {
        (self.map_from_base * (self.odom_from_base.inverse() * odom_from_base), self.covariance)
    }

    /// Where the robot is when the odometer says `odom_from_base`; `noise` is what the odometer claims of itself, standard
    /// deviations of distance (m/m), direction (rad/m) and turn (rad/rad).
    pub fn carried_to(
        &self,
        (stamp, odom_from_base): (Time, Pose2),
        noise: [f64; 3],
        status: Status,
    ) -> Estimate {
        let way = self.odom_from_base.inverse() * odom_from_base;
        let moved = |pose: &Pose2| pose * way;
        let covariance = self.covariance + Self::strayed(&way, noise);
        let mut estimate = Estimate::planar(stamp, moved(&self.map_from_base), odom_from_base, covariance);
        estimate.status = status;
        if status == Status::Ambiguous {
            estimate.candidates = candidates(&self.clusters);
            estimate
                .candidates
                .iter_mut()
                .for_each(|place| place.map_from_base = moved(&place.map_from_base));
        }
        estimate
    }

    /// What the odometer's own errors add on the way since the last update.
    fn strayed(way: &Pose2, noise: [f64; 3]) -> Matrix3<f64> {
        let (way_m, turn_rad) = (way.translation.vector.norm(), way.rotation.angle().abs());
        let [longer, aside, turned] = noise;
        let place_m = way_m * longer.hypot(aside * way_m);
        let yaw_rad = (way_m * aside).hypot(turn_rad * turned);
        Matrix3::from_diagonal(&nalgebra::Vector3::new(place_m, place_m, yaw_rad).map(|v| v * v))
    }
}
