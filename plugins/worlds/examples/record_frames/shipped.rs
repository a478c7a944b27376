//! The recording that is shipped.

use std::path::Path;

use rumbo_core::frames::Twist;
use rumbo_core::messages::Intrinsics;
use rumbo_kit::depth_file::DepthEncoding;
use rumbo_kit::tum_rgbd::PlaceInSpace;
use rumbo_worlds::sim::Start;

use super::recorder::Recorder;

/// Once around the table of the laboratory, with a small picture of a Kinect's view (57 degrees), in whole millimeters.
pub fn recorder(pipelines: &Path) -> Recorder {
    const RADIUS_M: f64 = 1.75;
    const SPEED_M_S: f64 = 0.35;
    let around = Twist::new(SPEED_M_S, SPEED_M_S / RADIUS_M);
    let half_turn_s = std::f64::consts::PI * RADIUS_M / SPEED_M_S;
    let focal_px = 80.0 / 28.5_f64.to_radians().tan();
    Recorder {
        world: pipelines.join("worlds/laboratory.toml"),
        start: Start { x_m: 5.75, y_m: 4.4, yaw_deg: 90.0 },
        way: vec![(around, 2.0 * half_turn_s)],
        mount: PlaceInSpace { x_m: 0.1, z_m: 0.4, ..PlaceInSpace::default() },
        intrinsics: Intrinsics {
            width: 160,
            height: 120,
            focal_px: [focal_px; 2],
            center_px: [79.5, 59.5],
        },
        encoding: DepthEncoding::Gray16,
        unit_m: 0.001,
        max_range_m: 8.0,
        interval_s: 0.5,
        begins_s: 1_000_000_000.0,
    }
}
