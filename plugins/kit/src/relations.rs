//! How well poses keep known relations: the metric of Kuemmerle, Steder, Dornhege, Ruhnke, Grisetti, Stachniss and
//! Kleiner, "On measuring the accuracy of SLAM algorithms" (2009).
//!
//! A relation says how the robot really moved from one time to another. No common frame is needed, so that a bend in a
//! long corridor costs as much as it is bent, wherever it lies.

mod corrected_odometry;
mod file;

pub use corrected_odometry::{CorrectedOdometry, ODOMETRY_GAP};
pub use file::{Relation, read_relations};

use rumbo_core::frames::Pose3;
use rumbo_core::time::{Span, Time};

use crate::trajectory::Trajectory;

/// What a set of poses makes of a set of relations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RelationErrors {
    /// Lengths of the translation parts, meters.
    pub translation_m: Vec<f64>,
    /// Angles of the rotation parts, radians.
    pub rotation_rad: Vec<f64>,
    /// Relations without a pose at one of their stamps.
    pub n_missed: usize,
}

/// The errors `relation⁻¹ (pose1⁻¹ pose2)` (Kuemmerle et al. 2009, equation 4) of all relations for which `pose_at`
/// knows both poses.
pub fn relation_errors(
    relations: &[Relation],
    mut pose_at: impl FnMut(Time) -> Option<Pose3>,
) -> RelationErrors {
    let mut errors = RelationErrors::default();
    for relation in relations {
        let [from, to] = [pose_at(relation.from), pose_at(relation.to)];
        let Some((world_from_first, world_from_second)) = from.zip(to) else {
            errors.n_missed += 1;
            continue;
        };
        let first_from_second = world_from_first.inverse() * world_from_second;
        let error = relation.first_from_second.inverse() * first_from_second;
        errors.translation_m.push(error.translation.vector.norm());
        errors.rotation_rad.push(error.rotation.angle());
    }
    errors
}

/// The pose at a stamp, where there is one within `tolerance`.
pub fn pose_near(trajectory: &Trajectory, stamp: Time, tolerance: Span) -> Option<Pose3> {
    let nearest = trajectory.nearest(stamp)?;
    ((nearest.stamp - stamp).0.abs() <= tolerance.0).then_some(nearest.world_from_body)
}

#[cfg(test)]
mod tests;
