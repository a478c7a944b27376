//! `mark_camera`: a camera that recognizes marks and measures range and bearing to them.

mod noise;
mod params;
mod plugin;

pub use noise::MarkNoise;
pub use params::MarkCameraParams;
pub use plugin::MarkCamera;
