//! From a device's picture to what the sensor gives of it.

use rumbo_core::frames::Pose3;
use rumbo_core::messages::{Data, DepthImage, Intrinsics, Observation, Observations, PointCloud, SensorId};
use rumbo_core::time::Time;
use rumbo_kit::depth::{
    Counting, Depths, HeightBand, MedianFilter, NearMemory, NearRule, Rays, RaysError, ScanError, ScanLimits,
    SizeMismatch, points,
};

use super::Projection;
use crate::blindness::Blindness;
use crate::virtual_scan::{ScanMaker, level};

/// How pictures are read.
#[derive(Debug, Clone)]
pub(super) struct EyeSettings {
    pub sensor: SensorId,
    pub base_from_camera: Pose3,
    pub projection: Projection,
    pub near_plane_m: f64,
    pub max_range_m: f64,
    pub heights_m: [f64; 2],
    pub n_beams: Option<usize>,
    pub slice_rows: Option<usize>,
    pub has_median: bool,
    /// A region that loses its readings below this is occupied; none where that is switched off.
    pub near_m: Option<f64>,
    pub closing_m_s: f64,
    pub gives_scan: bool,
    pub gives_points: bool,
    pub gives_picture: bool,
}

/// A picture that cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub(super) enum EyeError {
    #[error(transparent)]
    Rays(#[from] RaysError),
    #[error(transparent)]
    Scan(#[from] ScanError),
    #[error(transparent)]
    Size(#[from] SizeMismatch),
}

/// Reads pictures.
#[derive(Debug)]
pub(super) struct Eye {
    settings: EyeSettings,
    base_from_scan: Pose3,
    band: HeightBand,
    blindness: Blindness,
    lens: Lens,
    median: MedianFilter,
    near: NearMemory,
    newest: Option<Time>,
    /// The picture while it is worked on, and what it is filtered from.
    counts: Vec<u16>,
    unfiltered: Vec<u16>,
}

/// What depends on the camera that made the picture.
#[derive(Debug)]
struct Lens {
    camera: Intrinsics,
    rays: Rays,
    scan: ScanMaker,
}

impl Eye {
    pub fn new(settings: EyeSettings, camera: &Intrinsics, blindness: Blindness) -> Result<Eye, EyeError> {
        let lens = Lens::new(&settings, camera)?;
        let (base_from_scan, _) = level(&settings.base_from_camera);
        let band = HeightBand::of_mount(&settings.base_from_camera, settings.heights_m);
        Ok(Eye {
            settings,
            base_from_scan,
            band,
            blindness,
            lens,
            median: MedianFilter::default(),
            near: NearMemory::default(),
            newest: None,
            counts: Vec::new(),
            unfiltered: Vec::new(),
        })
    }

    /// Where scans are: at the camera, level.
    pub fn base_from_scan(&self) -> Pose3 {
        self.base_from_scan
    }

    /// Gives what is to be given of a picture that was made at this time.
    pub fn see(&mut self, stamp: Time, image: &DepthImage, out: &mut Observations) -> Result<(), EyeError> {
        if self.lens.camera != image.intrinsics {
            self.lens = Lens::new(&self.settings, &image.intrinsics)?;
            self.near = NearMemory::default();
        }
        let n_valid = self.prepare(image)?;
        let mut n_filled = 0;
        let elapsed_s = self.newest.map_or(0.0, |newest| (stamp - newest).as_secs());
        self.newest = Some(stamp);
        if let Some(near_m) = self.settings.near_m {
            let rule = NearRule {
                near_m,
                least_m: self.settings.near_plane_m,
                closing_m_s: self.settings.closing_m_s,
                unit_m: image.unit_m.into(),
            };
            n_filled = self.near.fill(&self.lens.rays, &self.band, &rule, elapsed_s, &mut self.counts)?;
        }
        // A camera right before a wall has no readings, and knows why.
        let share = (n_valid + n_filled) as f64 / image.depth.len() as f64;
        let is_blind = self.blindness.is_blind(share);
        self.give(stamp, !is_blind, image, out)
    }

    /// Filters the picture, keeps what is too near at the near plane, drops what is too far, and counts readings.
    fn prepare(&mut self, image: &DepthImage) -> Result<usize, EyeError> {
        let unit_m = f64::from(image.unit_m);
        let nearest = (self.settings.near_plane_m / unit_m).ceil().clamp(1.0, f64::from(u16::MAX)) as u16;
        // A rounding of the unit must not cut the farthest count.
        let farthest = (self.settings.max_range_m / unit_m + 1e-3).floor().min(f64::from(u16::MAX)) as u16;
        let mut n_valid = 0;
        self.counts.clear();
        self.counts.extend(image.depth.iter().map(|count| {
            let is_valid = *count > 0 && *count <= farthest;
            n_valid += usize::from(is_valid);
            if is_valid { (*count).max(nearest) } else { 0 }
        }));
        if self.settings.has_median {
            self.unfiltered.clone_from(&self.counts);
            self.median.filter(self.lens.rays.n_columns(), &self.unfiltered, &mut self.counts)?;
        }
        Ok(n_valid)
    }

    fn give(
        &mut self,
        stamp: Time,
        valid: bool,
        image: &DepthImage,
        out: &mut Observations,
    ) -> Result<(), EyeError> {
        let EyeSettings { sensor, base_from_camera, max_range_m, .. } = self.settings;
        let depths = Depths::Counts { counts: &self.counts, unit_m: image.unit_m };
        if self.settings.gives_picture {
            let data = Data::DepthImage(image.clone());
            out.push(Observation { sensor, stamp, base_from_sensor: base_from_camera, valid, data });
        }
        if self.settings.gives_points {
            let mut points_m = out.point_buffer(self.counts.len());
            // What is filled in may lie at the range's very end.
            let max_m = max_range_m as f32 + image.unit_m;
            points(&self.lens.rays, depths, max_m, Some(&self.band), points_m.make_mut())?;
            let data = Data::PointCloud(PointCloud { points_m });
            out.push(Observation { sensor, stamp, base_from_sensor: base_from_camera, valid, data });
        }
        if self.settings.gives_scan {
            let (scan, _) = self.lens.scan.message(depths, out)?;
            let (base_from_sensor, data) = (self.base_from_scan, Data::LaserScan(scan));
            out.push(Observation { sensor, stamp, base_from_sensor, valid, data });
        }
        Ok(())
    }
}

impl Lens {
    fn new(settings: &EyeSettings, camera: &Intrinsics) -> Result<Lens, EyeError> {
        let rays = rays(camera, settings.projection)?;
        let rows = settings.slice_rows.map(|slice_rows| {
            let n = slice_rows.min(rays.n_rows());
            let first = (rays.n_rows() - n) / 2;
            first..first + n
        });
        // Over the floor, things at the picture's edge are farther than along the axis.
        let widest = rays.left().iter().fold(1.0, |widest: f64, left| widest.max(left.hypot(1.0)));
        let ranges_m = [settings.near_plane_m, settings.max_range_m * widest];
        // The nearest count may round to a hair below the near plane.
        let ranges_m = [ranges_m[0] * (1.0 - 1e-5), ranges_m[1]];
        let limits = ScanLimits { heights_m: settings.heights_m, ranges_m, rows };
        let mut scan = ScanMaker::new(rays.clone(), limits, settings.n_beams)?;
        let (_, level_from_camera) = level(&settings.base_from_camera);
        scan.face(&level_from_camera, settings.base_from_camera.translation.z);
        Ok(Lens { camera: *camera, rays, scan })
    }
}

/// What the camera's columns and rows are taken for.
fn rays(camera: &Intrinsics, projection: Projection) -> Result<Rays, RaysError> {
    let counting = match projection {
        Projection::Pinhole => return Rays::pinhole(camera),
        Projection::LinearAngle => Counting::FromZero,
        Projection::LinearAngleOneOff => Counting::OneOff,
    };
    let Intrinsics { width, height, focal_px, .. } = *camera;
    let half = |n: u32, focal_px: f64| (f64::from(n) / 2.0 / focal_px).atan();
    let half_angles_rad = [half(width, focal_px[0]), half(height, focal_px[1])];
    Rays::linear_angle(width as usize, height as usize, half_angles_rad, counting)
}
