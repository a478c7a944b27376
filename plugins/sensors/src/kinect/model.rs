//! Facts of the devices.
//!
//! Fields of view and ranges: Valverde Moreno (2015), section 4.1. Least distances are not in there: both devices read
//! nothing nearer than about half a meter.

use rumbo_kit::depth::DepthStep;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Steps of a structured-light device, 1/m: 2.85 mm at 1 m (Khoshelham and Oude Elberink, Sensors 12, 2012).
const DISPARITY_STEP: f64 = 0.00285;

/// Which device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
pub enum CameraModel {
    /// Structured light: 57 x 43 degrees, 640 x 480 pixels, depths in steps that grow with their square.
    #[default]
    #[serde(rename = "v1")]
    V1,
    /// Time of flight: 70 x 60 degrees, 512 x 424 pixels.
    #[serde(rename = "v2")]
    V2,
}

/// What the columns and rows of a picture are taken for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Evenly spaced tangents, as in a flat picture.
    #[default]
    Pinhole,
    /// Evenly spaced angles, as Valverde Moreno (2015) has them: wrong by up to a degree (v1) or two (v2).
    LinearAngle,
    /// The same with the source's printed counting, which is off by one pixel.
    LinearAngleOneOff,
}

impl CameraModel {
    /// Half of the fields of view, degrees: horizontal and vertical.
    pub fn half_angles_deg(self) -> [f64; 2] {
        match self {
            Self::V1 => [28.5, 21.5],
            Self::V2 => [35.0, 30.0],
        }
    }

    /// Columns and rows of a picture in simulation, where nothing else is asked for: a quarter of the device's.
    pub fn quarter_size(self) -> [u32; 2] {
        match self {
            Self::V1 => [160, 120],
            Self::V2 => [128, 106],
        }
    }

    /// Reads up to here, meters.
    pub fn max_range_m(self) -> f64 {
        match self {
            Self::V1 => 3.5,
            Self::V2 => 4.5,
        }
    }

    /// Reads nothing nearer, meters.
    pub fn min_range_m(self) -> f64 {
        0.5
    }

    /// The steps of its depths in millimeters.
    pub fn step(self) -> DepthStep {
        match self {
            Self::V1 => DepthStep::Disparity(DISPARITY_STEP),
            Self::V2 => DepthStep::Even,
        }
    }
}
