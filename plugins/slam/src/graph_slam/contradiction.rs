//! Do two scans deny each other? A thing where the other one saw free space, from where both are said to have been taken.
//!
//! How well a scan lies on others tells little of a robot that was carried along a corridor: its walls fit everywhere. What
//! stands where there was nothing, and what is gone that was there, tells more.

use super::surface::{Surface, Turn};
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;

/// A scan with its points, seen from the base.
#[derive(Debug, Clone, Copy)]
pub(super) struct View<'a> {
    pub scan: &'a LaserScan,
    pub base_from_sensor: &'a Pose3,
    pub surface: &'a Surface,
}

/// Narrower views are not judged by what they deny: what a depth camera sees of low things changes with how far away they are,
/// and a robot that waited for a good fit would have turned away from all that it could be registered on.
const NARROW_RAD: f64 = std::f64::consts::FRAC_PI_2;

impl View<'_> {
    /// Too narrow to be judged by what it does not see.
    pub fn is_narrow(&self) -> bool {
        self.scan.bearing_step_rad.abs() * (self.scan.ranges_m.len() as f64) < NARROW_RAD
    }
}

/// A point is in free space when it lies nearer than the readings beside it by this, meters; and by this share of the way.
const MARGIN_M: f64 = 0.3;
const MARGIN_SHARE: f64 = 0.05;

/// Share of the points of both views, of those that the other one could see, that lie where it saw free space.
pub(super) fn denied_share(one: &View<'_>, other: &View<'_>, one_from_other: &Pose2) -> f64 {
    let (a, b) =
        (in_free_space(one, other, one_from_other), in_free_space(other, one, &one_from_other.inverse()));
    let (n_denied, n_judged) = (a[0] + b[0], a[1] + b[1]);
    n_denied as f64 / n_judged.max(1) as f64
}

/// How many points of `other` lie in the free space of `one`, and how many lie where it looked at all.
fn in_free_space(one: &View<'_>, other: &View<'_>, one_from_other: &Pose2) -> [usize; 2] {
    let axes = one.base_from_sensor.rotation.euler_angles().2;
    let origin = one.base_from_sensor.translation;
    let turn = Turn::new(&(pose2(origin.x, origin.y, axes).inverse() * one_from_other));
    let step_rad = one.scan.bearing_step_rad;
    let mut counts = [0; 2];
    for point in other.surface.iter() {
        let [x, y] = turn.place(point.at).map(f64::from);
        let beam = ((y.atan2(x) - one.scan.first_bearing_rad) / step_rad).round();
        let beam = if beam < 0.0 { beam + std::f64::consts::TAU / step_rad.abs() } else { beam };
        let Some(free_m) = free_along(one.scan, beam) else { continue };
        let range_m = x.hypot(y);
        let is_denied = range_m < free_m - MARGIN_M - MARGIN_SHARE * range_m;
        counts = [counts[0] + usize::from(is_denied), counts[1] + 1];
    }
    counts
}

/// How far the beam and its neighbors saw nothing; none where one of them has no reading.
fn free_along(scan: &LaserScan, beam: f64) -> Option<f64> {
    let middle = (beam >= 1.0).then_some(beam as usize)?;
    let around = scan.ranges_m.get(middle - 1..middle + 2)?;
    let is_hit = |range_m: &f32| *range_m >= scan.min_range_m && *range_m <= scan.max_range_m;
    around.iter().all(is_hit).then(|| around.iter().copied().fold(f32::INFINITY, f32::min).into())
}
