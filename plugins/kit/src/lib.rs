//! What several Rumbo plugins share: ray casting, distance fields, grid search, map and world files, robot
//! logs, trajectories and how far two of them, or two maps, are apart.
//!
//! The grid kernels work on plain slices and sizes in cells, so they can be used without the framework.
#![cfg_attr(test, allow(clippy::unwrap_used, clippy::expect_used, clippy::panic))]

pub mod beam_table;
mod compounded;
pub mod correlative;
pub mod cost_field;
pub mod depth;
pub mod depth_file;
pub mod distance_field;
pub mod emulation;
pub mod generated_world;
pub mod grid_poses;
mod grid_size;
pub mod landmark_model;
pub mod landmarks;
pub mod likelihood_field;
pub mod line_filter;
pub mod lines;
pub mod log_file;
pub mod map_comparison;
pub mod map_file;
pub mod mark_file;
pub mod moving_clusters;
pub mod mrclam;
pub mod nav_filter;
pub mod normal;
pub mod occupancy;
pub mod odometry_history;
pub mod plane;
pub mod port;
pub mod pose_graph;
pub mod potential;
pub mod proximity;
pub mod ray;
pub mod recording;
pub mod relations;
pub mod resampling;
pub mod scan_match;
pub mod scan_odometry;
pub mod segment;
pub mod simd;
mod small_file;
pub mod spread;
pub mod streams;
pub mod tile_map;
pub mod trajectory;
pub mod tum_rgbd;
pub mod turn_way_turn;
pub mod wall_clock;
pub mod world_file;

pub use grid_size::{GridSize, NEIGHBORS_8};
