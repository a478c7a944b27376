//! The same numbers as the algorithm has them.

use super::RbpfSlamParams;
use crate::graph_slam::registration::RegistrationSettings;
use crate::graph_slam::surface::SurfaceLimits;
use crate::rbpf_slam::closing::ClosingSettings;
use crate::rbpf_slam::follower::FollowSettings;
use crate::rbpf_slam::motion::MotionNoise;
use crate::rbpf_slam::settings::{FilterSettings, ProposalRule, TrackerSettings};
use rumbo_core::stages::BuildError;
use rumbo_kit::occupancy::{BeamLimits, Evidence, FreeSpace};
use rumbo_kit::scan_match::{MatchGate, MatchSettings, ScanPreparation};

/// A surface reaches this far around a point, meters.
const SURFACE_M: f64 = 0.25;
/// A point reaches this far along its surface, meters: hardly anything holds it there.
const ALONG_M: f64 = 1.0;
/// Deviations at which a pair of points counts a quarter.
const KERNEL_DEVIATIONS: f64 = 3.0;

impl RbpfSlamParams {
    fn filter_settings(&self, evidence: Evidence) -> FilterSettings {
        FilterSettings {
            n_particles: self.particles as usize,
            resolution_m: self.resolution_m,
            n_levels: self.levels,
            preparation: ScanPreparation {
                min_range_m: self.min_range_m,
                max_range_m: self.max_usable_range_m,
                height_band_m: [self.lowest_m, self.highest_m],
                max_points: self.max_points as usize,
                full_weight_spacing_m: self.full_weight_spacing_m,
                ..ScanPreparation::default()
            },
            matching: MatchSettings { coarse_converge_cells: 0.0, ..MatchSettings::default() },
            gate: MatchGate {
                min_points: self.min_points as usize,
                max_correction_m: self.max_correction_m,
                max_correction_rad: self.max_correction_deg.to_radians(),
                ..MatchGate::default()
            },
            minimum_score: self.minimum_score,
            likelihood_variance: self.likelihood_variance,
            proposal: self.proposal,
            proposal_samples: self.proposal_samples as usize,
            proposal_range: [self.proposal_range_m, self.proposal_range_deg.to_radians()],
            resample_threshold: self.resample_threshold,
            ogain: self.ogain,
            limits: BeamLimits {
                min_range_m: self.min_range_m,
                max_range_m: self.max_range_m,
                clear_range_m: 0.0,
            },
            free_space: FreeSpace::Area { widest_wedge_rad: self.widest_wedge_deg.to_radians() },
            evidence,
            explore_grace_m: self.explore_grace_m,
        }
    }

    fn closing_settings(&self) -> ClosingSettings {
        ClosingSettings {
            drift_share: self.loop_drift_share,
            most_reach_m: self.loop_reach_m,
            least_score: self.loop_least_score,
            limits: SurfaceLimits {
                min_range_m: self.min_range_m,
                max_range_m: self.max_usable_range_m,
                // As those that are followed.
                on_all_lines: true,
                ..SurfaceLimits::SLANTED
            },
            registration: self.registration_settings(),
            least_overlap: self.least_overlap,
            least_agreement: self.least_agreement,
        }
    }

    fn registration_settings(&self) -> RegistrationSettings {
        RegistrationSettings {
            across_m: self.noise_m,
            along_m: ALONG_M,
            loose_m: self.loose_noise_m,
            gate_m: self.gate_m,
            kernel_c: KERNEL_DEVIATIONS,
        }
    }

    fn follow_settings(&self) -> FollowSettings {
        FollowSettings {
            limits: SurfaceLimits {
                min_range_m: self.min_range_m,
                max_range_m: self.max_usable_range_m,
                window_m: SURFACE_M,
                most_rough_m: self.roughness_m,
                // Walls far along a corridor stay without a direction: what they say of the way is too much for particles
                // that shall keep what nobody knows.
                reach_beams: 2.5,
                steepest: 6.0,
                noise_growing_1_m: 0.0,
                // Loose points of rooms pull guesses, too: without it a loop of MIT-Killian is missed.
                on_all_lines: true,
            },
            registration: self.registration_settings(),
            n_recent: self.recent_scans as usize,
            min_points: self.min_points as usize,
            believed_share: self.believed_share,
            spread_share: self.spread_share(),
            least_overlap: self.least_overlap,
            least_agreement: self.least_agreement,
            unseen_turn_rad: self.unseen_turn_deg.to_radians(),
            blind_way: self.blind_way,
            floor: [self.step_floor_m, self.step_floor_deg.to_radians()],
        }
    }

    /// Against the odometer less of a registration is believed than it is worth, since both may be quite wrong. Guesses are
    /// spread by more of it: two loops of a real log were open by a third of the deviations that the lesser share gives. Tried
    /// poses need the room between them.
    fn spread_share(&self) -> f64 {
        match self.proposal {
            ProposalRule::Sampled => self.believed_share,
            ProposalRule::Curvature => 2.5 * self.believed_share,
        }
    }

    /// The same numbers as the algorithm has them.
    ///
    /// # Errors
    /// Probabilities that make no evidence.
    pub fn settings(&self) -> Result<TrackerSettings, BuildError> {
        let evidence = self.evidence().map_err(|faults| {
            let name = faults.first().map_or("update_factor_free", |fault| fault.name);
            BuildError::at(name, "makes no evidence")
        })?;
        Ok(TrackerSettings {
            filter: self.filter_settings(evidence),
            follow: self.follow_settings(),
            closing: self.closing_settings(),
            motion: MotionNoise {
                alpha: self.alpha,
                floor_m: self.odometer_floor_m,
                floor_rad: self.odometer_floor_deg.to_radians(),
            },
            linear_update_m: self.linear_update_m,
            angular_update_rad: self.angular_update_deg.to_radians(),
            temporal_update_s: self.temporal_update_s,
            lost_after_scans: self.lost_after_scans,
            max_odom_jump_m: self.max_odom_jump_m,
            publish_period_s: self.publish_period_s,
            max_cells: self.max_cells,
        })
    }
}
