//! What `[[sensor]] plugin = "stabilized_scan"` takes.

use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Scans of a laser on a robot that tilts, leveled by the roll and pitch of an inertial measurement unit (Kohlbrecher et
/// al., 2011; Arroyo Sánchez, 2013, section 5.2).
///
/// `inputs` are a sensor that gives scans and one that gives attitudes: `imu`, or `attitude_filter` where the device has
/// rates and accelerations only. Ranges stay as they are; the frame of a scan is the laser in the level frame under the
/// robot, with the attitude of the scan's stamp (between two attitudes the one in between; after the last one, its rates
/// carry it on). Beams that say nothing about the walls around are dropped: they read not-a-number. Everybody else sees
/// these scans instead of the laser's.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct StabilizedScanParams {
    /// Readings up to this are dropped, meters (`laser_min_dist` of the source, there 0.4). Absent: the laser's own limit,
    /// so that near obstacles stay visible.
    pub min_range_m: Option<f64>,
    /// Readings from this on are dropped, meters (`laser_max_dist` of the source, there 30). Absent: the laser's own limit.
    pub max_range_m: Option<f64>,
    /// Readings behind the laser that are nearer than this are the robot itself, meters (the source has 0.707). Absent: there
    /// are none; with a laser that sees all around, this hides obstacles.
    pub self_filter_m: Option<f64>,
    /// What lies lower than this is dropped, meters from the laser's own height (`laser_z_min_value` of the source).
    pub lowest_m: f64,
    /// What lies higher than this is dropped, meters from the laser's own height (`laser_z_max_value` of the source).
    pub highest_m: f64,
    /// The end of a beam that leads down, lower than this over the floor, is the floor, meters.
    pub floor_m: f64,
    /// A tilt may be wrong by this, degrees: beams that lead down by more, and would meet the floor if they led down by this
    /// much more, are dropped too.
    pub tilt_margin_deg: f64,
    /// At most so many readings are kept, evenly along what the laser sees, so that near walls do not outweigh the others;
    /// 0: all.
    pub max_points: u32,
    /// The laser's mirror turns while the robot does: `true` puts all beams at the directions that they had at the scan's
    /// stamp, by the measured turning rate about the laser's axis. For more than 0.5 rad/s and fewer than 20 scans a second.
    pub deskew: bool,
    /// An attitude that is older than this is used, and scans with it are not valid, seconds.
    pub max_attitude_age_s: f64,
}

impl Default for StabilizedScanParams {
    fn default() -> Self {
        Self {
            min_range_m: None,
            max_range_m: None,
            self_filter_m: None,
            lowest_m: -1.0,
            highest_m: 1.0,
            floor_m: 0.05,
            tilt_margin_deg: 1.0,
            max_points: 0,
            deskew: false,
            max_attitude_age_s: 0.1,
        }
    }
}

impl Params for StabilizedScanParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut number = |fine: bool, key: &str, value: f64, expected: &str| {
            if !(value.is_finite() && fine) {
                faults.push(BuildError::at(key, format!("is {value}, expected {expected}")));
            }
        };
        let least_m = self.min_range_m.unwrap_or(0.0);
        number(least_m >= 0.0, "min_range_m", least_m, "0 or more");
        let most_m = self.max_range_m.unwrap_or(f64::MAX);
        number(most_m > least_m, "max_range_m", most_m, "more than min_range_m");
        let own_m = self.self_filter_m.unwrap_or(1.0);
        number(own_m > 0.0, "self_filter_m", own_m, "more than 0");
        number(self.lowest_m < 0.0, "lowest_m", self.lowest_m, "less than 0: the laser's own height");
        number(self.highest_m > 0.0, "highest_m", self.highest_m, "more than 0: the laser's own height");
        number(true, "floor_m", self.floor_m, "a height");
        let margin_deg = self.tilt_margin_deg;
        number((0.0..45.0).contains(&margin_deg), "tilt_margin_deg", margin_deg, "0 to 45");
        number(self.max_attitude_age_s >= 0.0, "max_attitude_age_s", self.max_attitude_age_s, "0 or more");
        faults
    }
}
