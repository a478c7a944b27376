//! Predict, match, judge, insert: one scan after another.

use super::locating::{Located, Look};
use super::motion::Motion;
use super::place_search::PlaceSearch;
use super::settings::{Counters, TrackerSettings};
use crate::unseen::Told;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;
use rumbo_core::map::{Grid, GridFault, Map};
use rumbo_core::messages::{LaserScan, Observation, Seen, SensorId};
use rumbo_core::time::Time;
use rumbo_kit::occupancy::{ScanMapper, UpdateGate};
use rumbo_kit::scan_match::{MatchStatus, ScanPoints, SurfaceMap};

/// Where the robot is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracked {
    /// When.
    pub stamp: Time,
    /// The robot.
    pub map_from_base: Pose2,
    /// Of x, y, yaw in the map's axes.
    pub covariance: Matrix3<f64>,
}

/// The state of one run.
#[derive(Debug)]
pub struct ScanTracker {
    pub(super) settings: TrackerSettings,
    pub(super) motion: Motion,
    pub(super) mapper: ScanMapper,
    pub(super) gates: Vec<(SensorId, UpdateGate)>,
    pub(super) state: Option<Tracked>,
    /// The robot before its first scan, or where somebody said it is.
    pub(super) pending: Option<(Pose2, Matrix3<f64>)>,
    /// The last prediction is where somebody said that the robot is.
    pub(super) is_put: bool,
    /// Stamps up to this are not newer; none where another clock may have begun.
    pub(super) newest: Option<Time>,
    /// It goes on from what was saved, by the same clock or another.
    pub(super) is_resumed: bool,
    /// Covariance of the motion since the last match.
    pub(super) drift: Matrix3<f64>,
    /// The odometer is part of the drift.
    pub(super) is_by_odometer: bool,
    pub(super) way_without_match_m: f64,
    /// How well the prior knew what the last match did not see, meters.
    pub(super) blind_deviation_m: f64,
    pub(super) n_without_match: u32,
    pub(super) is_blank: bool,
    pub(super) status: MatchStatus,
    pub(super) counters: Counters,
    pub(super) trajectory: Vec<(Time, Pose2)>,
    /// What scans are matched against.
    pub(super) levels: Map,
    /// And then, finer than their cells.
    pub(super) surfaces: Option<SurfaceMap>,
    /// Draws the map that is published.
    pub(super) drawer: ScanMapper,
    /// That map as it is between updates: what a save needs, which does not see it. Shares its cells.
    pub(super) drawn: Option<Grid>,
    /// The levels as they were when nobody knew any more how far the robot went between bare walls, until it is seen on them
    /// again.
    pub(super) sure_levels: Option<Map>,
    pub(super) look: Look,
    pub(super) points: ScanPoints,
    pub(super) places: PlaceSearch,
}

impl ScanTracker {
    /// Nothing was seen yet.
    pub fn new(settings: TrackerSettings) -> ScanTracker {
        ScanTracker {
            settings,
            motion: Motion::new(settings.prediction, settings.errors),
            mapper: ScanMapper::new(settings.mapper),
            gates: Vec::new(),
            state: None,
            pending: None,
            is_put: false,
            newest: None,
            is_resumed: false,
            drift: Matrix3::zeros(),
            is_by_odometer: false,
            way_without_match_m: 0.0,
            blind_deviation_m: 0.0,
            n_without_match: 0,
            is_blank: true,
            status: MatchStatus::Ok,
            counters: Counters::default(),
            trajectory: Vec::new(),
            levels: Map::default(),
            surfaces: None,
            drawer: ScanMapper::new(settings.drawing()),
            drawn: None,
            sure_levels: None,
            look: Look::default(),
            points: ScanPoints::default(),
            places: PlaceSearch::new(settings.places),
        }
    }

    /// An empty map around the pose where the robot begins.
    pub fn begin(
        &mut self,
        map_from_base: Pose2,
        covariance: Matrix3<f64>,
        map: &mut Map,
    ) -> Result<(), GridFault> {
        *self = ScanTracker::new(self.settings);
        self.pending = Some((map_from_base, covariance));
        self.lay(&map_from_base, map)?;
        map.touch();
        Ok(())
    }

    /// Somebody says where the robot is, and the next match begins there; or that nobody knows. What clock and odometer
    /// said before says nothing any more.
    pub fn relocate(&mut self, place: Option<(Pose2, Matrix3<f64>)>) {
        self.n_without_match = if place.is_some() { 0 } else { self.settings.lost_after_scans.max(1) };
        self.look = Look { is_anywhere: place.is_none(), ..Look::default() };
        self.pending = place;
        self.sure_levels = None;
        self.forget_clock();
    }

    fn forget_clock(&mut self) {
        self.newest = None;
        self.motion = Motion::new(self.settings.prediction, self.settings.errors);
    }

    /// Follows the sensors that say how the robot moves.
    pub fn follow(&mut self, seen: Seen<'_>) {
        self.motion.take(seen);
    }

    /// Takes in a scan. Returns whether the map changed.
    pub fn take(
        &mut self,
        observation: &Observation,
        scan: &LaserScan,
        map: &mut Map,
    ) -> Result<bool, GridFault> {
        self.counters.received += 1;
        let is_newer = self.newest.is_none_or(|newest| observation.stamp > newest);
        if std::mem::take(&mut self.is_resumed) && !self.goes_on_at(observation.stamp) {
            self.begin_where_it_was();
        } else if !is_newer {
            self.counters.not_newer += 1;
            return Ok(false);
        }
        self.settings.preparation.prepare(scan, &observation.base_from_sensor, &mut self.points);
        let predicted = self.predict(observation.stamp);
        if self.is_blank {
            return self.first(observation, scan, predicted, map);
        }
        let located = self.locate(&predicted);
        let tracked = self.judge(located, predicted);
        let inserted = self.may_insert() && self.insert(observation, scan, &tracked.map_from_base, map)?;
        Ok(inserted)
    }

    /// Keeps the map that is published, for a save.
    pub fn keep(&mut self, map: &Map) {
        self.drawn = map.grid.clone();
    }

    /// The clock is the one that was saved, and hardly any time has passed.
    fn goes_on_at(&self, stamp: Time) -> bool {
        let pause_s = self.newest.map_or(f64::INFINITY, |newest| (stamp - newest).as_secs());
        pause_s > 0.0 && pause_s <= LONGEST_PAUSE_S
    }

    /// Nothing is known of the time since it was saved, but that the robot will hardly have been moved.
    fn begin_where_it_was(&mut self) {
        let moved =
            Matrix3::from_diagonal(&Vector3::from(MOVED_WHILE_OFF.map(|deviation| deviation * deviation)));
        let place = self.state.map(|state| (state.map_from_base, state.covariance + moved));
        self.pending = self.pending.or(place);
        self.forget_clock();
    }

    /// The robot is lost: for long nothing has matched.
    pub fn is_lost(&self) -> bool {
        self.n_without_match >= self.settings.lost_after_scans.max(1)
    }

    fn predict(&mut self, stamp: Time) -> Tracked {
        self.is_put = self.pending.is_some();
        if let Some((map_from_base, covariance)) = self.pending.take() {
            self.motion.begin(stamp, &map_from_base);
            (self.drift, self.is_by_odometer) = (covariance, false);
            return Tracked { stamp, map_from_base, covariance };
        }
        let Some(state) = self.state else {
            let origin = Pose2::identity();
            self.motion.begin(stamp, &origin);
            return Tracked { stamp, map_from_base: origin, covariance: Matrix3::identity() * 1e-6 };
        };
        let (step, grown) = self.step_to(&state, stamp);
        self.is_by_odometer |= step.is_by_odometer;
        self.drift += grown;
        self.way_without_match_m += step.before_from_after.translation.vector.norm();
        state.after(&step, &grown, stamp)
    }

    fn first(
        &mut self,
        observation: &Observation,
        scan: &LaserScan,
        predicted: Tracked,
        map: &mut Map,
    ) -> Result<bool, GridFault> {
        self.arrive(predicted, true);
        if self.points.len() < self.settings.gate.min_points {
            self.counters.too_few_points += 1;
            self.status = MatchStatus::TooFewPoints;
            return Ok(false);
        }
        if !self.mapper.pyramid().fits(&self.levels) || !self.drawer.pyramid().fits(map) {
            self.lay(&predicted.map_from_base, map)?;
        }
        self.status = MatchStatus::Ok;
        let is_inserted = self.insert(observation, scan, &predicted.map_from_base, map)?;
        self.is_blank = !is_inserted;
        Ok(is_inserted)
    }

    /// What the robot's pose is after all.
    fn judge(&mut self, located: Located, predicted: Tracked) -> Tracked {
        let Located { found, status, is_searched } = located;
        self.status = status;
        let counter = match status {
            MatchStatus::Ok => &mut self.counters.matched,
            MatchStatus::Degenerate => &mut self.counters.degenerate,
            MatchStatus::TooFewPoints => &mut self.counters.too_few_points,
            MatchStatus::LowOverlap => &mut self.counters.low_overlap,
            MatchStatus::Diverged => &mut self.counters.diverged,
        };
        *counter += 1;
        let Some(found) = found.filter(|_| status.is_match()) else {
            self.n_without_match = self.n_without_match.saturating_add(1);
            self.arrive(predicted, false);
            return predicted;
        };
        let tracked = if is_searched {
            // The robot is not where it was thought to be: the way there is no motion, and the guess knew nothing.
            self.motion.begin(predicted.stamp, &found.map_from_base);
            let told = Told::ByWheels { deviation_m: 0.0 };
            let covariance = self.known_after(&found, &found.covariance, &predicted.covariance, told);
            Tracked { map_from_base: found.map_from_base, covariance, ..predicted }
        } else {
            let together = fused(&predicted.covariance, &found.covariance);
            let (before, told) = self.told_beside(&predicted);
            let covariance = self.known_after(&found, &together, &before, told);
            Tracked { map_from_base: found.map_from_base, covariance, ..predicted }
        };
        self.n_without_match = 0;
        self.way_without_match_m = 0.0;
        self.look = Look::default();
        self.blind_deviation_m = found.seen.blind_deviation_m(&self.drift);
        self.drift = Matrix3::zeros();
        self.is_by_odometer = false;
        self.arrive(tracked, true);
        tracked
    }

    fn arrive(&mut self, tracked: Tracked, is_matched: bool) {
        self.motion.arrived(tracked.stamp, &tracked.map_from_base, is_matched);
        // Stamps of a clock that was replaced say nothing beside those of the new one.
        while self.trajectory.last().is_some_and(|(stamp, _)| *stamp >= tracked.stamp) {
            self.trajectory.pop();
        }
        self.trajectory.push((tracked.stamp, tracked.map_from_base));
        self.state = Some(tracked);
        self.newest = Some(tracked.stamp);
    }
}

/// A saved state that is older is gone on from as by another clock, seconds.
const LONGEST_PAUSE_S: f64 = 1.0;
/// How far a robot may be from where it was saved: along x and y (m), yaw (rad).
const MOVED_WHILE_OFF: [f64; 3] = [0.1, 0.1, 0.1];

/// What two independent sources know together; the second alone where that cannot be told.
fn fused(one: &Matrix3<f64>, other: &Matrix3<f64>) -> Matrix3<f64> {
    let together = || (one.try_inverse()? + other.try_inverse()?).try_inverse();
    let sum = together().unwrap_or(*other);
    (sum + sum.transpose()) * 0.5
}
