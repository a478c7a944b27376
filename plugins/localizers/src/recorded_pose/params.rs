//! Parameters of recorded poses.

use std::path::PathBuf;

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_kit::tum_rgbd::CameraMounting;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The pose of the newest laser scan, from a file of poses: the estimate has the stamp of that scan.
///
/// Stamps of the file are absolute, as in the log that the world plays; in a world without a recording they count from
/// the start of the run. Before the first pose and in gaps the status is `converging` and the estimate keeps its old
/// stamp; after the last pose it is `lost`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RecordedPoseParams {
    /// Lines of `t x y theta` (seconds, meters, radians), plain or gzip, or a log with poses inside: those of `VERTEX2`
    /// lines, else the first pose of each laser message, or a folder of the TUM RGB-D kind with its `groundtruth.txt`.
    /// Without it: the recording that the world plays.
    pub file: Option<PathBuf>,
    /// How the camera of a TUM RGB-D folder sat on its robot (`mount`), and where the world of its poses lies in the map
    /// (`map_from_world`), both with the keys of a sensor's `mount`: the same as under `camera` of the world `log`.
    pub camera: CameraMounting,
    /// Only scans whose stamp is that of a pose (within 0.1 ms) get a pose; those between two poses get none.
    pub only_exact: bool,
    /// Between poses that are farther apart than this nothing is known, seconds.
    pub max_gap_s: f64,
    /// How far off recorded poses may be: standard deviation along each axis, meters.
    pub deviation_m: f64,
    /// The same for the heading, degrees.
    pub deviation_deg: f64,
}

impl Default for RecordedPoseParams {
    fn default() -> Self {
        RecordedPoseParams {
            file: None,
            camera: CameraMounting::default(),
            only_exact: false,
            max_gap_s: 2.0,
            deviation_m: 0.02,
            deviation_deg: 0.5,
        }
    }
}

impl Params for RecordedPoseParams {
    fn check(&self) -> Vec<BuildError> {
        // Longer than a year is no gap, and more than a turn no deviation.
        let limits = [
            ("max_gap_s", self.max_gap_s, 3.2e7),
            ("deviation_m", self.deviation_m, 1e3),
            ("deviation_deg", self.deviation_deg, 360.0),
        ];
        let places = self.camera.faults().map(|(part, value)| {
            BuildError::at(format!("camera.{part}"), format!("is {value}, expected a finite number"))
        });
        limits
            .into_iter()
            .filter(|(_, value, most)| !(*value > 0.0 && value <= most))
            .map(|(key, value, most)| {
                BuildError::at(key, format!("is {value}, expected a number above zero, at most {most}"))
            })
            .chain(places)
            .collect()
    }
}
