//! What `[slam] plugin = "scan_match_slam"` takes.

use rumbo_core::registry::{Params, Surroundings};
use rumbo_core::stages::BuildError;
use rumbo_kit::occupancy::{Evidence, EvidenceFault, doubtful_turn};
use rumbo_kit::scan_match::CovarianceRule;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Builds an occupancy grid and finds the robot in it by matching every laser scan against the map of those before. Needs
/// no odometer; where there is one, or a gyroscope, the match begins where they say, and trusts them where a scan does
/// not see a direction (corridors). Closes no loops: an error that has become part of the map stays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ScanMatchSlamParams {
    /// Edge of the finest cells, meters.
    pub resolution_m: f64,
    /// Finest cells along each axis at the start; the grid grows with what is seen.
    pub size_cells: u32,
    /// Grids at 1, 2, 4, ... times the edge of a cell. A start that is off by about a coarsest cell is still matched.
    pub levels: u32,
    /// The grid grows by multiples of this, cells.
    pub grow_block_cells: u32,
    /// The grid does not grow beyond this.
    pub max_cells: u64,
    /// Probability that a cell is occupied although a beam passed it; below 0.5. Nearer to it than a map for people
    /// has: beams that graze a wall free its cells, and a wall that is thinned moves the next scan.
    pub update_factor_free: f64,
    /// Probability that a cell is occupied in which a beam ended; above 0.5.
    pub update_factor_occupied: f64,
    /// No cell becomes surer to be free than this probability of being occupied.
    pub p_min: f64,
    /// No cell becomes surer to be occupied than this probability.
    pub p_max: f64,
    /// A scan is inserted after the robot has moved this far since the last one, meters, ...
    pub map_update_distance_m: f64,
    /// ... or has turned this much, degrees; never more than a quarter of the scanner's field of view.
    pub map_update_angle_deg: f64,
    /// Nearer readings are dropped, meters.
    pub min_range_m: f64,
    /// Farther readings are neither matched nor inserted, meters.
    pub max_range_m: f64,
    /// Points lower than this against the scanner are not matched, meters: ground, as a tilted scanner sees it.
    pub lowest_m: f64,
    /// Points higher than this are not matched, meters.
    pub highest_m: f64,
    /// At most so many points are matched, at equal distances along what was seen; 0 matches all.
    pub max_points: usize,
    /// Points closer together than this weigh less, by their distance, meters; 0 weighs all the same.
    pub full_weight_spacing_m: f64,
    /// Noise of a range at which a point weighs half, meters, with noise of 5 mm + 1.5 mm/m² r² (depth cameras); 0 weighs
    /// all the same.
    pub half_weight_noise_m: f64,
    /// Where a match begins: `odometry` (or the gyroscope, or else the last velocity), `constant_velocity`, or `none` for
    /// the last pose.
    pub prediction: Prediction,
    /// The match also minds where it began, by the errors below.
    pub use_prior: bool,
    /// Variance of one point's misfit (0 to 1) against the prior: larger trusts the prediction more.
    pub residual_variance: f64,
    /// In the match an odometer's errors count this many times larger than below: they are alike from scan to scan, and
    /// taken at their word they pull the map apart; 1 trusts it fully.
    pub odometer_doubt: f64,
    /// Error of the odometer's way, meters a meter.
    pub odometer_way: f64,
    /// Error of its turn, radians a radian.
    pub odometer_turn: f64,
    /// Error of its turn, degrees a meter.
    pub odometer_turn_deg_m: f64,
    /// Error of a gyroscope's turn, degrees a second.
    pub gyroscope_deg_s: f64,
    /// Without an odometer: how the speed changes, m/s².
    pub acceleration_m_s2: f64,
    /// Without a gyroscope either: how the turning rate changes, degrees/s².
    pub turn_acceleration_deg_s2: f64,
    /// Steps on the finest level.
    pub finest_iterations: u32,
    /// Steps on each coarser level.
    pub coarse_iterations: u32,
    /// A match ends on the surfaces that scans have seen in the cells, rather than on the cells: an error of millimeters
    /// instead of a part of a cell. Off by default: better on most logs, not on the longest corridors.
    pub polish: bool,
    /// On surfaces, a point this far off counts half, meters.
    pub surface_doubt_m: f64,
    /// On surfaces, standard deviation of one point against the prior, meters: larger trusts the prediction more.
    pub surface_deviation_m: f64,
    /// Where the covariance comes from: `curvature`, or `sampled` (seven looks at the map; better at its border).
    pub covariance: CovarianceRule,
    /// A direction with less evidence than this share of the best seen one is not seen.
    pub degeneracy_ratio: f64,
    /// Fewer points are not matched.
    pub min_points: usize,
    /// Share of the points that must lie on cells some scan has touched.
    pub min_known: f64,
    /// A match farther than this from where it began is refused (and farther than three deviations of the prediction),
    /// meters.
    pub max_correction_m: f64,
    /// The same for the turn, degrees.
    pub max_correction_deg: f64,
    /// A match with a larger mean misfit (0 to 1) of the points on cells that some scan has touched is refused.
    pub max_mean_cost: f64,
    /// So far the robot may go without a match and still extend the map where it ends, meters.
    pub explore_grace_m: f64,
    /// After so many scans without a match the robot is lost, and looks for itself on the whole map.
    pub lost_after_scans: u32,
    /// A lost robot looks at every nth scan; each look that finds nothing doubles that, up to 32 times.
    pub look_every_scans: u32,
    /// Where a match fails, or the prediction knows too little, the place that fits best is looked for so far around (and
    /// twice the deviation of the prediction), meters; 0 does not look, ...
    pub near_reach_m: f64,
    /// ... and so far to each side, degrees.
    pub near_reach_deg: f64,
    /// A place fits from this share on, 0 to 1.
    pub place_score: f64,
    /// No other place on the map may come this close to it, 0 to 1.
    pub place_lead: f64,
}

/// Where a match begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Prediction {
    /// Where odometer and gyroscope say; without them at the last velocity.
    #[default]
    Odometry,
    /// At the last velocity.
    ConstantVelocity,
    /// At the last pose.
    None,
}

impl Default for ScanMatchSlamParams {
    fn default() -> Self {
        ScanMatchSlamParams {
            resolution_m: 0.05,
            size_cells: 1024,
            levels: 5,
            grow_block_cells: 256,
            max_cells: rumbo_kit::map_file::DEFAULT_MAX_CELLS,
            update_factor_free: 0.45,
            update_factor_occupied: 0.9,
            p_min: 0.01,
            p_max: 0.99,
            map_update_distance_m: 0.2,
            map_update_angle_deg: 5.7,
            min_range_m: 0.1,
            max_range_m: 30.0,
            lowest_m: -1.0,
            highest_m: 1.0,
            max_points: 0,
            full_weight_spacing_m: 0.0,
            half_weight_noise_m: 0.0,
            prediction: Prediction::Odometry,
            use_prior: true,
            residual_variance: 0.15,
            odometer_doubt: 7.0,
            odometer_way: 0.1,
            odometer_turn: 0.1,
            odometer_turn_deg_m: 1.0,
            gyroscope_deg_s: 0.5,
            acceleration_m_s2: 1.0,
            turn_acceleration_deg_s2: 115.0,
            finest_iterations: 12,
            coarse_iterations: 4,
            polish: false,
            surface_doubt_m: 0.03,
            surface_deviation_m: 0.025,
            covariance: CovarianceRule::Curvature,
            degeneracy_ratio: 1e-3,
            min_points: 30,
            min_known: 0.1,
            max_correction_m: 0.5,
            max_correction_deg: 20.0,
            max_mean_cost: 0.3,
            explore_grace_m: 10.0,
            lost_after_scans: 20,
            look_every_scans: 5,
            near_reach_m: 0.6,
            near_reach_deg: 20.0,
            place_score: 0.55,
            place_lead: 0.05,
        }
    }
}

/// More levels than this make cells of half a kilometer.
const MOST_LEVELS: u32 = 12;

impl Params for ScanMatchSlamParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, found: &dyn std::fmt::Display, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {found}, expected {expected}")));
            }
        };
        for (key, value) in self.above_zero() {
            expect(value.is_finite() && value > 0.0, key, &value, "a finite number above 0");
        }
        for (key, value) in self.zero_or_more() {
            expect(value.is_finite() && value >= 0.0, key, &value, "a finite number, 0 or more");
        }
        let shares = [
            ("min_known", self.min_known),
            ("max_mean_cost", self.max_mean_cost),
            ("degeneracy_ratio", self.degeneracy_ratio),
            ("place_score", self.place_score),
            ("place_lead", self.place_lead),
        ];
        for (key, value) in shares {
            expect((0.0..=1.0).contains(&value), key, &value, "a share from 0 to 1");
        }
        let counts = [
            ("finest_iterations", self.finest_iterations),
            ("lost_after_scans", self.lost_after_scans),
            ("look_every_scans", self.look_every_scans),
        ];
        for (key, value) in counts {
            expect(value >= 1, key, &value, "1 or more");
        }
        expect(self.min_points >= 4, "min_points", &self.min_points, "4 or more: a pose has three numbers");
        for (key, value) in [("lowest_m", self.lowest_m), ("highest_m", self.highest_m)] {
            expect(value.is_finite(), key, &value, "a finite number");
        }
        let is_band = self.lowest_m < self.highest_m;
        expect(is_band, "lowest_m", &self.lowest_m, "less than highest_m");
        expect(
            self.min_range_m < self.max_range_m,
            "min_range_m",
            &self.min_range_m,
            "less than max_range_m",
        );
        let levels_fit = (1..=MOST_LEVELS).contains(&self.levels);
        expect(levels_fit, "levels", &self.levels, "from 1 to 12");
        let coarsest = 1u32 << (self.levels.clamp(1, MOST_LEVELS) - 1);
        let whole = format!("a multiple of {coarsest}, so that all {} levels have whole cells", self.levels);
        for (key, value) in [("size_cells", self.size_cells), ("grow_block_cells", self.grow_block_cells)] {
            expect(value > 0 && value % coarsest == 0, key, &value, &whole);
        }
        let fits = u64::from(self.size_cells).pow(2) <= self.max_cells;
        expect(fits, "size_cells", &self.size_cells, "at most max_cells cells in all");
        faults.extend(self.evidence().err().into_iter().flatten().map(|fault| {
            BuildError::at(fault.name, format!("is {}, expected {}", fault.found, fault.expected))
        }));
        faults
    }

    fn doubts(&self, surroundings: &Surroundings) -> Vec<BuildError> {
        doubtful_turn("map_update_angle_deg", self.map_update_angle_deg, surroundings.narrowest_view_rad)
            .into_iter()
            .collect()
    }
}

impl ScanMatchSlamParams {
    fn above_zero(&self) -> [(&'static str, f64); 8] {
        [
            ("resolution_m", self.resolution_m),
            ("max_range_m", self.max_range_m),
            ("residual_variance", self.residual_variance),
            ("odometer_doubt", self.odometer_doubt),
            ("surface_doubt_m", self.surface_doubt_m),
            ("surface_deviation_m", self.surface_deviation_m),
            ("max_correction_m", self.max_correction_m),
            ("max_correction_deg", self.max_correction_deg),
        ]
    }

    fn zero_or_more(&self) -> [(&'static str, f64); 14] {
        [
            ("map_update_distance_m", self.map_update_distance_m),
            ("map_update_angle_deg", self.map_update_angle_deg),
            ("min_range_m", self.min_range_m),
            ("full_weight_spacing_m", self.full_weight_spacing_m),
            ("half_weight_noise_m", self.half_weight_noise_m),
            ("odometer_way", self.odometer_way),
            ("odometer_turn", self.odometer_turn),
            ("odometer_turn_deg_m", self.odometer_turn_deg_m),
            ("gyroscope_deg_s", self.gyroscope_deg_s),
            ("acceleration_m_s2", self.acceleration_m_s2),
            ("turn_acceleration_deg_s2", self.turn_acceleration_deg_s2),
            ("explore_grace_m", self.explore_grace_m),
            ("near_reach_m", self.near_reach_m),
            ("near_reach_deg", self.near_reach_deg),
        ]
    }

    pub(super) fn evidence(&self) -> Result<Evidence, Vec<EvidenceFault>> {
        Evidence::new(self.update_factor_free, self.update_factor_occupied, self.p_min, self.p_max)
    }
}
