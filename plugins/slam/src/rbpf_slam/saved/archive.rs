//! The scans that were taken in, as bytes.

use super::{State, put, put_count};
use crate::rbpf_slam::archive::{Archive, Link, Taken};
use nalgebra::{Matrix3, Quaternion, Translation3, UnitQuaternion};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::LaserScan;

pub(super) fn put_archive(bytes: &mut Vec<u8>, archive: &Archive) {
    put_count(bytes, archive.taken.len());
    for Taken { scan, base_from_sensor, is_drawn, covariance } in &archive.taken {
        put(bytes, &[scan.first_bearing_rad, scan.bearing_step_rad, scan.sweep_s]);
        [scan.min_range_m, scan.max_range_m].iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        put_count(bytes, scan.ranges_m.len());
        scan.ranges_m.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
        put(bytes, base_from_sensor.translation.vector.as_slice());
        put(bytes, base_from_sensor.rotation.coords.as_slice());
        put_count(bytes, usize::from(*is_drawn));
        put(bytes, covariance.as_slice());
    }
    put_count(bytes, archive.links.len());
    for link in &archive.links {
        put_count(bytes, link.earlier);
        put_count(bytes, link.later);
        put(bytes, link.information.as_slice());
    }
}

impl State<'_> {
    /// Of so many steps.
    pub(super) fn archive(&mut self, n_steps: usize) -> Option<Archive> {
        let taken = self.many(Self::taken).filter(|taken| taken.len() == n_steps)?;
        let link = |state: &mut Self| {
            let (earlier, later) = (state.count()?, state.count()?);
            let information = Matrix3::from_column_slice(&state.numbers::<9>()?);
            (earlier < later && later < n_steps).then_some(Link { earlier, later, information })
        };
        let links = self.many(link)?;
        Some(Archive { taken, links })
    }

    fn taken(&mut self) -> Option<Taken> {
        let [first_bearing_rad, bearing_step_rad, sweep_s] = self.numbers()?;
        let (min_range_m, max_range_m) = (self.single()?, self.single()?);
        // A reading may be infinite or none.
        let ranges_m = self.many(|state| state.0.chunk().map(f32::from_le_bytes))?.into();
        let intensities = Vec::new().into();
        let scan = LaserScan {
            first_bearing_rad,
            bearing_step_rad,
            sweep_s,
            min_range_m,
            max_range_m,
            ranges_m,
            intensities,
        };
        let [x, y, z] = self.numbers()?;
        let [i, j, k, w] = self.numbers()?;
        let quaternion = Quaternion::new(w, i, j, k);
        let is_rotation = (quaternion.norm() - 1.0).abs() < 1e-6;
        let rotation = is_rotation.then(|| UnitQuaternion::new_unchecked(quaternion))?;
        let base_from_sensor = Pose3::from_parts(Translation3::new(x, y, z), rotation);
        let is_drawn = self.count()? > 0;
        let covariance = Matrix3::from_column_slice(&self.numbers::<9>()?);
        Some(Taken { scan, base_from_sensor, is_drawn, covariance })
    }
}
