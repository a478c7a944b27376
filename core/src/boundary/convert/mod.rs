//! From the framework's types to those of the ABI and back; both sides use the same code.
//!
//! `lend` makes a view of something that the lender keeps, `..._from` reads a view. A view of a struct that grew, or
//! that has not grown yet, is read as far as both sides know it.

mod array;
mod basic;
mod estimate;
mod lend_observation;
mod manifest;
mod map;
mod observation;
mod path;
mod robot;

pub(super) use array::{BadArray, CArray, Hold};
pub(super) use basic::{
    cut_into, pose2_from, pose3_from, read, rumbo_pose2_of, rumbo_pose3_of, str_from, string_from, text_in,
    text_of, twist_from, twist_of, write_sized,
};
pub(super) use estimate::{
    EstimateLoan, estimate_from, lend_prior, prior_from, stamped_pose_from, stamped_pose_of,
};
pub(super) use lend_observation::{SeenLoan, intrinsics_of};
pub(super) use manifest::{layer_bits, layers_from, manifest_from, manifest_of};
pub(super) use map::{
    MapLoan, chunk_from, give_chunk, give_grid, grid_from, grid_of, map_from, optional_grid_from, pointer_to,
};
pub(super) use observation::{intrinsics_from, marks_from, observation_from, observations_from, slice};
pub(super) use path::{obstacle_of, obstacles_from, path_from, point_of, points_of};
pub(super) use robot::{RobotLoan, robot_from};

/// A view that does not hold together.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BadView(pub String);

impl BadView {
    pub(super) fn new(what: impl Into<String>) -> BadView {
        BadView(what.into())
    }
}
