//! Paths and obstacles.
#![allow(unsafe_code)]

use super::BadView;
use super::observation::slice;
use crate::boundary::abi::{rumbo_obstacle, rumbo_path_point, rumbo_point};
use crate::frames::Point2;
use crate::messages::{Obstacle, Path, PathPoint};
use crate::time::Time;

/// A point of the map.
pub(crate) fn point_of(point: &Point2) -> rumbo_point {
    rumbo_point { x_m: point.x, y_m: point.y }
}

/// The points of a path, one by one.
pub(crate) fn points_of(path: &Path) -> impl Iterator<Item = rumbo_path_point> + '_ {
    path.points()
        .iter()
        .map(|p| rumbo_path_point { position: point_of(&p.position), yaw_rad: p.yaw_rad.unwrap_or(f64::NAN) })
}

/// The path through points; none where there are none.
pub(crate) fn path_from(points: &[rumbo_path_point], cost: f64) -> Option<Path> {
    let point = |p: &rumbo_path_point| PathPoint {
        position: Point2::new(p.position.x_m, p.position.y_m),
        yaw_rad: (!p.yaw_rad.is_nan()).then_some(p.yaw_rad),
    };
    Path::new(points.iter().map(point).collect(), cost)
}

/// An obstacle.
pub(crate) fn obstacle_of(obstacle: &Obstacle) -> rumbo_obstacle {
    let position = point_of(&obstacle.position);
    rumbo_obstacle { position, radius_m: obstacle.radius_m, stamp_ns: obstacle.stamp.0 }
}

/// The obstacles behind a view, appended to `out`.
///
/// # Safety
/// `first` points to `len` obstacles.
pub(crate) unsafe fn obstacles_from(
    first: *const rumbo_obstacle,
    len: usize,
    out: &mut Vec<Obstacle>,
) -> Result<(), BadView> {
    // SAFETY: as promised by the caller.
    let obstacles = unsafe { slice(first, len)? };
    out.extend(obstacles.iter().map(|o| Obstacle {
        position: Point2::new(o.position.x_m, o.position.y_m),
        radius_m: o.radius_m,
        stamp: Time(o.stamp_ns),
    }));
    Ok(())
}
