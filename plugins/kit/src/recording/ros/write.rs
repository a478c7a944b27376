//! Copies of a run in ROS 2's messages, for viewers.

use crate::recording::cdr::CdrWriter;
use nalgebra::Matrix6;
use rumbo_core::frames::{Pose2, Pose3, Twist, lift};
use rumbo_core::map::{Grid, GridHeader};
use rumbo_core::messages::{LaserScan, Path, PointCloud};
use rumbo_core::time::Time;
use std::ops::Range;

/// When, and in which frame.
#[derive(Debug, Clone, Copy)]
pub struct Stamped<'a> {
    /// When.
    pub stamp: Time,
    /// In which frame.
    pub frame: &'a str,
}

fn put_time(cdr: &mut CdrWriter, time: Time) {
    const SECOND: i64 = 1_000_000_000;
    cdr.i32(i32::try_from(time.0.div_euclid(SECOND)).unwrap_or(i32::MAX));
    cdr.u32(u32::try_from(time.0.rem_euclid(SECOND)).unwrap_or(0));
}

fn put_stamped(cdr: &mut CdrWriter, at: Stamped<'_>) {
    put_time(cdr, at.stamp);
    cdr.text(at.frame);
}

fn put_pose3(cdr: &mut CdrWriter, pose: &Pose3) {
    let (t, q) = (&pose.translation, &pose.rotation);
    cdr.array(&[t.x, t.y, t.z, q.i, q.j, q.k, q.w]);
}

/// A planar scan; where its ranges and intensities stand.
pub fn put_scan(cdr: &mut CdrWriter, at: Stamped<'_>, scan: &LaserScan) -> Range<usize> {
    put_stamped(cdr.begin(), at);
    let n_steps = scan.ranges_m.len().saturating_sub(1);
    let per_step = if n_steps > 0 { scan.sweep_s / n_steps as f64 } else { 0.0 };
    cdr.f32(scan.first_bearing_rad as f32);
    cdr.f32(scan.bearing_rad(n_steps) as f32);
    cdr.f32(scan.bearing_step_rad as f32);
    cdr.f32(per_step as f32);
    cdr.f32(scan.sweep_s as f32);
    cdr.f32(scan.min_range_m);
    cdr.f32(scan.max_range_m);
    let start = cdr.bytes().len();
    cdr.f32s(&scan.ranges_m);
    cdr.f32s(&scan.intensities);
    start..cdr.bytes().len()
}

/// Points in space; where their numbers stand.
pub fn put_cloud(cdr: &mut CdrWriter, at: Stamped<'_>, cloud: &PointCloud) -> Range<usize> {
    /// `sensor_msgs/PointField.FLOAT32`.
    const FLOAT32: u8 = 7;
    const POINT_BYTES: usize = 12;
    put_stamped(cdr.begin(), at);
    let n_points = cloud.points_m.len();
    cdr.u32(1);
    cdr.length(n_points);
    cdr.length(3);
    for (name, offset) in [("x", 0), ("y", 4), ("z", 8)] {
        cdr.text(name);
        cdr.u32(offset);
        cdr.u8(FLOAT32);
        cdr.u32(1);
    }
    cdr.bool(false);
    cdr.length(POINT_BYTES);
    cdr.length(POINT_BYTES * n_points);
    // Four octets each, aligned behind their length as numbers are.
    cdr.length(POINT_BYTES * n_points);
    let start = cdr.bytes().len();
    cdr.array32(cloud.points_m.as_flattened());
    let end = cdr.bytes().len();
    cdr.bool(false);
    start..end
}

/// A place and its covariance of x, y, z, roll, pitch, yaw.
pub fn put_pose(cdr: &mut CdrWriter, at: Stamped<'_>, pose: &Pose3, covariance: &Matrix6<f64>) {
    put_stamped(cdr.begin(), at);
    put_pose3(cdr, pose);
    // ROS counts along rows, nalgebra along columns; a covariance is its own transpose.
    cdr.array(covariance.as_slice());
}

/// A place.
pub fn put_place(cdr: &mut CdrWriter, at: Stamped<'_>, pose: &Pose3) {
    put_stamped(cdr.begin(), at);
    put_pose3(cdr, pose);
}

/// A path; without one an empty path, which viewers draw as none.
pub fn put_path(cdr: &mut CdrWriter, at: Stamped<'_>, path: Option<&Path>) {
    put_stamped(cdr.begin(), at);
    let points = path.map_or(&[][..], Path::points);
    cdr.length(points.len());
    for point in points {
        put_stamped(cdr, at);
        let pose = Pose2::new(point.position.coords, point.yaw_rad.unwrap_or(0.0));
        put_pose3(cdr, &lift(&pose));
    }
}

/// A map of cells: 0 free, 100 occupied, -1 unknown.
pub fn put_grid(cdr: &mut CdrWriter, at: Stamped<'_>, grid: &Grid) {
    const UNKNOWN: u8 = u8::MAX;
    put_stamped(cdr.begin(), at);
    put_time(cdr, at.stamp);
    cdr.f32(grid.resolution_m() as f32);
    cdr.u32(grid.width());
    cdr.u32(grid.height());
    put_pose3(cdr, &lift(&grid.map_from_grid()));
    // As `Grid::class_of`, with both bounds at hand: the compiler takes many cells at once.
    let GridHeader { occupied_above, free_below, .. } = *grid.header();
    cdr.octets_of(grid.cells.iter().map(move |log_odds| {
        let free_or_unknown = if *log_odds < free_below { 0 } else { UNKNOWN };
        if *log_odds > occupied_above { 100 } else { free_or_unknown }
    }));
}

/// Where frames are: parent, child, and `parent_from_child`.
pub fn put_transforms(cdr: &mut CdrWriter, stamp: Time, transforms: &[(&str, &str, Pose3)]) {
    cdr.begin().length(transforms.len());
    for (parent, child, parent_from_child) in transforms {
        put_stamped(cdr, Stamped { stamp, frame: parent });
        cdr.text(child);
        put_pose3(cdr, parent_from_child);
    }
}

/// A velocity.
pub fn put_twist(cdr: &mut CdrWriter, at: Stamped<'_>, twist: &Twist) {
    put_stamped(cdr.begin(), at);
    cdr.array(&[twist.forward_m_s, twist.left_m_s, 0.0]);
    cdr.array(&[0.0, 0.0, twist.turn_rad_s]);
}

/// A line of a log.
pub fn put_log(cdr: &mut CdrWriter, stamp: Time, is_trouble: bool, text: &str) {
    /// `rcl_interfaces/Log.INFO` and `WARN`.
    const LEVELS: [u8; 2] = [20, 30];
    put_time(cdr.begin(), stamp);
    cdr.u8(LEVELS[usize::from(is_trouble)]);
    cdr.text("rumbo");
    cdr.text(text);
    cdr.text("");
    cdr.text("");
    cdr.u32(0);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::map::CellClass;

    #[test]
    fn cells_are_what_the_grid_takes_them_for() {
        let mut grid = Grid::unknown(5, 3, 0.1).unwrap();
        let GridHeader { occupied_above, free_below, .. } = *grid.header();
        let odds =
            [occupied_above, free_below, 0.0, 9.0, -9.0, f32::NAN, occupied_above + 0.1, free_below - 0.1];
        grid.cells.make_mut().iter_mut().zip(odds.into_iter().cycle()).for_each(|(cell, odds)| *cell = odds);
        let mut cdr = CdrWriter::default();
        put_grid(&mut cdr, Stamped { stamp: Time::ZERO, frame: "map" }, &grid);
        let expected: Vec<u8> = grid
            .cells
            .iter()
            .map(|odds| match grid.class_of(*odds) {
                CellClass::Free => 0,
                CellClass::Occupied => 100,
                CellClass::Unknown => 255,
            })
            .collect();
        assert!(cdr.bytes().ends_with(&expected), "{:?}", cdr.bytes());
    }
}
