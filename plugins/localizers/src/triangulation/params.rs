//! Parameters of tracking by natural landmarks.

use super::correspondence::Tolerances;
use super::landmark_errors::LandmarkErrors;
use super::quality::Weighting;
use super::tracker::{PairRules, TrackerSettings};
use crate::landmark_noise::LandmarkNoiseParams;
use rumbo_core::registry::Params;
use rumbo_core::stages::BuildError;
use rumbo_core::time::Span;
use rumbo_kit::landmarks::{LandmarkSettings, WallFit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How the pose is found from landmarks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// All landmarks at once, each weighed by its errors.
    #[default]
    LeastSquares,
    /// Triangulation by all pairs of landmarks, weighed by the quality of each pair.
    Pairs,
}

/// Follows a robot from a known start by natural landmarks of a planar laser: discontinuities, corners and walls are
/// related to those that a grid map lets expect.
///
/// Scans with fewer than two related landmarks are starved: the odometry alone carries the pose. After three of them in a
/// row the status is `converging` instead of `tracking`. It is `lost` after ten starved scans in a row if the position is
/// less sure than `search_m`, after 20 scans in a row that are unlike the map (`least_explained`), and where nobody said
/// where the robot starts: it cannot search, so that such a pipeline needs a `[relocalizer]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TriangulationParams {
    /// Follow the source without improvements, to compare with its figures: scans are related to the scan before, every
    /// 4 s; walls by the Hough transform; pairs weighed by the mean of their qualities. Needs no map. The keys
    /// `estimator`, `wall_fit` and `period_s` do nothing then.
    pub thesis_mode: bool,
    /// How the pose is found from landmarks: `least_squares` or `pairs`.
    pub estimator: Estimator,
    /// How walls are fitted: `tls` (total least squares) or `hough`.
    #[schemars(schema_with = "wall_fit_schema")]
    pub wall_fit: WallFit,
    /// At least this long between scans that are looked at, seconds.
    pub period_s: f64,
    /// A jump of the range above this is a discontinuity, meters (mu_d in the source).
    pub discontinuity_m: f64,
    /// A reading farther than this from the chord of its segment is a corner, meters (mu_e).
    pub corner_m: f64,
    /// A straight piece longer than this is a wall, meters (mu_p).
    pub wall_m: f64,
    /// A landmark is looked for within this distance from where the odometry lets expect it, meters.
    pub search_m: f64,
    /// Distances of two landmarks seen from two places differ by no more than this, meters.
    pub consistent_m: f64,
    /// The same for angles of two walls, degrees.
    pub consistent_deg: f64,
    /// Pairs of landmarks whose separation has a smaller sine than this are not used (`pairs`).
    pub least_sine: f64,
    /// Positions by pairs farther than this from their median are not used, meters (`pairs`).
    pub median_m: f64,
    /// Standard deviation of the laser's ranges, meters.
    pub range_deviation_m: f64,
    /// Standard deviation of places of walls on the map, meters, beyond what its cells leave open: that a wall may begin
    /// anywhere in its cell is taken into account by itself.
    pub map_deviation_m: f64,
    /// The same for directions of walls, degrees.
    pub map_deviation_deg: f64,
    /// Two readings of the odometer farther apart than this, beyond what the robot can drive in between, are a jump,
    /// meters: the pose stays, and is less sure.
    pub jump_m: f64,
    /// A scan is unlike the map when a smaller share of the beams that get as far as what the map shows meet it, and the
    /// others go through it; after 20 such scans in a row the robot counts as lost. Beams that end before say nothing.
    pub least_explained: f64,
    /// Noise on the landmarks that are seen, as in the experiments of the source, such as
    /// `{ share = 0.2, distance_m = 0.02, bearing_deg = 5.0 }`; without it they are left as they are. For experiments
    /// only: it makes a good laser worse.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landmark_noise: Option<LandmarkNoiseParams>,
}

impl Default for TriangulationParams {
    fn default() -> Self {
        TriangulationParams {
            thesis_mode: false,
            estimator: Estimator::LeastSquares,
            wall_fit: WallFit::Tls,
            period_s: 0.5,
            discontinuity_m: 0.20,
            corner_m: 0.15,
            wall_m: 0.30,
            search_m: 0.30,
            consistent_m: 0.10,
            consistent_deg: 6.0,
            least_sine: 0.30,
            median_m: 0.10,
            range_deviation_m: 0.015,
            map_deviation_m: 0.005,
            map_deviation_deg: 0.2,
            jump_m: 1.0,
            least_explained: 0.5,
            landmark_noise: None,
        }
    }
}

fn wall_fit_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
    schemars::json_schema!({ "type": "string", "enum": ["tls", "hough"] })
}

impl Params for TriangulationParams {
    fn check(&self) -> Vec<BuildError> {
        let above_zero = [
            ("discontinuity_m", self.discontinuity_m),
            ("corner_m", self.corner_m),
            ("wall_m", self.wall_m),
            ("search_m", self.search_m),
            ("consistent_m", self.consistent_m),
            ("consistent_deg", self.consistent_deg),
            ("median_m", self.median_m),
            ("range_deviation_m", self.range_deviation_m),
            ("map_deviation_deg", self.map_deviation_deg),
            ("jump_m", self.jump_m),
        ];
        let bad = above_zero.into_iter().filter(|(_, value)| !(value.is_finite() && *value > 0.0));
        let mut faults: Vec<BuildError> = bad
            .map(|(key, value)| {
                BuildError::at(key, format!("is {value}, expected a finite number above zero"))
            })
            .collect();
        if !(0.0..=1.0).contains(&self.map_deviation_m) {
            let found = format!("is {}, expected 0 to 1", self.map_deviation_m);
            faults.push(BuildError::at("map_deviation_m", found));
        }
        if !(0.0..=3600.0).contains(&self.period_s) {
            faults.push(BuildError::at("period_s", format!("is {}, expected 0 to 3600", self.period_s)));
        }
        if !(0.0..1.0).contains(&self.least_sine) {
            let found = format!("is {}, expected at least 0 and less than 1", self.least_sine);
            faults.push(BuildError::at("least_sine", found));
        }
        if !(0.0..1.0).contains(&self.least_explained) {
            let found = format!("is {}, expected at least 0 and less than 1", self.least_explained);
            faults.push(BuildError::at("least_explained", found));
        }
        faults.extend(self.landmark_noise.iter().flat_map(LandmarkNoiseParams::faults));
        faults
    }
}

impl TriangulationParams {
    /// Time between updates in the source, seconds (section 5.1).
    const THESIS_PERIOD_S: f64 = 4.0;

    /// What the tracker needs to know.
    pub fn settings(&self) -> TrackerSettings {
        let is_better = !self.thesis_mode;
        let pairs = match (is_better, self.estimator) {
            (false, _) => Some(PairRules { weighting: Weighting::Mean, within_m: None }),
            (true, Estimator::LeastSquares) => None,
            (true, Estimator::Pairs) => Some(PairRules {
                weighting: Weighting::Product { least_sine: self.least_sine },
                within_m: Some(self.median_m),
            }),
        };
        TrackerSettings {
            landmarks: LandmarkSettings {
                discontinuity_m: self.discontinuity_m,
                corner_m: self.corner_m,
                wall_m: self.wall_m,
                wall_fit: if is_better { self.wall_fit } else { WallFit::Hough },
                spares_grazed_walls: is_better,
                range_deviation_m: self.range_deviation_m,
                ..LandmarkSettings::default()
            },
            within: Tolerances {
                search_m: self.search_m,
                distance_m: self.consistent_m,
                angle_rad: self.consistent_deg.to_radians(),
            },
            pairs,
            by_map: is_better,
            period: Span::from_secs(if is_better { self.period_s } else { Self::THESIS_PERIOD_S }),
            errors: LandmarkErrors {
                range_m: self.range_deviation_m,
                map_m: self.map_deviation_m,
                map_rad: self.map_deviation_deg.to_radians(),
            },
            noise: self.landmark_noise.map(|noise| noise.noise()),
            least_explained: self.least_explained,
        }
    }
}
