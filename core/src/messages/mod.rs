//! What flows between stages.
//!
//! Small parts by value, big arrays as [`Buffer`](crate::boundary::Buffer)s that are shared, never copied. Every
//! message can [`check`](Check::check) itself: not-a-number stops at the door where it came in.

mod check;
mod command;
mod estimate;
mod observation;
mod path;
mod person;
mod range;
mod sense;
mod stamped_pose;
mod vision;

pub use check::{Check, MessageFault};
pub use command::{Command, Goal, Prior};
pub use estimate::{Candidate, Estimate, Status, Wish};
pub use observation::{Data, Observation, ObservationKind, Observations, Seen, SensorId};
pub use path::{Obstacle, Path, PathPoint};
pub use person::PersonPosition;
pub use range::{Bumpers, LaserScan, RangeRing};
pub use sense::{Imu, Odometry, PositionFix, SteeringAngle, WheelSpeeds};
pub use stamped_pose::StampedPose;
pub use vision::{Custom, DepthImage, Intrinsics, Mark, Marks, PointCloud};
