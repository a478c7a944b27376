//! What `[slam] plugin = "rbpf_slam"` takes.

mod translation;

use super::settings::ProposalRule;
use rumbo_core::registry::{Params, Surroundings};
use rumbo_core::stages::BuildError;
use rumbo_kit::map_file::DEFAULT_MAX_CELLS;
use rumbo_kit::occupancy::{Evidence, EvidenceFault, doubtful_turn};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Builds an occupancy grid and finds the robot in it, with many guesses of its way that each have a map of their own: a
/// Rao-Blackwellized particle filter. It closes loops by keeping the guess that fits where the robot has been before; where no
/// guess does, the place is looked for and the way bent. Uses an odometer and an inertial unit where there are some.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RbpfSlamParams {
    /// Guesses of the robot's way. More of them close longer loops, for more time and memory.
    pub particles: u32,
    /// A scan is taken in after the robot has moved this far since the last one that was, meters, ...
    pub linear_update_m: f64,
    /// ... or has turned this much, degrees, ...
    pub angular_update_deg: f64,
    /// ... or after this time, seconds; below zero never by time alone. Scans between are registered on the last ones.
    pub temporal_update_s: f64,
    /// Particles are drawn anew when their effective number falls below this share of them.
    pub resample_threshold: f64,
    /// Errors of the odometer, variances per square: turn by turn, turn by way (rad²/m²), way by way, way by turn (m²/rad²).
    pub alpha: [f64; 4],
    /// Standard deviation of the odometer's way where nothing but the odometer tells it, as along bare walls without ends, share of
    /// the way. Elsewhere `alpha` doubts it more, since there scans show when wheels slip.
    pub blind_way: f64,
    /// Standard deviation that the odometer has in any step, meters.
    pub odometer_floor_m: f64,
    /// The same of the heading, degrees.
    pub odometer_floor_deg: f64,
    /// The step from one scan that is taken in to the next comes from registering each scan on the last so many of them.
    pub recent_scans: u32,
    /// Noise of a point across the surface that it lies on, meters.
    pub noise_m: f64,
    /// Noise of a point that lies on no surface, meters.
    pub loose_noise_m: f64,
    /// Points that lie farther from the line through their neighbors (root mean square) are no surface, meters.
    pub roughness_m: f64,
    /// Points farther apart than this are no pair, meters.
    pub gate_m: f64,
    /// Share of the information of all pairs of points that is believed: neighboring points err alike.
    pub believed_share: f64,
    /// Share of a scan's points that must have a partner.
    pub least_overlap: f64,
    /// How well these must agree, 0 to 1.
    pub least_agreement: f64,
    /// Where a scan fits badly on the last ones, turns up to this to each side are tried, degrees: wheels slip. 0 tries none.
    pub unseen_turn_deg: f64,
    /// Standard deviation that a registered step has at least, meters.
    pub step_floor_m: f64,
    /// The same of its turn, degrees.
    pub step_floor_deg: f64,
    /// Nearer readings are left out, meters.
    pub min_range_m: f64,
    /// Farther readings are not matched, meters.
    pub max_usable_range_m: f64,
    /// Farther readings count as nothing seen when a scan is drawn into the map, meters.
    pub max_range_m: f64,
    /// Points lower than this against the scanner are left out, meters: ground, as a tilted scanner sees it.
    pub lowest_m: f64,
    /// Points higher than this against the scanner are left out, meters.
    pub highest_m: f64,
    /// At most so many points of a scan are matched, at equal distances along what was seen; 0 takes all.
    pub max_points: u32,
    /// Points closer together than this weigh less when they are matched, by their distance, meters; 0 weighs all the same.
    pub full_weight_spacing_m: f64,
    /// Variance of one beam's misfit, where 0 is a fit and 1 none: the smaller, the more scans count against the odometer, and
    /// particles against each other. Beams are not independent, so it is larger than the misfits are.
    pub likelihood_variance: f64,
    /// Weights are flattened by this times the number of particles, so that one scan does not decide; 0 leaves them.
    pub ogain: f64,
    /// A match whose points have less than this mean value in the map has failed: such a particle follows the odometer.
    pub minimum_score: f64,
    /// Scans with fewer points are not matched.
    pub min_points: u32,
    /// A match this far from the odometer's pose has failed, meters.
    pub max_correction_m: f64,
    /// The same of the heading, degrees.
    pub max_correction_deg: f64,
    /// Where poses are drawn from: `curvature` or `sampled`.
    pub proposal: ProposalRule,
    /// Poses that `sampled` tries.
    pub proposal_samples: u32,
    /// They lie within this of the match, meters, ...
    pub proposal_range_m: f64,
    /// ... and this turn, degrees.
    pub proposal_range_deg: f64,
    /// Where the robot may have come back to, and no guess has found it, its place is looked for as far as the robot may be
    /// off: this share of the way since it was there, ...
    pub loop_drift_share: f64,
    /// ... and at most so far, meters; 0 looks for nothing.
    pub loop_reach_m: f64,
    /// How well what was seen lately must fit on such a place, 0 to 1.
    pub loop_least_score: f64,
    /// Edge of a cell, meters.
    pub resolution_m: f64,
    /// Grids at 1, 2, 4, ... times the edge of a cell that scans are matched with, from coarse to fine.
    pub levels: u32,
    /// Probability that a cell is occupied although a beam passed it; below 0.5.
    pub update_factor_free: f64,
    /// Probability that a cell is occupied in which a beam ended; above 0.5.
    pub update_factor_occupied: f64,
    /// No cell becomes surer to be free than this probability of being occupied.
    pub p_min: f64,
    /// No cell becomes surer to be occupied than this probability.
    pub p_max: f64,
    /// Beams farther apart than this bound no area, degrees; their own cells alone are freed.
    pub widest_wedge_deg: f64,
    /// A scan that overlaps little with the map is drawn into it up to this way after the last that did, meters.
    pub explore_grace_m: f64,
    /// So many scans in a row that match nothing, and the robot is lost.
    pub lost_after_scans: u32,
    /// Readings of the odometer that are farther apart than this, and than a robot can drive, have jumped, meters.
    pub max_odom_jump_m: f64,
    /// The map is written at most once in this time, seconds; 0 writes it with every scan that is taken in.
    pub publish_period_s: f64,
    /// The map has at most so many cells.
    pub max_cells: u64,
}

impl Default for RbpfSlamParams {
    fn default() -> Self {
        RbpfSlamParams {
            particles: 30,
            linear_update_m: 0.5,
            angular_update_deg: 14.3,
            temporal_update_s: -1.0,
            resample_threshold: 0.5,
            alpha: [0.25, 0.01, 1.0, 0.01],
            blind_way: 0.15,
            odometer_floor_m: 0.05,
            odometer_floor_deg: 2.0,
            recent_scans: 6,
            noise_m: 0.02,
            loose_noise_m: 0.3,
            roughness_m: 0.06,
            gate_m: 0.2,
            believed_share: 0.2,
            least_overlap: 0.4,
            least_agreement: 0.35,
            unseen_turn_deg: 18.0,
            step_floor_m: 0.002,
            step_floor_deg: 0.03,
            min_range_m: 0.1,
            max_usable_range_m: 40.0,
            max_range_m: 30.0,
            lowest_m: -1.0,
            highest_m: 1.0,
            max_points: 0,
            full_weight_spacing_m: 0.0,
            likelihood_variance: 0.6,
            ogain: 3.0,
            minimum_score: 0.3,
            min_points: 30,
            max_correction_m: 0.5,
            max_correction_deg: 20.0,
            proposal: ProposalRule::Curvature,
            proposal_samples: 20,
            proposal_range_m: 0.05,
            proposal_range_deg: 1.7,
            loop_drift_share: 0.06,
            loop_reach_m: 40.0,
            loop_least_score: 0.55,
            resolution_m: 0.05,
            levels: 4,
            update_factor_free: 0.4,
            update_factor_occupied: 0.9,
            p_min: 0.01,
            p_max: 0.99,
            widest_wedge_deg: 2.0,
            explore_grace_m: 2.0,
            lost_after_scans: 20,
            max_odom_jump_m: 1.0,
            publish_period_s: 2.0,
            max_cells: DEFAULT_MAX_CELLS,
        }
    }
}

/// Levels beyond this have cells larger than rooms.
const MOST_LEVELS: u32 = 10;
/// More particles than this have no random streams of their own.
const MOST_PARTICLES: u32 = 100_000;

impl Params for RbpfSlamParams {
    fn check(&self) -> Vec<BuildError> {
        let mut faults = Vec::new();
        let mut expect = |fine: bool, key: &str, found: &dyn std::fmt::Display, expected: &str| {
            if !fine {
                faults.push(BuildError::at(key, format!("is {found}, expected {expected}")));
            }
        };
        for (key, value) in self.positive() {
            expect(value > 0.0 && value.is_finite(), key, &value, "a finite number above 0");
        }
        for (key, value) in self.not_negative() {
            expect(value >= 0.0 && value.is_finite(), key, &value, "a finite number, 0 or more");
        }
        for (key, value) in [
            ("resample_threshold", self.resample_threshold),
            ("minimum_score", self.minimum_score),
            ("least_overlap", self.least_overlap),
            ("least_agreement", self.least_agreement),
            ("loop_least_score", self.loop_least_score),
        ] {
            expect((0.0..=1.0).contains(&value), key, &value, "0 to 1");
        }
        let is_share = self.believed_share > 0.0 && self.believed_share <= 1.0;
        expect(is_share, "believed_share", &self.believed_share, "a number above 0, 1 at most");
        let is_count = |value: u32, most: u32| (1..=most).contains(&value);
        expect(is_count(self.particles, MOST_PARTICLES), "particles", &self.particles, "1 to 100000");
        expect(is_count(self.levels, MOST_LEVELS), "levels", &self.levels, "1 to 10");
        for (key, value) in [
            ("recent_scans", self.recent_scans),
            ("min_points", self.min_points),
            ("lost_after_scans", self.lost_after_scans),
            ("proposal_samples", self.proposal_samples),
        ] {
            expect(value > 0, key, &value, "1 or more");
        }
        for value in self.alpha.iter().filter(|value| !(**value >= 0.0 && value.is_finite())) {
            expect(false, "alpha", value, "finite numbers, 0 or more");
        }
        expect(
            self.temporal_update_s.is_finite(),
            "temporal_update_s",
            &self.temporal_update_s,
            "a finite number",
        );
        for (key, value) in [("lowest_m", self.lowest_m), ("highest_m", self.highest_m)] {
            expect(value.is_finite(), key, &value, "a finite number");
        }
        let is_upside_down = self.lowest_m >= self.highest_m;
        expect(!is_upside_down, "lowest_m", &self.lowest_m, "less than highest_m");
        let is_span = self.min_range_m < self.max_range_m.min(self.max_usable_range_m);
        expect(is_span, "min_range_m", &self.min_range_m, "less than max_range_m and max_usable_range_m");
        expect(self.max_cells >= 4096, "max_cells", &self.max_cells, "4096 or more");
        if let Err(wrong) = self.evidence() {
            faults.extend(wrong.into_iter().map(|fault| {
                BuildError::at(fault.name, format!("is {}, expected {}", fault.found, fault.expected))
            }));
        }
        faults
    }

    fn doubts(&self, surroundings: &Surroundings) -> Vec<BuildError> {
        doubtful_turn("angular_update_deg", self.angular_update_deg, surroundings.narrowest_view_rad)
            .into_iter()
            .collect()
    }
}

impl RbpfSlamParams {
    fn positive(&self) -> [(&'static str, f64); 20] {
        [
            ("blind_way", self.blind_way),
            ("linear_update_m", self.linear_update_m),
            ("angular_update_deg", self.angular_update_deg),
            ("odometer_floor_m", self.odometer_floor_m),
            ("odometer_floor_deg", self.odometer_floor_deg),
            ("noise_m", self.noise_m),
            ("loose_noise_m", self.loose_noise_m),
            ("roughness_m", self.roughness_m),
            ("gate_m", self.gate_m),
            ("step_floor_m", self.step_floor_m),
            ("step_floor_deg", self.step_floor_deg),
            ("max_usable_range_m", self.max_usable_range_m),
            ("max_range_m", self.max_range_m),
            ("likelihood_variance", self.likelihood_variance),
            ("max_correction_m", self.max_correction_m),
            ("max_correction_deg", self.max_correction_deg),
            ("proposal_range_m", self.proposal_range_m),
            ("proposal_range_deg", self.proposal_range_deg),
            ("resolution_m", self.resolution_m),
            ("max_odom_jump_m", self.max_odom_jump_m),
        ]
    }

    fn not_negative(&self) -> [(&'static str, f64); 9] {
        [
            ("min_range_m", self.min_range_m),
            ("unseen_turn_deg", self.unseen_turn_deg),
            ("full_weight_spacing_m", self.full_weight_spacing_m),
            ("ogain", self.ogain),
            ("loop_drift_share", self.loop_drift_share),
            ("loop_reach_m", self.loop_reach_m),
            ("widest_wedge_deg", self.widest_wedge_deg),
            ("explore_grace_m", self.explore_grace_m),
            ("publish_period_s", self.publish_period_s),
        ]
    }

    fn evidence(&self) -> Result<Evidence, Vec<EvidenceFault>> {
        Evidence::new(self.update_factor_free, self.update_factor_occupied, self.p_min, self.p_max)
    }
}
