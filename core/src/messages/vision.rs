//! Readings with structure: depth pictures, point clouds, recognized marks, and the kind for everything else.

use super::check::{Check, Checker, MessageFault};
use super::person::PersonPosition;
use crate::boundary::Buffer;

/// A pinhole camera without distortion: pixel `u = cx + fx·x/z`, `v = cy + fy·y/z`, z ahead, x right, y down.
#[doc(alias = "sensor_msgs/CameraInfo")]
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Intrinsics {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Focal lengths, pixels.
    pub focal_px: [f64; 2],
    /// Where the optical axis meets the picture, pixels.
    pub center_px: [f64; 2],
}

/// A depth picture, row 0 on top; the sensor's frame has x ahead, y left, z up (not the optical frame).
#[doc(alias = "sensor_msgs/Image")]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DepthImage {
    /// The camera.
    pub intrinsics: Intrinsics,
    /// Meters of one count, along the optical axis.
    pub unit_m: f32,
    /// Counts, `width · height`; 0 is no reading.
    pub depth: Buffer<u16>,
}

impl Check for DepthImage {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("depth_image");
        let camera = &self.intrinsics;
        camera.focal_px.iter().try_for_each(|f| c.positive("intrinsics.focal_px", *f))?;
        c.finite("intrinsics.center_px", &camera.center_px)?;
        c.positive("unit_m", self.unit_m.into())?;
        c.equal("depth", self.depth.len(), camera.width as usize * camera.height as usize)
    }
}

/// Points in the sensor's frame.
#[doc(alias = "sensor_msgs/PointCloud2")]
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloud {
    /// x, y, z, meters; a point without reading is not-a-number in all three.
    pub points_m: Buffer<[f32; 3]>,
}

impl Check for PointCloud {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("point_cloud");
        let odd = self.points_m.iter().flatten().find(|v| v.is_infinite());
        odd.map_or(Ok(()), |v| c.finite("points_m", &[f64::from(*v)]))
    }
}

/// One recognized mark.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mark {
    /// Which mark, where it can be told.
    pub identity: Option<u32>,
    /// Distance in the plane, meters.
    pub range_m: f64,
    /// Direction in the sensor's frame, radians.
    pub bearing_rad: f64,
}

/// Marks recognized at one time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Marks {
    /// All of them.
    pub marks: Vec<Mark>,
    /// Standard deviation of the range, meters.
    pub range_deviation_m: f64,
    /// Standard deviation of the bearing, radians.
    pub bearing_deviation_rad: f64,
}

impl Check for Marks {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("marks");
        c.not_negative("range_deviation_m", self.range_deviation_m)?;
        c.not_negative("bearing_deviation_rad", self.bearing_deviation_rad)?;
        self.marks.iter().try_for_each(|m| {
            c.not_negative("range_m", m.range_m)?;
            c.finite("bearing_rad", &[m.bearing_rad])
        })
    }
}

/// An observation of a third party's own kind, passed on untouched.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Custom {
    /// Name of the schema, `vendor/Kind`.
    pub schema: String,
    /// The message in that schema.
    pub bytes: Buffer<u8>,
}

impl Check for Custom {
    fn check(&self) -> Result<(), MessageFault> {
        let found = usize::from(!self.schema.trim().is_empty());
        Checker("custom").equal("schema", found, 1)?;
        PersonPosition::read(self).map_or(Ok(()), |person| person.map(|_| ()))
    }
}
