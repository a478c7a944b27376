//! What a depth camera in the middle of the robot shows of the hall, whose walls have no end above.

use super::text_world::TextWorld;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::{DepthImage, Intrinsics};

/// 57 degrees across; symmetric, so that its mirror image is one of the same camera.
const CAMERA: Intrinsics =
    Intrinsics { width: 48, height: 12, focal_px: [44.2, 44.2], center_px: [23.5, 5.5] };
const REACH_M: f64 = 10.0;

/// Without noise, in millimeters.
pub fn depth_picture(world: &TextWorld, map_from_base: &Pose2) -> DepthImage {
    let counts = |column: u32| {
        let bearing_rad = ((CAMERA.center_px[0] - f64::from(column)) / CAMERA.focal_px[0]).atan();
        let range_m = world.range_m(&(map_from_base * pose2(0.0, 0.0, bearing_rad)), REACH_M);
        if range_m.is_finite() { (range_m * bearing_rad.cos() * 1000.0).round() as u16 } else { 0 }
    };
    let row: Vec<u16> = (0..CAMERA.width).map(counts).collect();
    let depth: Buffer<u16> = row.repeat(CAMERA.height as usize).into();
    DepthImage { intrinsics: CAMERA, unit_m: 0.001, depth }
}

/// The picture in the mirror.
pub fn mirrored(image: &mut DepthImage) {
    let n_columns = image.intrinsics.width as usize;
    image.depth.make_mut().chunks_exact_mut(n_columns).for_each(<[u16]>::reverse);
}
