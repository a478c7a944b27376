//! Trajectories: where something was over time; read from files, paired by their stamps, aligned and compared.
//!
//! The errors are those of Sturm, Engelhard, Endres, Burgard and Cremers, "A benchmark for the evaluation of RGB-D SLAM
//! systems" (2012): absolute trajectory error after a closed-form alignment, and relative pose error over a step.

mod absolute_error;
mod alignment;
mod association;
mod error;
mod file;
mod format;
mod pose_line;
mod relative_error;
mod stamped;
pub(crate) mod table;

pub use absolute_error::absolute_errors;
pub use alignment::{Alignment, AlignmentError, Similarity, align};
pub use association::{PosePair, associate, pose_pairs};
pub use error::TrajectoryError;
pub use file::{TrajectoryFile, read_trajectory};
pub use format::TrajectoryFormat;
pub use relative_error::{PairChoice, RelativeErrors, Step, index_pairs, relative_errors};
pub use stamped::{Repairs, StampedPose, Trajectory};

#[cfg(test)]
mod tests;
