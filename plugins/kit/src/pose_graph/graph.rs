//! The graph: poses and constraints, each of them checked.

use super::constraint::Constraint;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, is_finite2, pose2};

/// Why something was not taken into the graph.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GraphFault {
    /// A constraint of a pose that is not there.
    #[error("there is no pose {node}; the graph has {n_nodes}")]
    UnknownNode {
        /// Which.
        node: usize,
        /// How many there are.
        n_nodes: usize,
    },
    /// A constraint between a pose and itself.
    #[error("pose {node} is constrained by itself")]
    SelfEdge {
        /// Which.
        node: usize,
    },
    /// A number that is none.
    #[error("a pose or an information matrix is not finite")]
    NotFinite,
    /// An information matrix with a negative eigenvalue, or one that is not symmetric.
    #[error("an information matrix is not positive semidefinite (least eigenvalue {least})")]
    Indefinite {
        /// The eigenvalue.
        least: f64,
    },
    /// A robust kernel whose width is not above zero.
    #[error("the width of a robust kernel is not above zero")]
    Kernel,
}

/// Poses, and what is known between them.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseGraph {
    poses: Vec<Vector3<f64>>,
    fixed: Vec<bool>,
    constraints: Vec<Constraint>,
}

impl PoseGraph {
    /// Adds a pose and gives its number.
    ///
    /// # Errors
    /// When it is not finite.
    pub fn add_pose(&mut self, pose: &Pose2) -> Result<usize, GraphFault> {
        if !is_finite2(pose) {
            return Err(GraphFault::NotFinite);
        }
        self.poses.push(numbers(pose));
        self.fixed.push(false);
        Ok(self.poses.len() - 1)
    }

    /// Holds a pose where it is.
    ///
    /// # Errors
    /// When there is no such pose.
    pub fn fix(&mut self, node: usize) -> Result<(), GraphFault> {
        self.known(node)?;
        self.fixed.iter_mut().skip(node).take(1).for_each(|fixed| *fixed = true);
        Ok(())
    }

    /// Moves a pose.
    ///
    /// # Errors
    /// When there is no such pose, or it is not finite.
    pub fn set_pose(&mut self, node: usize, pose: &Pose2) -> Result<(), GraphFault> {
        self.known(node)?;
        if !is_finite2(pose) {
            return Err(GraphFault::NotFinite);
        }
        self.poses.iter_mut().skip(node).take(1).for_each(|old| *old = numbers(pose));
        Ok(())
    }

    /// Adds what is known between two poses, or of one.
    ///
    /// # Errors
    /// When it makes no sense; the graph is as before.
    pub fn add(&mut self, constraint: Constraint) -> Result<(), GraphFault> {
        self.known(constraint.to)?;
        if let Some(from) = constraint.from {
            self.known(from)?;
            if from == constraint.to {
                return Err(GraphFault::SelfEdge { node: from });
            }
        }
        check_information(&constraint.information)?;
        if !is_finite2(&constraint.from_to) {
            return Err(GraphFault::NotFinite);
        }
        if !constraint.kernel.is_valid() {
            return Err(GraphFault::Kernel);
        }
        self.constraints.push(constraint);
        Ok(())
    }

    /// Takes out the constraints that are not to be kept.
    pub fn retain(&mut self, keep: impl FnMut(&Constraint) -> bool) {
        self.constraints.retain(keep);
    }

    /// How many poses there are.
    pub fn n_nodes(&self) -> usize {
        self.poses.len()
    }

    /// A pose, if there is one of this number.
    pub fn pose(&self, node: usize) -> Option<Pose2> {
        self.poses.get(node).map(|v| pose2(v.x, v.y, v.z))
    }

    /// All poses: x, y, turn.
    pub fn poses(&self) -> &[Vector3<f64>] {
        &self.poses
    }

    /// All constraints.
    pub fn constraints(&self) -> &[Constraint] {
        &self.constraints
    }

    /// A constraint's squared error in units of its variance, at the poses as they are.
    pub fn chi2(&self, constraint: &Constraint) -> f64 {
        constraint.chi2(&constraint.error(&self.origin_of(constraint), &self.end_of(constraint)))
    }

    /// Cost at the poses as they are.
    pub fn cost(&self) -> f64 {
        self.constraints.iter().map(|constraint| constraint.kernel.cost(self.chi2(constraint))).sum()
    }

    pub(super) fn fixed(&self) -> &[bool] {
        &self.fixed
    }

    pub(super) fn swap_poses(&mut self, poses: &mut Vec<Vector3<f64>>) {
        std::mem::swap(&mut self.poses, poses);
    }

    pub(super) fn origin_of(&self, constraint: &Constraint) -> Vector3<f64> {
        constraint.from.map_or_else(Vector3::zeros, |from| self.numbers_of(from))
    }

    pub(super) fn end_of(&self, constraint: &Constraint) -> Vector3<f64> {
        self.numbers_of(constraint.to)
    }

    fn numbers_of(&self, node: usize) -> Vector3<f64> {
        self.poses.get(node).copied().unwrap_or_else(Vector3::zeros)
    }

    fn known(&self, node: usize) -> Result<(), GraphFault> {
        let n_nodes = self.poses.len();
        if node < n_nodes { Ok(()) } else { Err(GraphFault::UnknownNode { node, n_nodes }) }
    }
}

fn numbers(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}

/// Finite, symmetric, no negative eigenvalue.
fn check_information(information: &Matrix3<f64>) -> Result<(), GraphFault> {
    if !information.iter().all(|v| v.is_finite()) {
        return Err(GraphFault::NotFinite);
    }
    let size = information.amax();
    let asymmetry = (information - information.transpose()).amax();
    let least = information.symmetric_eigenvalues().min();
    if asymmetry > 1e-9 * size || least < -1e-9 * size {
        return Err(GraphFault::Indefinite { least });
    }
    Ok(())
}
