//! Which way is up in a world that is not level, and where its floor is.
//!
//! The world of KinectFusion is that of its first camera. A camera in a hand is held upright within some 30 degrees, and
//! floors and table tops are level: up is across the largest plane that the mean of the cameras' own ups allows.

use nalgebra::{Rotation3, Translation3, UnitQuaternion, Vector3};
use rumbo_core::frames::Pose3;
use rumbo_core::rng::stream;
use rumbo_kit::plane::{PlaneFit, PlaneSearch, largest_plane};
use rumbo_kit::tum_rgbd::camera_from_optical;

use crate::frames::{Frame, UNIT_M};
use rumbo_kit::depth::Rays;

/// A level map for a world that is not.
pub struct Level {
    /// z up from the lowest level layer, x along the first camera's view, the origin below it.
    pub map_from_world: Pose3,
    /// The plane that says what is level.
    pub fit: PlaneFit,
    /// Points that were looked at.
    pub n_points: usize,
    /// Height of that plane over the lowest layer, meters.
    pub plane_height_m: f64,
}

/// Every so many pixels of a picture.
const EVERY: usize = 331;
/// A camera sees farther only roughly, meters.
const FARTHEST_M: f64 = 3.5;
/// Below this share of all points nothing is level.
const LOWEST_SHARE: f64 = 0.01;

/// Levels a world by what its cameras saw; none without a plane.
pub fn level(rays: &Rays, frames: &[Frame]) -> Option<Level> {
    let world_from_camera = |frame: &Frame| frame.world_from_optical * camera_from_optical().inverse();
    let mut points_m = Vec::new();
    for frame in frames {
        for (pixel, count) in frame.picture.counts.iter().enumerate().step_by(EVERY) {
            let depth_m = f64::from(*count) * f64::from(UNIT_M);
            if depth_m > 0.3 && depth_m < FARTHEST_M {
                let point_m = rays.point(pixel % rays.n_columns(), pixel / rays.n_columns(), depth_m)?;
                points_m.push((world_from_camera(frame) * nalgebra::Point3::from(point_m)).coords);
            }
        }
    }
    let ups = frames.iter().map(|frame| world_from_camera(frame).rotation * Vector3::z());
    let search =
        PlaneSearch { tolerance_m: 0.02, n_trials: 4000, about: ups.sum(), within_rad: 30_f64.to_radians() };
    let fit = largest_plane(&points_m, &search, &mut stream(1, "level"))?;
    let up = fit.plane.normal;
    let mut heights_m: Vec<f64> = points_m.iter().map(|point| up.dot(point)).collect();
    heights_m.sort_by(f64::total_cmp);
    let floor_m = *heights_m.get((heights_m.len() as f64 * LOWEST_SHARE) as usize)?;
    let first = world_from_camera(frames.first()?);
    let ahead = first.rotation * Vector3::x();
    let ahead = (ahead - up * ahead.dot(&up)).try_normalize(1e-6)?;
    let axes = Rotation3::from_basis_unchecked(&[ahead, up.cross(&ahead), up]);
    let turn = UnitQuaternion::from_rotation_matrix(&axes.inverse());
    let below = turn * first.translation.vector;
    let map_from_world = Pose3::from_parts(Translation3::new(-below.x, -below.y, -floor_m), turn);
    let plane_height_m = fit.plane.offset_m - floor_m;
    Some(Level { map_from_world, fit, n_points: points_m.len(), plane_height_m })
}
