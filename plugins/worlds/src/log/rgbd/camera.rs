//! What is known of the camera that took recorded pictures.

use rumbo_core::stages::BuildError;
use rumbo_kit::depth_file::DepthEncoding;
use rumbo_kit::tum_rgbd::{CameraMounting, PlaceInSpace};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The camera of a folder of depth pictures.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RecordedCamera {
    /// How depth stands in the pictures: `"gray16"`, one channel of 16 bits (PNG or PGM), or `"two_channel"`, 13 bits in
    /// the red and green channels of a PNG.
    pub encoding: DepthEncoding,
    /// Meters of one count: 0.0002 in the TUM RGB-D data set, 0.001 in most others.
    pub unit_m: f64,
    /// A count that stands for no reading, as 0 does: 65535 in some data sets.
    pub no_reading: Option<u16>,
    /// Focal lengths along columns and rows, pixels. Without them: 525 for pictures of 640 columns, as of a Kinect, and
    /// in proportion for others.
    pub focal_px: Option<[f64; 2]>,
    /// Column and row of the optical axis, pixels from 0. Without them: the middle of the picture.
    pub center_px: Option<[f64; 2]>,
    /// Where the camera sat on the robot, with the keys of a sensor's `mount`: true poses of the camera become poses of
    /// the robot by it.
    pub mount: PlaceInSpace,
    /// Where the world of the recorded poses lies in the map, with the same keys: levels a world that is not.
    pub map_from_world: PlaceInSpace,
}

impl Default for RecordedCamera {
    fn default() -> Self {
        RecordedCamera {
            encoding: DepthEncoding::Gray16,
            unit_m: 0.0002,
            no_reading: None,
            focal_px: None,
            center_px: None,
            mount: PlaceInSpace::default(),
            map_from_world: PlaceInSpace::default(),
        }
    }
}

impl RecordedCamera {
    /// How it sat on its robot.
    pub fn mounting(&self) -> CameraMounting {
        CameraMounting { mount: self.mount, map_from_world: self.map_from_world }
    }

    /// All faults; `key` is where this struct stands.
    pub fn faults(&self, key: &str) -> Vec<BuildError> {
        let at = |part: &str, message: String| BuildError::at(format!("{key}.{part}"), message);
        let mut faults = Vec::new();
        // One count of a meter is no depth camera any more.
        if !(1e-6..=1.0).contains(&self.unit_m) {
            faults.push(at("unit_m", format!("is {}, expected meters from 1e-6 to 1", self.unit_m)));
        }
        for (part, pair, is_positive) in
            [("focal_px", self.focal_px, true), ("center_px", self.center_px, false)]
        {
            for (idx, value) in pair.into_iter().flatten().enumerate() {
                let fits = if is_positive { (1e-3..=1e6).contains(&value) } else { value.abs() <= 1e6 };
                if !fits {
                    let expected = if is_positive { "0.001 to 1e6" } else { "-1e6 to 1e6" };
                    let message = format!("is {value}, expected pixels from {expected}");
                    faults.push(at(&format!("{part}[{idx}]"), message));
                }
            }
        }
        let places = self.mounting().faults();
        faults.extend(places.map(|(part, value)| at(&part, format!("is {value}, expected a finite number"))));
        faults
    }
}
