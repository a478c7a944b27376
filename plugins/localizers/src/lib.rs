//! Localizers of Rumbo.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod deviations;
pub mod ekf_landmarks;
pub mod ekf_lines;
pub mod gps_imu;
pub mod landmark_noise;
pub mod landmark_relaxation;
pub mod nav_filter;
pub mod number_faults;
pub mod odometry;
pub mod particle_filter;
pub mod prior;
pub mod recorded_pose;
pub mod scan_odometry;
pub mod triangulation;
