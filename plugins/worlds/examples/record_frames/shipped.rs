//! The recording that is shipped.

use std::path::Path;

use rumbo_core::frames::Twist;
use rumbo_core::messages::Intrinsics;
use rumbo_kit::depth_file::DepthEncoding;
use rumbo_kit::tum_rgbd::PlaceInSpace;
use rumbo_worlds::sim::Start;

use super::recorder::Recorder;

/// A look all around in the laboratory, a way along its cabinets, and another look around, with a small picture of a Kinect's
/// view (57 degrees), in whole millimeters.
pub fn recorder(pipelines: &Path) -> Recorder {
    const TURN_RAD_S: f64 = 0.5;
    let around = (Twist::new(0.0, TURN_RAD_S), std::f64::consts::TAU / TURN_RAD_S);
    let along = (Twist::new(0.35, 0.0), 7.5);
    let focal_px = 80.0 / 28.5_f64.to_radians().tan();
    Recorder {
        world: pipelines.join("worlds/laboratory.toml"),
        start: Start { x_m: 6.6, y_m: 3.4, yaw_deg: 90.0 },
        way: vec![around, along, around],
        mount: PlaceInSpace { x_m: 0.1, z_m: 0.4, ..PlaceInSpace::default() },
        intrinsics: Intrinsics { width: 160, height: 120, focal_px: [focal_px; 2], center_px: [79.5, 59.5] },
        encoding: DepthEncoding::Gray16,
        unit_m: 0.001,
        max_range_m: 8.0,
        interval_s: 0.5,
        begins_s: 1_000_000_000.0,
    }
}
