//! Virtual scans as messages, in a level frame below or above the camera.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose3, flatten};
use rumbo_core::messages::{LaserScan, Observations};
use rumbo_kit::depth::{Beams, Depths, Rays, ScanError, ScanLimits, Scanned, SizeMismatch, VirtualScan};

/// Turned by less than this, radians, a camera is level.
const LEVEL_RAD: f64 = 1e-9;

/// A camera's mount in two parts: where its scans are (at the camera's place, level, towards where the camera looks), and
/// how the camera is tilted there.
pub(crate) fn level(base_from_camera: &Pose3) -> (Pose3, UnitQuaternion<f64>) {
    let yaw_rad = flatten(base_from_camera).rotation.angle();
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad);
    let tilt = turn.inverse() * base_from_camera.rotation;
    let tilt = if tilt.angle() < LEVEL_RAD { UnitQuaternion::identity() } else { tilt };
    (Pose3::from_parts(Translation3::from(base_from_camera.translation.vector), turn), tilt)
}

/// Makes scans of one camera's pictures.
#[derive(Debug, Clone)]
pub(crate) struct ScanMaker {
    scan: VirtualScan,
    first_bearing_rad: f64,
    bearing_step_rad: f64,
}

impl ScanMaker {
    /// With this many even beams over the camera's field of view, or as many as leave none empty.
    pub fn new(rays: Rays, limits: ScanLimits, n_beams: Option<usize>) -> Result<Self, ScanError> {
        let over = Beams::over(&rays);
        let beams = match (over, n_beams) {
            (Beams::Uniform { first_bearing_rad, bearing_step_rad, n_beams }, Some(wanted)) => {
                let spread_rad = bearing_step_rad * n_beams as f64;
                let step_rad = spread_rad / wanted as f64;
                let first_rad = first_bearing_rad + (step_rad - bearing_step_rad) / 2.0;
                Beams::Uniform { first_bearing_rad: first_rad, bearing_step_rad: step_rad, n_beams: wanted }
            }
            (over, _) => over,
        };
        let Beams::Uniform { first_bearing_rad, bearing_step_rad, .. } = beams else {
            // Scans as messages have even beams only.
            return Err(ScanError::Beams { n_beams: 0, step_rad: 0.0 });
        };
        let scan = VirtualScan::new(rays, limits, beams)?;
        Ok(Self { scan, first_bearing_rad, bearing_step_rad })
    }

    /// How the camera is tilted from now on, and how high it is, meters.
    pub fn face(&mut self, level_from_camera: &UnitQuaternion<f64>, camera_m: f64) {
        self.scan.face(level_from_camera, camera_m);
    }

    /// The scan of a picture. What is nearer than the least range reads 0: something is there, and no reading.
    pub fn message(
        &mut self,
        depths: Depths<'_>,
        out: &mut Observations,
    ) -> Result<(LaserScan, Scanned), SizeMismatch> {
        let mut ranges_m: Buffer<f32> = out.buffer(self.scan.bearings_rad().len());
        let scanned = self.scan.scan(depths, ranges_m.make_mut())?;
        // Messages have no ranges below zero, and so no negative infinity.
        for range_m in ranges_m.make_mut().iter_mut().filter(|range_m| **range_m < 0.0) {
            *range_m = 0.0;
        }
        let [least_m, most_m] = self.scan.limits().ranges_m;
        let scan = LaserScan {
            first_bearing_rad: self.first_bearing_rad,
            bearing_step_rad: self.bearing_step_rad,
            sweep_s: 0.0,
            min_range_m: least_m as f32,
            max_range_m: most_m as f32,
            ranges_m,
            intensities: Buffer::empty(),
        };
        Ok((scan, scanned))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_kit::depth::pinhole_of_view;

    fn mount(roll: f64, pitch: f64, yaw: f64) -> Pose3 {
        Pose3::from_parts(
            Translation3::new(0.1, 0.2, 0.3),
            UnitQuaternion::from_euler_angles(roll, pitch, yaw),
        )
    }

    #[test]
    fn a_mount_is_a_level_place_and_a_tilt() {
        for (roll, pitch, yaw) in [(0.0, 0.0, 2.0), (0.0, 0.3, -1.0), (0.2, -0.1, 3.1), (3.1, 0.0, 0.4)] {
            let mount = mount(roll, pitch, yaw);
            let (place, tilt) = level(&mount);
            assert!((place * tilt).rotation.angle_to(&mount.rotation) < 1e-8);
            assert_eq!(place.translation, mount.translation);
            let up = place.rotation * Vector3::z();
            assert!((up - Vector3::z()).norm() < 1e-12);
            let ahead = tilt * Vector3::x();
            assert!(ahead.y.abs() < 1e-9 && ahead.x > 0.0, "it looks along the scan's axis");
        }
        assert_eq!(level(&mount(0.0, 0.0, 2.0)).1, UnitQuaternion::identity(), "level is exactly level");
    }

    #[test]
    fn a_wanted_number_of_beams_covers_the_same_angle() {
        let rays = Rays::pinhole(&pinhole_of_view(64, 48, [0.5, 0.4])).unwrap();
        let limits = ScanLimits { heights_m: [0.0, 1.0], ranges_m: [0.2, 4.0], rows: None };
        let own = ScanMaker::new(rays.clone(), limits.clone(), None).unwrap();
        let n_own = own.scan.bearings_rad().len();
        let few = ScanMaker::new(rays, limits, Some(7)).unwrap();
        assert_eq!(few.scan.bearings_rad().len(), 7);
        let spread_own = own.bearing_step_rad * n_own as f64;
        assert!((few.bearing_step_rad * 7.0 - spread_own).abs() < 1e-12);
        let (first, last) = (few.first_bearing_rad, few.scan.bearings_rad()[6]);
        assert!((first + last).abs() < 1e-12, "symmetric");
    }
}
