//! `recorded_pose`: the robot is where a file says that it was, so that maps can be built from poses that are known.

pub mod follower;
mod params;
mod plugin;

#[cfg(test)]
mod tests;

pub use params::RecordedPoseParams;
pub use plugin::RecordedPose;
