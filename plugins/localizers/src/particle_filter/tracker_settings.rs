//! What the localizer around the filter is told, and what it counts.

use super::anchor::Anchor;
use super::filter::{Fit, Weighed};
use super::sureness::SurenessRules;
use super::terrain::{Penalties, Terrain};
use rumbo_core::messages::Status;

/// Numbers of the localizer around the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// The filter is updated after this much way, meters.
    pub update_min_d_m: f64,
    /// Or this much turn, radians.
    pub update_min_a_rad: f64,
    /// Beams of a scan that are looked at.
    pub max_beams: usize,
    /// Distance from obstacles of particles that may be anywhere, meters.
    pub init_clearance_m: f64,
    /// While the robot is followed, beams that end on free floor farther than this from everything on the map are not
    /// weighed, meters; 0 weighs all.
    pub unmapped_beyond_m: f64,
    /// Two readings of the odometer farther apart than this are a jump, meters.
    pub max_odom_jump_m: f64,
    /// What impossible places cost.
    pub penalties: Penalties,
    /// Where the best place explains less than this share of the beams, others are searched.
    pub search_below: f64,
    /// While the robot is followed and at most this share of its beams pass through walls, no other place is searched.
    pub doubt_above: f64,
    /// When the robot is lost.
    pub rules: SurenessRules,
    /// The robot may be asked to move.
    pub may_wish: bool,
    /// Radius of the hull, meters.
    pub radius_m: f64,
    /// What the robot can do, m/s and rad/s.
    pub max_speed: [f64; 2],
}

impl TrackerSettings {
    /// How well the place where the robot is taken to be fits what was seen there.
    pub fn fit(&self, anchor: &Anchor, terrain: &Terrain, status: Status) -> Fit {
        let contradicted = terrain.contradicted(&anchor.scans, &anchor.map_from_base);
        let is_likely = contradicted.is_some_and(|share| share <= self.doubt_above);
        match anchor.explained {
            Some(_) if status == Status::Tracking && is_likely => Fit::Good,
            Some(share) if share < self.search_below => Fit::Bad,
            _ => Fit::Unknown,
        }
    }
}

/// What was received, used and dropped since the start; all go up only.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counters {
    /// Updates of the filter with scans.
    pub updates: u64,
    /// Readings of the odometer that came twice, too late, or held a number that is none.
    pub odometry_dropped: u64,
    /// Jumps of the odometer.
    pub odometry_jumps: u64,
    /// Updates without a beam that said anything.
    pub without_beams: u64,
    /// Updates that left no particle with any weight.
    pub degenerate: u64,
}

impl Counters {
    /// Counts an update.
    pub fn count(&mut self, weighed: Weighed) {
        self.updates += 1;
        match weighed {
            Weighed::Nothing => self.without_beams += 1,
            Weighed::Degenerate => self.degenerate += 1,
            Weighed::Done => {}
        }
    }
}
