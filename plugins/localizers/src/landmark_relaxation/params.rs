//! Parameters of global localization by natural landmarks.

use super::fit::FitLimits;
use super::locator::LocatorSettings;
use super::matching::MatchSettings;
use super::next_move::MoveLimits;
use super::refinement::RefinementSettings;
use super::relaxation::RelationTolerance;
use super::search::SearchSettings;
use crate::landmark_noise::LandmarkNoiseParams;
use rumbo_core::registry::Params;
use rumbo_core::stages::{BuildContext, BuildError};
use rumbo_kit::landmark_model::{ModelSettings, Similarity, settings_name};
use rumbo_kit::landmarks::{LandmarkSettings, WallFit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Where the model of a map is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModelCache {
    /// In a file beside the map's, if the map comes from a file.
    #[default]
    BesideMap,
    /// Nowhere: it is built for every run.
    None,
}

/// Finds a robot that may be anywhere on a grid map, by natural landmarks of a planar laser: edges and walls seen all
/// around are looked up in a model of what every cell of the map sees. With a scanner that does not see all around, the
/// robot turns once. A robot that was found is carried on by the odometer: this is a `[relocalizer]`, and another
/// localizer goes on from there.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LandmarkRelaxationParams {
    /// Follow the source without improvements, to compare with its figures: the landmarks of two scans by themselves, walls
    /// by the Hough transform, the middle of a cell as position, and no judgment by the scans. `relation_m` is 0.05 m then,
    /// and the keys `least_explained`, `sure_explained`, `sure_matches`, `most_through`, `least_judged` and `alike` do nothing.
    pub thesis_mode: bool,
    /// Turn and drive the robot where that helps. Without it, what one scan shows must do.
    pub moves: bool,
    /// From so many other places the robot looks again when several places fit, or none.
    pub most_moves: u32,
    /// Length of the way there that is tried first, meters; others are half of it to six times as long. Only where the robot
    /// sees that the way is free.
    pub move_m: f64,
    /// Where the model of the map is kept, so that it is built once: `beside_map` (`MAP.SETTINGS.landmark_model`, with eight digits for these settings) or `none`.
    pub cache: ModelCache,
    /// A file of your own for the model, instead of the one beside the map.
    pub cache_file: Option<PathBuf>,
    /// As far as landmarks are looked at, meters: the reach of the laser.
    pub range_m: f64,
    /// Angle between rays when the model is made, and between readings that are used, degrees.
    pub ray_step_deg: f64,
    /// A jump of the range above this is a discontinuity, meters (mu_d in the source).
    pub discontinuity_m: f64,
    /// A reading farther than this from the chord of its segment is a corner, meters (mu_e).
    pub corner_m: f64,
    /// A straight piece longer than this is a wall, meters (mu_p).
    pub wall_m: f64,
    /// Two landmarks look alike when their distances differ by no more than this, meters.
    pub similar_distance_m: f64,
    /// And their jumps or lengths by no more than this, meters.
    pub similar_extent_m: f64,
    /// Two pairs of landmarks lie alike when their distances from each other differ by no more than this, meters (mu_s).
    pub relation_m: f64,
    /// And the angles between them by no more than this, degrees.
    pub relation_deg: f64,
    /// A place is not believed when it explains a smaller share of the beams.
    pub least_explained: f64,
    /// A place that explains a smaller share of the beams than this is believed only when it fits for a second time, from
    /// elsewhere: things that hide half of the view make other places fit.
    pub sure_explained: f64,
    /// So is one that fewer landmarks name.
    pub sure_matches: usize,
    /// Nor is one when a larger share of the beams passes through what the map shows; where it is above 0.15, the robot is surely
    /// not there, else it may be.
    pub most_through: f64,
    /// Nor when the map says something of a smaller share of the beams.
    pub least_judged: f64,
    /// Of two places whose shares of explained beams differ by no more than this neither is believed.
    pub alike: f64,
    /// Standard deviation of the laser's ranges, meters.
    pub range_deviation_m: f64,
    /// Standard deviation of surfaces on the map, meters.
    pub map_deviation_m: f64,
    /// Standard deviation of a turn by the odometer, for each unit turned.
    pub turn_deviation: f64,
    /// Noise on observed landmarks, for experiments: `{ share = 0.2, distance_m = 0.02, bearing_deg = 5.0 }` is that of the
    /// source.
    pub landmark_noise: Option<LandmarkNoiseParams>,
}

impl Default for LandmarkRelaxationParams {
    fn default() -> Self {
        LandmarkRelaxationParams {
            thesis_mode: false,
            moves: true,
            most_moves: 3,
            move_m: 1.0,
            cache: ModelCache::BesideMap,
            cache_file: None,
            range_m: 8.0,
            ray_step_deg: 1.0,
            discontinuity_m: 0.20,
            corner_m: 0.15,
            wall_m: 0.30,
            similar_distance_m: 0.075,
            similar_extent_m: 0.15,
            relation_m: 0.075,
            relation_deg: 6.0,
            least_explained: 0.6,
            sure_explained: 0.7,
            sure_matches: 5,
            most_through: 0.02,
            least_judged: 0.5,
            alike: 0.05,
            range_deviation_m: 0.015,
            map_deviation_m: 0.01,
            turn_deviation: 0.03,
            landmark_noise: None,
        }
    }
}

impl Params for LandmarkRelaxationParams {
    fn check(&self) -> Vec<BuildError> {
        // More than the largest is surely not meant, and would take memory without end.
        let limits = [
            ("move_m", self.move_m, 0.05..=20.0),
            ("range_m", self.range_m, 0.5..=80.0),
            ("ray_step_deg", self.ray_step_deg, 0.1..=10.0),
            ("discontinuity_m", self.discontinuity_m, 0.01..=10.0),
            ("corner_m", self.corner_m, 0.01..=10.0),
            ("wall_m", self.wall_m, 0.01..=10.0),
            ("similar_distance_m", self.similar_distance_m, 0.01..=2.0),
            ("similar_extent_m", self.similar_extent_m, 0.02..=2.0),
            ("relation_m", self.relation_m, 0.001..=2.0),
            ("relation_deg", self.relation_deg, 0.01..=90.0),
            ("least_explained", self.least_explained, 0.0..=1.0),
            ("sure_explained", self.sure_explained, 0.0..=1.0),
            ("most_through", self.most_through, 0.0..=1.0),
            ("least_judged", self.least_judged, 0.0..=1.0),
            ("alike", self.alike, 0.0..=1.0),
            ("range_deviation_m", self.range_deviation_m, 1e-4..=1.0),
            ("map_deviation_m", self.map_deviation_m, 1e-4..=1.0),
            ("turn_deviation", self.turn_deviation, 0.0..=1.0),
        ];
        let outside = limits.into_iter().filter(|(_, value, range)| !range.contains(value));
        let mut faults: Vec<BuildError> = outside
            .map(|(key, value, range)| {
                let expected = format!("expected {} to {}", range.start(), range.end());
                BuildError::at(key, format!("is {value}, {expected}"))
            })
            .collect();
        if self.most_moves > 100 {
            faults.push(BuildError::at("most_moves", format!("is {}, expected 0 to 100", self.most_moves)));
        }
        faults.extend(self.landmark_noise.iter().flat_map(LandmarkNoiseParams::faults));
        if self.cache == ModelCache::None && self.cache_file.is_some() {
            let message = "is given, but cache = \"none\" keeps no model";
            faults.push(BuildError::at("cache_file", message).help("leave one of the two out"));
        }
        faults
    }
}

/// Air around a robot that goes where it has never been, meters.
const AIR_M: f64 = 0.10;
/// Tolerance of distances between landmarks in the source, meters.
const THESIS_RELATION_M: f64 = 0.05;

impl LandmarkRelaxationParams {
    /// How the model is made.
    pub fn model(&self) -> ModelSettings {
        let is_better = !self.thesis_mode;
        ModelSettings {
            n_rays: (360.0 / self.ray_step_deg).round() as usize,
            range_m: self.range_m,
            landmarks: LandmarkSettings {
                discontinuity_m: self.discontinuity_m,
                corner_m: self.corner_m,
                wall_m: self.wall_m,
                wall_fit: if is_better { WallFit::Tls } else { WallFit::Hough },
                spares_grazed_walls: is_better,
                range_deviation_m: self.range_deviation_m,
                ..LandmarkSettings::default()
            },
        }
    }

    /// How places are found and judged.
    pub fn locator(&self) -> LocatorSettings {
        let is_better = !self.thesis_mode;
        LocatorSettings {
            is_thesis: self.thesis_mode,
            matching: MatchSettings {
                model: self.model(),
                alike: Similarity { distance_m: self.similar_distance_m, extent_m: self.similar_extent_m },
                relation: RelationTolerance {
                    distance_m: if is_better { self.relation_m } else { THESIS_RELATION_M },
                    angle_rad: self.relation_deg.to_radians(),
                    is_signed: true,
                },
                tells_headings: is_better,
            },
            refinement: RefinementSettings {
                range_deviation_m: self.range_deviation_m,
                map_deviation_m: self.map_deviation_m,
                turn_deviation: self.turn_deviation,
            },
            limits: FitLimits {
                explained: self.least_explained,
                sure: self.sure_explained,
                sure_matches: self.sure_matches,
                through: self.most_through,
                judged: self.least_judged,
                alike: self.alike,
            },
            noise: self.landmark_noise.map(|noise| noise.noise()),
        }
    }

    /// What a search with a robot of this radius may do.
    pub fn search(&self, radius_m: f64) -> SearchSettings {
        SearchSettings {
            moves: self.moves,
            most_moves: self.most_moves,
            limits: MoveLimits { radius_m: radius_m + AIR_M, way_m: self.move_m, reach_m: self.range_m },
        }
    }

    /// Where the model of the map is kept; nowhere when nobody may write, or when the map has no file.
    pub fn model_file(&self, context: &BuildContext) -> Option<PathBuf> {
        if context.dry_run || self.cache == ModelCache::None {
            return None;
        }
        let own = self.cache_file.as_ref().map(|file| context.resolve(file));
        let ending = || format!("{}.landmark_model", settings_name(&self.model()));
        let beside = || Some(context.world_map.as_ref()?.with_extension(ending()));
        own.or_else(beside)
    }
}
