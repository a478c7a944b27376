//! What some steps saw.

use crate::graph_slam::surface::{SurfaceLimits, SurfacePoint, Turn, surface_of};
use crate::rbpf_slam::archive::Archive;
use rumbo_core::frames::Pose2;

/// The surfaces that some steps saw, seen from one of them.
pub(super) fn surfaces(
    archive: &Archive,
    way: &[Pose2],
    steps: impl Iterator<Item = usize>,
    seen_from: usize,
    limits: &SurfaceLimits,
) -> Vec<SurfacePoint> {
    let Some(here) = way.get(seen_from).map(Pose2::inverse) else { return Vec::new() };
    let mut points = Vec::new();
    for step in steps {
        let (Some(taken), Some(pose)) = (archive.taken.get(step), way.get(step)) else { continue };
        if taken.is_drawn {
            let turn = Turn::new(&(here * pose));
            let surface = surface_of(&taken.scan, &taken.base_from_sensor, limits);
            points.extend(surface.iter().map(|point| point.seen_from(&turn)));
        }
    }
    points
}
