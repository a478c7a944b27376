//! What the filter took in, and what is known between those scans: enough to draw a map of any way through them.

use super::follower::Followed;
use nalgebra::{Matrix3, Rotation3, Vector3};
use rumbo_core::frames::{Pose2, Pose3};
use rumbo_core::messages::LaserScan;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A scan that the filter took in.
#[derive(Debug, Clone, PartialEq)]
pub struct Taken {
    /// As it was seen.
    pub scan: LaserScan,
    /// From where.
    pub base_from_sensor: Pose3,
    /// It belongs into the map.
    pub is_drawn: bool,
    /// Of the step that led here: x, y, yaw in the axes of the step before.
    pub covariance: Matrix3<f64>,
}

/// A place that was recognized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Link {
    /// The step that saw it first.
    pub earlier: usize,
    /// The step that saw it again.
    pub later: usize,
    /// Inverse covariance of x, y, yaw of the later one, in its own axes.
    pub information: Matrix3<f64>,
}

/// All scans that were taken in, and places that were seen twice.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Archive {
    pub(super) taken: Vec<Taken>,
    pub(super) links: Vec<Link>,
}

/// A turn of one radian counts as much way, meters.
const TURN_AS_WAY_M: f64 = 0.5;

/// A matrix of x, y, yaw from the axes that the pose is seen in to its own.
pub(crate) fn turned_into(pose: &Pose2, matrix: &Matrix3<f64>) -> Matrix3<f64> {
    let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), pose.rotation.angle());
    let turned = turn.matrix().transpose() * matrix * turn.matrix();
    (turned + turned.transpose()) * 0.5
}

impl Archive {
    /// Steps so far.
    pub fn len(&self) -> usize {
        self.taken.len()
    }

    /// There is no step.
    pub fn is_empty(&self) -> bool {
        self.taken.is_empty()
    }

    /// Adds a scan with the step that led to it.
    pub fn push(&mut self, scan: &LaserScan, base_from_sensor: &Pose3, is_drawn: bool, followed: &Followed) {
        self.taken.push(Taken {
            scan: LaserScan { intensities: Vec::new().into(), ..scan.clone() },
            base_from_sensor: *base_from_sensor,
            is_drawn,
            covariance: followed.covariance,
        });
    }

    /// How long the shortest way from a step to each other one is, along the robot's way and through places that were
    /// recognized, meters.
    pub fn ways_from(&self, step: usize, way: &[Pose2]) -> Vec<f64> {
        let length_m = |a: usize, b: usize| {
            let (Some(a), Some(b)) = (way.get(a), way.get(b)) else { return f64::INFINITY };
            let off = a.inverse() * b;
            off.translation.vector.norm() + TURN_AS_WAY_M * off.rotation.angle().abs()
        };
        let mut linked = vec![Vec::new(); way.len()];
        for link in &self.links {
            for (from, to) in [(link.earlier, link.later), (link.later, link.earlier)] {
                linked.iter_mut().skip(from).take(1).for_each(|others| others.push(to));
            }
        }
        let mut ways = vec![f64::INFINITY; way.len()];
        let mut open = BinaryHeap::from([(Reverse(0u64), step)]);
        while let Some((Reverse(way_um), at)) = open.pop() {
            let way_m = way_um as f64 * 1e-6;
            match ways.get_mut(at) {
                Some(known) if way_m < *known => *known = way_m,
                _ => continue,
            }
            let beside = [at.checked_sub(1), Some(at + 1)].into_iter().flatten();
            for other in beside.chain(linked.get(at).into_iter().flatten().copied()) {
                let total_m = way_m + length_m(at, other);
                if ways.get(other).is_some_and(|known| total_m < *known) {
                    open.push((Reverse((total_m * 1e6) as u64), other));
                }
            }
        }
        ways
    }
}
