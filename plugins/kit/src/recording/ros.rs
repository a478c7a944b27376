//! Messages of ROS 2, as far as robots on wheels need them: written for viewers, read from bags.

pub mod layout;
mod read;
mod write;

pub use read::{RosData, RosMessage, read_ros, readable_schemas};
pub use write::{
    Stamped, put_cloud, put_grid, put_log, put_path, put_place, put_pose, put_scan, put_transforms, put_twist,
};
