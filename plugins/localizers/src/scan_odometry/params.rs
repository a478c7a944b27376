//! Parameters of odometry by scans.

use super::drift::Agility;
use super::tracker::TrackerSettings;
use crate::number_faults::number_faults;
use rumbo_core::registry::Params;
use rumbo_core::robot::Robot;
use rumbo_core::stages::BuildError;
use rumbo_kit::scan_odometry::{DegeneracyRule, LineKind, ScanOdometrySettings};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the base went, by registering each laser scan to a key scan, point to line: an odometer that does not need wheels,
/// for tracks, slippery floors and robots that are pushed. In `[odometer]` it is the pipeline's odometry; in `[localizer]`
/// it follows the robot from a known start without a map.
///
/// The match begins where a gyro and the velocity so far say that the robot is. Along a corridor, where walls do not show
/// the way, that is what counts: the velocity that something last showed, or standing, where nothing ever did. The covariance
/// says how far that may be off by now. Scans that say nothing or fit nothing leave it, too. Wheels are
/// not looked at unless `prediction` is `"wheels"` or `"either"`. Of several scanners it takes the first that speaks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ScanOdometryParams {
    /// Where a match begins. `"gyro"`: the turn of an inertial measurement unit, where there is one, and constant velocity.
    /// `"constant_velocity"`: that alone. `"wheels"`: the wheels' way, which also counts where scans do not show it.
    /// `"either"`: there, and where the gyro and the velocity say; what clearly more points support counts. `"none"`: where
    /// the last one ended.
    pub prediction: Prediction,
    /// A velocity is carried on for at most so long after the last good match, seconds; then the robot is taken to stand.
    pub carry_on_s: f64,
    /// How much the speed changes within a second, m/s (standard deviation).
    pub speed_deviation_m_s: f64,
    /// How much the turning rate changes within a second, degrees a second (standard deviation).
    pub turn_deviation_deg_s: f64,
    /// How far a gyro may be off, degrees a second (standard deviation).
    pub gyro_deviation_deg_s: f64,
    /// A scan becomes the key scan once the robot moved this far since the last one, meters (published: 0.15). Each new one adds
    /// its error to the drift.
    pub key_distance_m: f64,
    /// Or turned so far, degrees (published: 5.73).
    pub key_angle_deg: f64,
    /// Or fewer of its points than this share match.
    pub key_overlap: f64,
    /// Farthest match of a point in the first steps, meters; it is halved down to `least_match_m`.
    pub max_match_m: f64,
    /// Farthest match of a point in the last steps, meters.
    pub least_match_m: f64,
    /// Neighbors farther apart than this are not one surface, meters.
    pub max_line_gap_m: f64,
    /// `"fitted"`: the line at a point fits all neighbors within `line_reach_m`. `"neighbor"`: it goes through the nearer
    /// neighbor, as published, which makes more of the noise.
    pub lines: ScanLines,
    /// Neighbors up to this distance on each side belong to a fitted line, meters.
    pub line_reach_m: f64,
    /// Noise of a range, meters: what is straighter than twice this is one wall.
    pub range_noise_m: f64,
    /// Residuals beyond this count less (Huber's kernel), meters.
    pub huber_m: f64,
    /// Share of the worst residuals that is left out.
    pub trim: f64,
    /// Most steps of one match.
    pub max_iterations: usize,
    /// Fewer matched points than this say nothing: the prediction counts.
    pub min_points: usize,
    /// Less than this share of points matched is no match: the prediction counts.
    pub min_overlap: f64,
    /// Residuals with a larger root mean square than this are no match, meters: the prediction counts.
    pub max_rms_m: f64,
    /// A match that is farther than this from the prediction is none, meters: the prediction counts.
    pub max_correction_m: f64,
    /// Nor is one that is turned by more, degrees.
    pub max_correction_deg: f64,
    /// A direction with less than this share of the best one's information is not observed.
    pub degeneracy_ratio: f64,
    /// Nor is one with less information than this a point, 1/m².
    pub degeneracy_floor: f64,
    /// Nor is one of whose information more than this share may come from wrong directions of fitted lines; 1 turns this
    /// off.
    pub degeneracy_noise_share: f64,
    /// Largest standard deviation along a direction that is not observed, between key scans, meters.
    pub degenerate_deviation_m: f64,
    /// Where fewer points than this share lie within `least_match_m` of a surface, other directions are tried.
    pub retry_support: f64,
    /// Where a match fails it is tried again from directions to both sides that are this far apart, degrees.
    pub retry_step_deg: f64,
    /// So many to each side; 0 tries once.
    pub retries: usize,
    /// For a body that pitches and has no inertial measurement unit: the middle columns of a depth camera's pictures are a
    /// second scan, in an upright plane, that tells the pitch, so that a change of range by inclination is not taken for
    /// travel. Scans are placed by it; what they see of the floor is left out. They must lie in one plane of the body: those
    /// of a laser, or of a camera's middle rows (`slice_rows` of `kinect`, `rows` of `depth_to_scan`).
    pub vertical_slice: bool,
    /// After so many failed matches in a row the robot counts as lost.
    pub lost_after_scans: u32,
}

/// Where a match begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Prediction {
    /// The turn of a gyro, where there is one; else, and for the way, constant velocity.
    Gyro,
    /// The velocity so far.
    ConstantVelocity,
    /// What the wheels say.
    Wheels,
    /// What the wheels say, or the gyro and the velocity where the scan supports that better.
    Either,
    /// No motion.
    None,
}

impl Prediction {
    /// Wheels are looked at.
    pub fn has_wheels(self) -> bool {
        matches!(self, Prediction::Wheels | Prediction::Either)
    }

    /// A gyro is looked at.
    pub fn has_gyro(self) -> bool {
        matches!(self, Prediction::Gyro | Prediction::Either)
    }
}

/// Which line stands for the surface at a point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScanLines {
    /// That of all neighbors within reach.
    Fitted,
    /// That through the nearer neighbor.
    Neighbor,
}

impl Default for ScanOdometryParams {
    fn default() -> Self {
        let scan = ScanOdometrySettings::default();
        ScanOdometryParams {
            prediction: Prediction::Gyro,
            carry_on_s: 0.5,
            speed_deviation_m_s: 0.2,
            turn_deviation_deg_s: 20.0,
            gyro_deviation_deg_s: 0.5,
            key_distance_m: 0.3,
            key_angle_deg: 11.5,
            key_overlap: scan.key_overlap,
            max_match_m: scan.max_match_m,
            least_match_m: scan.least_match_m,
            max_line_gap_m: scan.max_line_gap_m,
            lines: ScanLines::Fitted,
            line_reach_m: scan.line_reach_m,
            range_noise_m: scan.range_noise_m,
            huber_m: scan.huber_m,
            trim: scan.trim,
            max_iterations: scan.max_iterations,
            min_points: scan.min_points,
            min_overlap: scan.min_overlap,
            max_rms_m: scan.max_rms_m,
            max_correction_m: scan.max_correction_m,
            max_correction_deg: 34.4,
            degeneracy_ratio: scan.degeneracy.ratio,
            degeneracy_floor: scan.degeneracy.floor,
            degeneracy_noise_share: scan.degeneracy.pretended_share,
            degenerate_deviation_m: scan.degeneracy.std_m,
            retry_support: scan.retry_support,
            retry_step_deg: 5.73,
            retries: scan.n_retries,
            vertical_slice: false,
            lost_after_scans: 10,
        }
    }
}

impl ScanOdometryParams {
    /// The settings for a robot.
    pub(super) fn settings(&self, robot: &Robot) -> TrackerSettings {
        let scan = self.scan_settings();
        TrackerSettings {
            scan,
            prediction: self.prediction,
            carry_on_s: self.carry_on_s,
            gyro_rad_s: self.gyro_deviation_deg_s.to_radians(),
            agility: Agility {
                speed_m_s: self.speed_deviation_m_s,
                turn_rad_s: self.turn_deviation_deg_s.to_radians(),
                fastest: [robot.max_speed_m_s, robot.max_turn_rad_s()],
                floor: [scan.min_std_m, scan.min_std_rad],
            },
            has_slice: self.vertical_slice,
            lost_after_scans: self.lost_after_scans,
        }
    }

    fn scan_settings(&self) -> ScanOdometrySettings {
        ScanOdometrySettings {
            key_distance_m: self.key_distance_m,
            key_angle_rad: self.key_angle_deg.to_radians(),
            key_overlap: self.key_overlap,
            max_match_m: self.max_match_m,
            least_match_m: self.least_match_m,
            max_line_gap_m: self.max_line_gap_m,
            lines: match self.lines {
                ScanLines::Fitted => LineKind::Fitted,
                ScanLines::Neighbor => LineKind::Neighbor,
            },
            line_reach_m: self.line_reach_m,
            range_noise_m: self.range_noise_m,
            huber_m: self.huber_m,
            trim: self.trim,
            max_iterations: self.max_iterations,
            min_points: self.min_points,
            min_overlap: self.min_overlap,
            max_rms_m: self.max_rms_m,
            max_correction_m: self.max_correction_m,
            max_correction_rad: self.max_correction_deg.to_radians(),
            degeneracy: DegeneracyRule {
                ratio: self.degeneracy_ratio,
                floor: self.degeneracy_floor,
                pretended_share: self.degeneracy_noise_share,
                std_m: self.degenerate_deviation_m,
            },
            retry_support: self.retry_support,
            retry_step_rad: self.retry_step_deg.to_radians(),
            n_retries: self.retries,
            far_retries: 3,
            kernel_share: 0.3,
            ..ScanOdometrySettings::default()
        }
    }
}

impl Params for ScanOdometryParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = number_faults(
            [
                ("carry_on_s", self.carry_on_s),
                ("degeneracy_ratio", self.degeneracy_ratio),
                ("degeneracy_floor", self.degeneracy_floor),
            ],
            [
                ("speed_deviation_m_s", self.speed_deviation_m_s),
                ("turn_deviation_deg_s", self.turn_deviation_deg_s),
                ("gyro_deviation_deg_s", self.gyro_deviation_deg_s),
                ("key_distance_m", self.key_distance_m),
                ("key_angle_deg", self.key_angle_deg),
                ("max_match_m", self.max_match_m),
                ("least_match_m", self.least_match_m),
                ("max_line_gap_m", self.max_line_gap_m),
                ("line_reach_m", self.line_reach_m),
                ("range_noise_m", self.range_noise_m),
                ("huber_m", self.huber_m),
                ("max_rms_m", self.max_rms_m),
                ("max_correction_m", self.max_correction_m),
                ("max_correction_deg", self.max_correction_deg),
                ("degeneracy_noise_share", self.degeneracy_noise_share),
                ("degenerate_deviation_m", self.degenerate_deviation_m),
                ("retry_step_deg", self.retry_step_deg),
            ],
        );
        let shares = [
            ("key_overlap", self.key_overlap),
            ("trim", self.trim),
            ("min_overlap", self.min_overlap),
            ("retry_support", self.retry_support),
        ];
        for (key, share) in shares.into_iter().filter(|(_, share)| !(0.0..1.0).contains(share)) {
            faults.push(BuildError::at(key, format!("is {share}, expected a share of at least 0, below 1")));
        }
        if self.least_match_m > self.max_match_m {
            let message =
                format!("is {}, expected at most max_match_m ({})", self.least_match_m, self.max_match_m);
            faults.push(BuildError::at("least_match_m", message));
        }
        let counts = [
            ("max_iterations", self.max_iterations, 1, 1000),
            ("min_points", self.min_points, 4, 100_000),
            ("retries", self.retries, 0, 60),
            ("lost_after_scans", self.lost_after_scans as usize, 1, usize::MAX),
        ];
        for (key, count, least, most) in counts {
            if !(least..=most).contains(&count) {
                let most = if most == usize::MAX { String::new() } else { format!(" and at most {most}") };
                faults.push(BuildError::at(key, format!("is {count}, expected at least {least}{most}")));
            }
        }
        faults
    }
}
