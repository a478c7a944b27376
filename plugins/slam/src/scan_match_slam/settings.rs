//! What a run is set to, what it counts, and how parameters become that.

use super::motion::{MotionErrors, PredictionRule};
use super::params::{Prediction, ScanMatchSlamParams};
use super::place_search::PlaceSearchSettings;
use rumbo_kit::occupancy::{BeamLimits, Evidence, FreeSpace, MapperSettings, Pyramid};
use rumbo_kit::scan_match::{
    CovarianceSettings, MatchGate, MatchSettings, ObservabilitySettings, PolishSettings, ScanPreparation,
};

/// Everything that can be set.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackerSettings {
    /// Which readings become points.
    pub preparation: ScanPreparation,
    /// The search.
    pub matching: MatchSettings,
    /// The last step of a match, onto the surfaces in the cells.
    pub polish: Option<PolishSettings>,
    /// What is believed.
    pub gate: MatchGate,
    /// The map.
    pub mapper: MapperSettings,
    /// Cells along each axis at the start.
    pub size_cells: u32,
    /// A scan is inserted after so much way (m) or turn (rad).
    pub insert_every: [f64; 2],
    /// Where the first guess comes from.
    pub prediction: PredictionRule,
    /// How wrong it may be.
    pub errors: MotionErrors,
    /// Variance of one point's misfit, against the prior; none matches without a prior.
    pub residual_variance: Option<f64>,
    /// An odometer's errors count so many times larger in the match than in the prediction.
    pub odometer_doubt: f64,
    /// A match with a larger mean misfit on what the map knows is refused.
    pub max_known_cost: f64,
    /// The robot may go so far without a match and still extend the map, meters.
    pub explore_grace_m: f64,
    /// After so many scans without a match the robot is lost.
    pub lost_after_scans: u32,
    /// The search for places.
    pub places: PlaceSearchSettings,
    /// How far it goes around a guess: meters, radians.
    pub near_reach: [f64; 2],
    /// A lost robot looks over the whole map at every nth scan.
    pub look_every_scans: u32,
}

impl TrackerSettings {
    /// For the map that is published: the finest level alone.
    pub fn drawing(&self) -> MapperSettings {
        MapperSettings { pyramid: Pyramid { levels: 1, ..self.mapper.pyramid }, ..self.mapper }
    }
}

/// What was counted.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Counters {
    /// Scans that were taken.
    pub received: u64,
    /// Scans that were matched.
    pub matched: u64,
    /// Scans that became part of the map.
    pub inserted: u64,
    /// Scans with a stamp that is not newer than the last.
    pub not_newer: u64,
    /// Scans with too few points.
    pub too_few_points: u64,
    /// Scans of which too little is on the map.
    pub low_overlap: u64,
    /// Scans whose match ran away.
    pub diverged: u64,
    /// Scans that do not see all directions.
    pub degenerate: u64,
    /// Searches around a guess that helped.
    pub found_near: u64,
    /// Searches over the whole map that helped.
    pub found_anywhere: u64,
}

impl ScanMatchSlamParams {
    pub(super) fn tracker(&self, evidence: Evidence) -> TrackerSettings {
        let range_noise = ScanPreparation::default().noise;
        TrackerSettings {
            preparation: ScanPreparation {
                min_range_m: self.min_range_m,
                max_range_m: self.max_range_m,
                height_band_m: [self.lowest_m, self.highest_m],
                max_points: self.max_points,
                full_weight_spacing_m: self.full_weight_spacing_m,
                noise: range_noise,
                half_weight_noise_m: self.half_weight_noise_m,
            },
            matching: MatchSettings {
                finest_iterations: self.finest_iterations,
                coarse_iterations: self.coarse_iterations,
                observability: ObservabilitySettings {
                    ratio: self.degeneracy_ratio,
                    ..ObservabilitySettings::default()
                },
                covariance: CovarianceSettings { rule: self.covariance, ..CovarianceSettings::default() },
                // What the cells leave, the surfaces in them take away.
                finest_converge_cells: if self.polish { 0.1 } else { 0.0 },
                ..if self.polish { MatchSettings::quick() } else { MatchSettings::default() }
            },
            polish: self.polish.then(|| PolishSettings {
                deviation_m: self.surface_deviation_m,
                doubt_m: self.surface_doubt_m,
                ..PolishSettings::default()
            }),
            gate: MatchGate {
                min_points: self.min_points,
                min_known: self.min_known,
                max_correction_m: self.max_correction_m,
                max_correction_rad: self.max_correction_deg.to_radians(),
                // Judged on what the map knows alone, by `max_known_cost`.
                max_mean_cost: 1.0,
                ..MatchGate::default()
            },
            mapper: self.mapper(evidence),
            size_cells: self.size_cells,
            insert_every: [self.map_update_distance_m, self.map_update_angle_deg.to_radians()],
            prediction: match self.prediction {
                Prediction::Odometry => PredictionRule::Odometry,
                Prediction::ConstantVelocity => PredictionRule::ConstantVelocity,
                Prediction::None => PredictionRule::LastPose,
            },
            errors: self.motion_errors(),
            residual_variance: self.use_prior.then_some(self.residual_variance),
            odometer_doubt: self.odometer_doubt,
            max_known_cost: self.max_mean_cost,
            explore_grace_m: self.explore_grace_m,
            lost_after_scans: self.lost_after_scans,
            places: PlaceSearchSettings {
                least_score: self.place_score,
                least_lead: self.place_lead,
                most_nodes: 3_000_000,
                sigma_m: 0.1,
                most_points: 90,
            },
            near_reach: [self.near_reach_m, self.near_reach_deg.to_radians()],
            look_every_scans: self.look_every_scans,
        }
    }

    fn motion_errors(&self) -> MotionErrors {
        MotionErrors {
            way_share: self.odometer_way,
            turn_share: self.odometer_turn,
            turn_rad_m: self.odometer_turn_deg_m.to_radians(),
            gyro_rad_s: self.gyroscope_deg_s.to_radians(),
            acceleration_m_s2: self.acceleration_m_s2,
            turn_acceleration_rad_s2: self.turn_acceleration_deg_s2.to_radians(),
            // Also of a robot that stands (the specification's floor of the prior).
            least: [0.004, 0.001],
        }
    }

    fn mapper(&self, evidence: Evidence) -> MapperSettings {
        MapperSettings {
            evidence,
            pyramid: Pyramid {
                resolution_m: self.resolution_m,
                levels: self.levels,
                block_cells: self.grow_block_cells,
                max_cells: self.max_cells,
            },
            limits: BeamLimits {
                min_range_m: self.min_range_m,
                max_range_m: self.max_range_m,
                clear_range_m: 0.0,
            },
            free_space: FreeSpace::Area { widest_wedge_rad: 1.1_f64.to_radians() },
            auto_grow: true,
        }
    }
}
