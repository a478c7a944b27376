//! How a body pitches, by the middle columns of a depth camera: a scan in an upright plane.
//!
//! Arroyo Sánchez 2013, section 5.1: a horizontal and a vertical slice together tell a change of range that is due to
//! inclination from travel. Slices are registered as scans are; what turns from one to the next is the pitch. Small errors
//! would add up, so the pitch goes back to level within a while: it is that of a body that sways, not of a slope.

use super::odometer::ScanOdometer;
use super::points::ScanPoints;
use super::settings::ScanOdometrySettings;
use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use rumbo_core::frames::{Pose2, Pose3, flatten};
use rumbo_core::messages::DepthImage;
use rumbo_core::time::Time;

/// Columns on each side of the picture's middle that make one slice: the median of each row.
const HALF_COLUMNS: usize = 2;

/// Within so long a pitch goes back to level (to a share of 1/e), seconds.
const LEVELS_WITHIN_S: f64 = 15.0;

/// No picture says anything about later than this, seconds.
const HOLDS_S: f64 = 0.2;

/// How far a step from one slice to the next may be off: meters a second, and radians a second.
const FASTEST: [f64; 2] = [1.0, 1.0];

/// Follows the pitch of a body from slice to slice.
#[derive(Debug, Clone)]
pub struct SlicePitch {
    /// In the upright plane: x along the camera's heading, y up; a turn to the left is a pitch up.
    odometer: ScanOdometer,
    heading_rad: f64,
    pitch_rad: f64,
    rate_rad_s: f64,
    stamp: Option<Time>,
}

impl Default for SlicePitch {
    fn default() -> Self {
        let settings = ScanOdometrySettings {
            min_points: 15,
            // Keys last long: a body that only sways comes back to the same one, without any drift.
            key_distance_m: 0.3,
            key_angle_rad: 0.5,
            key_overlap: 0.5,
            range_noise_m: 0.02,
            ..ScanOdometrySettings::default()
        };
        SlicePitch {
            odometer: ScanOdometer::new(settings, Pose2::identity(), Matrix3::zeros()),
            heading_rad: 0.0,
            pitch_rad: 0.0,
            rate_rad_s: 0.0,
            stamp: None,
        }
    }
}

impl SlicePitch {
    /// Takes in a picture of a camera on this mount; whether it said how the body pitched. One that is not newer than the
    /// last is left out.
    pub fn take(&mut self, stamp: Time, image: &DepthImage, base_from_camera: &Pose3) -> bool {
        let seconds = match self.stamp {
            Some(last) if stamp <= last => return false,
            Some(last) => (stamp - last).as_secs(),
            None => 0.0,
        };
        self.stamp = Some(stamp);
        self.heading_rad = flatten(base_from_camera).rotation.angle();
        let step = Pose2::rotation(-self.rate_rad_s * seconds.min(HOLDS_S));
        let deviations = Vector3::new(FASTEST[0], FASTEST[0], FASTEST[1]) * seconds;
        let covariance = Matrix3::from_diagonal(&deviations.map(|v| v * v + 1e-6));
        let heading_rad = self.heading_rad;
        let place = |points: &mut ScanPoints| place_slice(points, image, base_from_camera, heading_rad);
        let taken = self.odometer.take_placed(place, &step, &covariance);
        let is_good = taken.matched.status.is_good() && !taken.matched.unobserved[2];
        let turn_rad = if is_good { -taken.last_from_base.rotation.angle() } else { 0.0 };
        self.rate_rad_s = if is_good && seconds > 0.0 { turn_rad / seconds } else { 0.0 };
        self.pitch_rad = (self.pitch_rad + turn_rad) * (-seconds / LEVELS_WITHIN_S).exp();
        is_good
    }

    /// How the body is pitched at a time, radians: positive looks down along the camera's heading.
    pub fn pitch_rad(&self, at: Time) -> f64 {
        let Some(stamp) = self.stamp else { return 0.0 };
        let ahead_s = (at - stamp).as_secs().clamp(-HOLDS_S, HOLDS_S);
        self.pitch_rad + self.rate_rad_s * ahead_s
    }

    /// The body in the level frame below it, at a time.
    pub fn level_from_base(&self, at: Time) -> Pose3 {
        let (sine, cosine) = self.heading_rad.sin_cos();
        let left = Vector3::new(-sine, cosine, 0.0);
        Pose3::from_parts(
            nalgebra::Translation3::identity(),
            UnitQuaternion::from_scaled_axis(left * self.pitch_rad(at)),
        )
    }
}

/// Places the middle of a picture in the upright plane along this heading of the base.
fn place_slice(points: &mut ScanPoints, image: &DepthImage, base_from_camera: &Pose3, heading_rad: f64) {
    let (sine, cosine) = heading_rad.sin_cos();
    let flat = |at: Vector3<f64>| [cosine * at.x + sine * at.y, at.z];
    let camera = &image.intrinsics;
    let (width, [fx, fy], [cx, cy]) = (camera.width as usize, camera.focal_px, camera.center_px);
    points.clear(flat(base_from_camera.translation.vector));
    let middle = (cx.max(0.0) as usize).min(width.saturating_sub(1));
    let columns = middle.saturating_sub(HALF_COLUMNS)..(middle + HALF_COLUMNS + 1).min(width);
    for (row, line) in image.depth.chunks_exact(width.max(1)).enumerate() {
        let Some(counts) = line.get(columns.clone()) else { continue };
        let Some(count) = median(counts) else { continue };
        let ahead_m = f64::from(count) * f64::from(image.unit_m);
        let across_m = -(middle as f64 - cx) / fx * ahead_m;
        let in_camera = nalgebra::Point3::new(ahead_m, across_m, -(row as f64 - cy) / fy * ahead_m);
        points.push(flat((base_from_camera * in_camera).coords));
    }
}

/// The middle one of the readings; none where fewer than half are readings.
fn median(counts: &[u16]) -> Option<u16> {
    let mut sorted = [0; 2 * HALF_COLUMNS + 1];
    let mut n = 0;
    for (place, count) in sorted.iter_mut().zip(counts.iter().filter(|count| **count > 0)) {
        *place = *count;
        n += 1;
    }
    let read = sorted.get_mut(..n)?;
    read.sort_unstable();
    if 2 * n > counts.len() { read.get(n / 2).copied() } else { None }
}
