//! `kinect`: depth cameras like the Microsoft Kinect, versions 1 and 2, or any other with known intrinsics.

mod eye;
mod model;
mod params;
mod plugin;

pub use model::{CameraModel, Projection};
pub use params::{CameraIntrinsics, Given, KinectParams};
pub use plugin::Kinect;
