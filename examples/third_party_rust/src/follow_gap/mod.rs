//! Reactive avoidance in the manner of Sezer and Gokasan, *A novel obstacle avoidance algorithm: "Follow the Gap Method"*
//! (Robotics and Autonomous Systems, 2012).
//!
//! Differs from the paper: gaps are searched with the robot's width on the way ahead, not as angles between two obstacles,
//! so that a gap is never too narrow; and the goal is a point on the planner's path.

mod gaps;
mod params;
mod plugin;
mod route;

pub use params::FollowGapParams;
