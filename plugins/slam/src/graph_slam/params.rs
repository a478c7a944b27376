//! Parameters of mapping with a graph of key frames.

mod translation;

use rumbo_core::registry::{Params, Surroundings};
use rumbo_core::stages::BuildError;
use rumbo_kit::occupancy::doubtful_turn;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Builds an occupancy grid and finds the robot in it, by a graph of key frames: scans are registered on each other, places
/// that the robot comes back to are recognized, and all key frames are moved to where they agree best. The most accurate
/// way to map a building; the pose may jump when a loop is closed. With or without an odometer; an inertial unit tells turns better than
/// wheels do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct GraphSlamParams {
    /// Edge of a cell of the map, meters.
    pub resolution_m: f64,
    /// Readings nearer than this are left out, meters.
    pub min_range_m: f64,
    /// Readings farther than this are left out when scans are registered, meters.
    pub max_range_m: f64,
    /// Readings farther than this are not drawn into the map, meters.
    pub map_range_m: f64,
    /// Space that a beam without an echo is taken to have free, meters; 0 where such a beam says nothing.
    pub clear_range_m: f64,
    /// Probability that a cell that a beam passes is occupied.
    pub update_factor_free: f64,
    /// Probability that a cell that a beam ends in is occupied.
    pub update_factor_occupied: f64,
    /// Scans with fewer points say nothing.
    pub min_points: u32,
    /// A scan becomes a key frame when the robot has gone so far since the last one, meters ...
    pub key_frame_every_m: f64,
    /// ... or turned so far, degrees.
    pub key_frame_every_deg: f64,
    /// A place that was mapped at so many visits gets no more key frames while what is seen there fits, so that a robot on patrol
    /// needs no more memory and time from lap to lap.
    pub most_visits: u32,
    /// Key frames that a scan is registered on: the last so many.
    pub recent_key_frames: u32,
    /// Key frames before a new one that it is tied to.
    pub ties_before: u32,
    /// Key frames of earlier visits that it is tied to: the nearest so many.
    pub ties_around: u32,
    /// How far away these may be, meters; a turn of one radian counts half a meter.
    pub tie_reach_m: f64,
    /// Noise of a point across the surface that it lies on, meters.
    pub noise_m: f64,
    /// Noise of a point that lies on no surface, meters.
    pub loose_noise_m: f64,
    /// The noise of a reading grows by this times the square of its range, 1/m: 0.0015 for a depth camera, 0 for a laser. Where it
    /// does, points are moved onto the line through their neighbors, and count by what noise that leaves.
    pub noise_growing_1_m: f64,
    /// Points farther apart than this are no pair, meters.
    pub gate_m: f64,
    /// Share of the information of all pairs of points that is believed: neighboring points err alike.
    pub believed_share: f64,
    /// Share of a scan's points that must have a partner.
    pub least_overlap: f64,
    /// How well these must agree, 0 to 1.
    pub least_agreement: f64,
    /// Error of the odometer from one scan to the next: at least, meters. Scans overrule it where they know better.
    pub odometer_least_m: f64,
    /// Its error as a share of the way.
    pub odometer_share: f64,
    /// Error of its turn: at least, degrees.
    pub odometer_least_deg: f64,
    /// The same as a share of the turn.
    pub odometer_turn_share: f64,
    /// Error of a gyroscope's turn from one scan to the next, or from one key frame to the next: at least, degrees ...
    pub gyroscope_least_deg: f64,
    /// ... with time, degrees a second ...
    pub gyroscope_deg_s: f64,
    /// ... and as a share of the turn.
    pub gyroscope_share: f64,
    /// Deviations at which a tie between key frames begins to count less: false ones shall not bend the map.
    pub kernel_deviations: f64,
    /// How loops are found.
    pub loops: LoopParams,
    /// Key frames from one optimization to the next, at least.
    pub optimize_every: u32,
    /// The same as a share of all key frames, so that large maps do not cost more and more.
    pub optimize_share: f64,
    /// Times that all neighbors are registered anew, from where they are then, when the trajectory is asked for.
    pub refine_rounds: u32,
    /// Scans that fit nowhere before the robot says that it is lost, and looks for its place in the whole map.
    pub lost_after_scans: u32,
    /// Key frames drawn anew at one update at most, when a loop has moved them.
    pub redrawn_at_once: u32,
}

/// How places are recognized that the robot comes back to after a long way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LoopParams {
    /// Key frames from one look for loops to the next.
    pub every: u32,
    /// Places to which the graph knows a shorter way than this need no search, meters.
    pub trusted_way_m: f64,
    /// Share of the way that the place may be off.
    pub drift_share: f64,
    /// At least so far is searched, meters.
    pub least_reach_m: f64,
    /// And at most so far.
    pub most_reach_m: f64,
    /// Turns to each side, degrees.
    pub reach_deg: f64,
    /// How well what was seen lately must fit on a place, 0 to 1.
    pub least_score: f64,
    /// It must fit less elsewhere, by this share: else it could be several places.
    pub most_rival: f64,
    /// Key frames that what was seen lately consists of. A narrow view, as that of a depth camera, wants about 4: what it saw
    /// before was seen by nobody from the place that it comes back to.
    pub lately: u32,
    /// Places that are searched at one look at most.
    pub places: u32,
}

impl Default for LoopParams {
    fn default() -> Self {
        LoopParams {
            every: 4,
            trusted_way_m: 15.0,
            drift_share: 0.06,
            least_reach_m: 1.0,
            most_reach_m: 20.0,
            reach_deg: 30.0,
            least_score: 0.55,
            most_rival: 0.9,
            lately: 16,
            places: 8,
        }
    }
}

impl Default for GraphSlamParams {
    fn default() -> Self {
        GraphSlamParams {
            resolution_m: 0.05,
            min_range_m: 0.1,
            max_range_m: 40.0,
            map_range_m: 20.0,
            clear_range_m: 0.0,
            update_factor_free: 0.45,
            update_factor_occupied: 0.9,
            min_points: 30,
            key_frame_every_m: 0.25,
            key_frame_every_deg: 10.0,
            most_visits: 4,
            recent_key_frames: 10,
            ties_before: 3,
            ties_around: 6,
            tie_reach_m: 3.0,
            noise_m: 0.02,
            loose_noise_m: 0.3,
            noise_growing_1_m: 0.0,
            gate_m: 0.2,
            believed_share: 0.05,
            least_overlap: 0.4,
            least_agreement: 0.35,
            odometer_least_m: 0.1,
            odometer_share: 0.1,
            odometer_least_deg: 2.0,
            odometer_turn_share: 0.5,
            gyroscope_least_deg: 0.1,
            gyroscope_deg_s: 0.3,
            gyroscope_share: 0.01,
            kernel_deviations: 3.0,
            loops: LoopParams::default(),
            optimize_every: 10,
            optimize_share: 0.04,
            refine_rounds: 2,
            lost_after_scans: 20,
            redrawn_at_once: 20,
        }
    }
}

impl Params for GraphSlamParams {
    fn check(&self) -> Vec<BuildError> {
        let loops = &self.loops;
        let mut faults = Vec::new();
        let above_zero = [
            ("resolution_m", self.resolution_m),
            ("max_range_m", self.max_range_m),
            ("map_range_m", self.map_range_m),
            ("key_frame_every_m", self.key_frame_every_m),
            ("key_frame_every_deg", self.key_frame_every_deg),
            ("noise_m", self.noise_m),
            ("loose_noise_m", self.loose_noise_m),
            ("gate_m", self.gate_m),
            ("odometer_least_m", self.odometer_least_m),
            ("odometer_least_deg", self.odometer_least_deg),
            ("gyroscope_least_deg", self.gyroscope_least_deg),
            ("kernel_deviations", self.kernel_deviations),
            ("loops.trusted_way_m", loops.trusted_way_m),
            ("loops.most_reach_m", loops.most_reach_m),
            ("loops.reach_deg", loops.reach_deg),
        ];
        let zero_or_more = [
            ("min_range_m", self.min_range_m),
            ("clear_range_m", self.clear_range_m),
            ("tie_reach_m", self.tie_reach_m),
            ("odometer_share", self.odometer_share),
            ("odometer_turn_share", self.odometer_turn_share),
            ("gyroscope_deg_s", self.gyroscope_deg_s),
            ("gyroscope_share", self.gyroscope_share),
            ("noise_growing_1_m", self.noise_growing_1_m),
            ("optimize_share", self.optimize_share),
            ("loops.drift_share", loops.drift_share),
            ("loops.least_reach_m", loops.least_reach_m),
        ];
        let shares = [
            ("believed_share", self.believed_share),
            ("least_overlap", self.least_overlap),
            ("least_agreement", self.least_agreement),
            ("loops.least_score", loops.least_score),
            ("loops.most_rival", loops.most_rival),
        ];
        let counts = [
            ("min_points", self.min_points, 3),
            ("recent_key_frames", self.recent_key_frames, 1),
            ("most_visits", self.most_visits, 1),
            ("optimize_every", self.optimize_every, 1),
            ("lost_after_scans", self.lost_after_scans, 1),
            ("redrawn_at_once", self.redrawn_at_once, 1),
            ("loops.every", loops.every, 1),
            ("loops.lately", loops.lately, 1),
        ];
        let mut refuse = |key: &str, found: String, expected: &str| {
            faults.push(BuildError::at(key, format!("is {found}, expected {expected}")));
        };
        for (key, value) in above_zero.into_iter().filter(|(_, v)| !(*v > 0.0 && v.is_finite())) {
            refuse(key, value.to_string(), "a finite number above 0");
        }
        for (key, value) in zero_or_more.into_iter().filter(|(_, v)| !(*v >= 0.0 && v.is_finite())) {
            refuse(key, value.to_string(), "a finite number, 0 or more");
        }
        for (key, value) in shares.into_iter().filter(|(_, v)| !(*v > 0.0 && *v <= 1.0)) {
            refuse(key, value.to_string(), "a number above 0, 1 at most");
        }
        for (key, value, least) in counts.into_iter().filter(|(_, v, least)| v < least) {
            refuse(key, value.to_string(), &format!("{least} or more"));
        }
        if self.max_range_m <= self.min_range_m {
            refuse("max_range_m", self.max_range_m.to_string(), "more than min_range_m");
        }
        if let Err(wrong) = self.evidence() {
            faults.extend(wrong.into_iter().map(|fault| {
                BuildError::at(fault.name, format!("is {}, expected {}", fault.found, fault.expected))
            }));
        }
        faults
    }

    fn doubts(&self, surroundings: &Surroundings) -> Vec<BuildError> {
        doubtful_turn("key_frame_every_deg", self.key_frame_every_deg, surroundings.narrowest_view_rad)
            .into_iter()
            .collect()
    }
}
