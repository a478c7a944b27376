//! From the keys of a pipeline to the settings of the algorithm.

use super::GraphSlamParams;
use crate::graph_slam::atlas::TieSettings;
use crate::graph_slam::loops::LoopSettings;
use crate::graph_slam::registration::RegistrationSettings;
use crate::graph_slam::sheet::SheetSettings;
use crate::graph_slam::surface::SurfaceLimits;
use crate::graph_slam::tracker::TrackerSettings;
use rumbo_kit::occupancy::{BeamLimits, Evidence, EvidenceFault};

/// A point reaches this far along its surface, meters: hardly anything holds it there.
const ALONG_M: f64 = 1.0;
/// Bounds of certainty of a cell.
const LEAST_AND_MOST: [f64; 2] = [0.01, 0.99];

impl GraphSlamParams {
    /// What beams say.
    pub(super) fn evidence(&self) -> Result<Evidence, Vec<EvidenceFault>> {
        let [least, most] = LEAST_AND_MOST;
        Evidence::new(self.update_factor_free, self.update_factor_occupied, least, most)
    }

    /// How the map is drawn; none where the parameters were not checked.
    pub(in crate::graph_slam) fn sheet(&self) -> Option<SheetSettings> {
        Some(SheetSettings {
            resolution_m: self.resolution_m,
            evidence: self.evidence().ok()?,
            limits: BeamLimits {
                min_range_m: self.min_range_m,
                max_range_m: self.map_range_m,
                clear_range_m: self.clear_range_m,
            },
            redrawn_at_once: self.redrawn_at_once as usize,
        })
    }

    /// How the robot is followed.
    pub(in crate::graph_slam) fn tracker(&self) -> TrackerSettings {
        TrackerSettings {
            limits: SurfaceLimits {
                min_range_m: self.min_range_m,
                max_range_m: self.max_range_m,
                noise_growing_1_m: self.noise_growing_1_m as f32,
                ..SurfaceLimits::SLANTED
            },
            tie: self.tie(),
            loops: LoopSettings {
                drift_share: self.loops.drift_share,
                least_reach_m: self.loops.least_reach_m,
                most_reach_m: self.loops.most_reach_m,
                reach_rad: self.loops.reach_deg.to_radians(),
                least_score: self.loops.least_score,
                most_rival: self.loops.most_rival,
                n_lately: self.loops.lately as usize,
                most_places: self.loops.places as usize,
            },
            key_frame_every: [self.key_frame_every_m, self.key_frame_every_deg.to_radians()],
            n_recent: self.recent_key_frames as usize,
            keeps_tracks: true,
            most_visits: self.most_visits as usize,
            min_points: self.min_points as usize,
            optimize_every: self.optimize_every as usize,
            optimize_share: self.optimize_share,
            look_for_loops_every: self.loops.every as usize,
            lost_after_scans: self.lost_after_scans,
            refine_rounds: self.refine_rounds as usize,
        }
    }

    fn tie(&self) -> TieSettings {
        TieSettings {
            registration: RegistrationSettings {
                across_m: self.noise_m,
                along_m: ALONG_M,
                loose_m: self.loose_noise_m,
                gate_m: self.gate_m,
                kernel_c: 3.0,
            },
            believed_share: self.believed_share,
            n_before: self.ties_before as usize,
            n_neighbors: self.ties_around as usize,
            neighbor_reach_m: self.tie_reach_m,
            least_overlap: self.least_overlap,
            least_agreement: self.least_agreement,
            most_surprise: [0.5, 0.2],
            trusted_way_m: self.loops.trusted_way_m,
            odometer: [
                self.odometer_least_m,
                self.odometer_share,
                self.odometer_least_deg.to_radians(),
                self.odometer_turn_share,
            ],
            gyroscope: [
                self.gyroscope_least_deg.to_radians(),
                self.gyroscope_deg_s.to_radians(),
                self.gyroscope_share,
            ],
            kernel_c: self.kernel_deviations,
        }
    }
}
