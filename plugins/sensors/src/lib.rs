//! Sensors of Rumbo: each owns its device's truth (geometry, resolution, range, noise, dropouts).
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod attitude_filter;
pub mod bumper_ring;
pub mod depth_to_scan;
pub mod gps;
pub mod imu;
pub mod kinect;
pub mod laser_2d;
pub mod lms200;
pub mod mark_camera;
pub mod person_tracker;
pub mod sonar_ring;
pub mod stabilized_scan;
pub mod steering_encoder;
pub mod wheel_encoders;

mod blindness;
mod live_news;
mod recorded;
#[cfg(test)]
mod test_world;
mod text_device;
mod text_line;
mod tilt;
mod virtual_scan;
