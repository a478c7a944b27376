//! What `[[sensor]] plugin = "depth_to_scan"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A planar scan out of another sensor's depth pictures: in each direction the nearest thing between two heights (Arroyo
/// Sánchez, 2013, section 5.3).
///
/// With a sensor in `inputs` that gives attitude (`imu`), the camera's tilt is that of the robot at that time, too. Beams
/// are infinite where all that is between the heights is beyond `range_max_m`, 0 where it is nearer than `range_min_m`,
/// and not-a-number where nothing is known: no reading, or floor and ceiling only. A camera that shows too little for
/// some pictures is blind: its scans are not valid, and the guard stops the robot.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DepthToScanParams {
    /// What lies lower does not count, meters over the floor.
    pub min_height_m: f64,
    /// What lies higher does not count, meters over the floor; absent: the robot's height and 0.10 m.
    pub max_height_m: Option<f64>,
    /// Shorter ranges are no readings, meters over the floor.
    pub range_min_m: f64,
    /// Longer ranges are beyond reach, meters over the floor.
    pub range_max_m: f64,
    /// Beams over the camera's field of view; absent: as many as leave none empty.
    pub beams: Option<u32>,
    /// Only this many rows of the picture are looked at; absent: all, and the heights select.
    pub rows: Option<u32>,
    /// Middle of those rows, from the top; absent: the picture's.
    pub row_center: Option<u32>,
    /// Scans with a range in less than this share of their beams show too little.
    pub min_valid_fraction: f64,
    /// After so many of them in a row the camera is blind.
    pub blind_frames: u32,
    /// An attitude that is older than this is used, and scans with it are not valid, seconds.
    pub max_attitude_age_s: f64,
}

impl Default for DepthToScanParams {
    fn default() -> Self {
        Self {
            min_height_m: 0.05,
            max_height_m: None,
            range_min_m: 0.45,
            range_max_m: 4.0,
            beams: None,
            rows: None,
            row_center: None,
            min_valid_fraction: 0.05,
            blind_frames: 5,
            max_attitude_age_s: 0.1,
        }
    }
}

impl Params for DepthToScanParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut number = |fine: bool, key: &str, value: f64, expected: &str| {
            if !(value.is_finite() && fine) {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        number(true, "min_height_m", self.min_height_m, "a height");
        let highest_m = self.max_height_m.unwrap_or(f64::MAX);
        number(highest_m > self.min_height_m, "max_height_m", highest_m, "more than min_height_m");
        number(self.range_min_m >= 0.0, "range_min_m", self.range_min_m, "0 or more");
        number(self.range_max_m > self.range_min_m, "range_max_m", self.range_max_m, "more than range_min_m");
        let share = self.min_valid_fraction;
        number((0.0..=1.0).contains(&share), "min_valid_fraction", share, "a share from 0 to 1");
        number(self.max_attitude_age_s >= 0.0, "max_attitude_age_s", self.max_attitude_age_s, "0 or more");
        let beams = self.beams.unwrap_or(1);
        number((1..=4096).contains(&beams), "beams", beams.into(), "1 to 4096");
        number(self.rows != Some(0), "rows", 0.0, "1 or more");
        number(self.blind_frames > 0, "blind_frames", 0.0, "1 or more");
        faults
    }
}
