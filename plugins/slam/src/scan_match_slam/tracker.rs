//! Predict, match, judge, insert: one scan after another.

use super::motion::{Motion, Step};
use super::place_search::PlaceSearch;
use super::settings::{Counters, TrackerSettings};
use nalgebra::{Matrix3, Rotation2};
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::map::{GridFault, Map};
use rumbo_core::messages::{LaserScan, Observation, Seen, SensorId};
use rumbo_core::time::Time;
use rumbo_kit::occupancy::{ScanMapper, UpdateGate};
use rumbo_kit::scan_match::{MatchStatus, PosePrior, ScanMatch, ScanPoints, levels_of, match_scan};

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
    /// Covariance of the motion since the last match.
    pub(super) drift: Matrix3<f64>,
    pub(super) way_without_match_m: f64,
    pub(super) n_without_match: u32,
    pub(super) is_blank: bool,
    pub(super) status: MatchStatus,
    pub(super) counters: Counters,
    pub(super) trajectory: Vec<(Time, Pose2)>,
    /// The levels once more: what a save needs, which does not see the map, and must not share its cells.
    pub(super) kept: Map,
    points: ScanPoints,
    places: PlaceSearch,
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
            drift: Matrix3::zeros(),
            way_without_match_m: 0.0,
            n_without_match: 0,
            is_blank: true,
            status: MatchStatus::Ok,
            counters: Counters::default(),
            trajectory: Vec::new(),
            kept: Map::default(),
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
        let around = Point2::from(map_from_base.translation.vector);
        self.lay(around, map)?;
        map.touch();
        Ok(())
    }

    fn lay(&mut self, around: Point2, map: &mut Map) -> Result<(), GridFault> {
        let TrackerSettings { size_cells, mapper, .. } = self.settings;
        mapper.pyramid.lay(map, size_cells, around, [0.5, 0.5])?;
        mapper.pyramid.lay(&mut self.kept, size_cells, around, [0.5, 0.5])
    }

    /// Somebody says where the robot is; the next match begins there.
    pub fn relocate(&mut self, place: Option<(Pose2, Matrix3<f64>)>) {
        self.n_without_match = if place.is_some() { 0 } else { self.settings.lost_after_scans.max(1) };
        self.pending = place;
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
        if self.state.is_some_and(|state| observation.stamp <= state.stamp) {
            self.counters.not_newer += 1;
            return Ok(false);
        }
        self.settings.preparation.prepare(scan, &observation.base_from_sensor, &mut self.points);
        let predicted = self.predict(observation.stamp);
        if self.is_blank {
            return self.first(observation, scan, predicted, map);
        }
        let found = self.locate(&predicted, map);
        let tracked = self.judge(found, predicted);
        let inserted = self.may_insert() && self.insert(observation, scan, &tracked.map_from_base, map)?;
        Ok(inserted)
    }

    /// The robot is lost: for long nothing has matched.
    pub fn is_lost(&self) -> bool {
        self.n_without_match >= self.settings.lost_after_scans.max(1)
    }

    fn predict(&mut self, stamp: Time) -> Tracked {
        if let Some((map_from_base, covariance)) = self.pending.take() {
            self.motion.begin(stamp, &map_from_base);
            self.drift = covariance;
            return Tracked { stamp, map_from_base, covariance };
        }
        let Some(state) = self.state else {
            let origin = Pose2::identity();
            self.motion.begin(stamp, &origin);
            return Tracked { stamp, map_from_base: origin, covariance: Matrix3::identity() * 1e-6 };
        };
        let Step { before_from_after, covariance } = self.motion.predict(stamp);
        let axes = in_map(&state.map_from_base);
        let grown = axes * covariance * axes.transpose();
        self.drift += grown;
        self.way_without_match_m += before_from_after.translation.vector.norm();
        Tracked {
            stamp,
            map_from_base: state.map_from_base * before_from_after,
            covariance: state.covariance + grown,
        }
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
        if !self.settings.mapper.pyramid.fits(map) {
            let around = Point2::from(predicted.map_from_base.translation.vector);
            self.lay(around, map)?;
        }
        self.status = MatchStatus::Ok;
        let is_inserted = self.insert(observation, scan, &predicted.map_from_base, map)?;
        self.is_blank = !is_inserted;
        Ok(is_inserted)
    }

    /// Matches around the prediction; where that fails, around the best place near it, and of a lost robot anywhere.
    fn locate(&mut self, predicted: &Tracked, map: &Map) -> (Option<ScanMatch>, MatchStatus) {
        if self.points.len() < self.settings.gate.min_points {
            return (None, MatchStatus::TooFewPoints);
        }
        let (found, status) = self.match_from(&predicted.map_from_base, Some(predicted), map);
        if status.is_match() {
            return (found, status);
        }
        let reach = self.reach();
        if let Some(place) = self.places.near(map, &self.points, &predicted.map_from_base, reach) {
            let (near, near_status) = self.match_from(&place, None, map);
            // It may be a place that only looks alike: so near the prior that must not be believed lightly.
            if near_status == MatchStatus::Ok
                && near.as_ref().is_some_and(|near| near.end.mean_cost() < NEAR_COST)
            {
                self.counters.found_near += 1;
                return (near, near_status);
            }
        }
        let every = self.settings.look_every_scans.max(1);
        let n_lost = self.n_without_match.saturating_sub(self.settings.lost_after_scans);
        let is_due = self.is_lost() && n_lost.is_multiple_of(every);
        if let Some(place) = is_due.then(|| self.places.anywhere(map, &self.points)).flatten() {
            let (far, far_status) = self.match_from(&place, None, map);
            if far_status == MatchStatus::Ok {
                self.counters.found_anywhere += 1;
                return (far, far_status);
            }
        }
        (None, status)
    }

    /// How far the robot may be from the guess: more, the longer nothing has matched.
    fn reach(&self) -> [f64; 2] {
        let deviations = self.drift.diagonal().map(|v| v.max(0.0).sqrt());
        let [way, turn] = self.settings.near_reach;
        let most = [4.0 * way, std::f64::consts::PI];
        [(way + 2.0 * deviations.x.max(deviations.y)).min(most[0]), (turn + 2.0 * deviations.z).min(most[1])]
    }

    fn match_from(
        &self,
        start: &Pose2,
        predicted: Option<&Tracked>,
        map: &Map,
    ) -> (Option<ScanMatch>, MatchStatus) {
        let prior =
            predicted.zip(self.settings.residual_variance).and_then(|(predicted, residual_variance)| {
                let information = self.drift.try_inverse()?;
                Some(PosePrior { map_from_base: predicted.map_from_base, information, residual_variance })
            });
        let levels = levels_of(map);
        let found = match_scan(&levels, &self.points, start, prior.as_ref(), &self.settings.matching);
        let mut gate = self.settings.gate;
        if predicted.is_some() {
            let deviations = self.drift.diagonal().map(|v| v.max(0.0).sqrt());
            gate.max_correction_m = gate.max_correction_m.max(3.0 * deviations.x.max(deviations.y));
            gate.max_correction_rad = gate.max_correction_rad.max(3.0 * deviations.z);
        }
        let status = found.as_ref().map_or(MatchStatus::LowOverlap, |found| gate.judge(found, start));
        (found, status)
    }

    /// What the robot's pose is after all.
    fn judge(&mut self, (found, status): (Option<ScanMatch>, MatchStatus), predicted: Tracked) -> Tracked {
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
        let covariance = fused(&predicted.covariance, &found.covariance);
        let tracked = Tracked { map_from_base: found.map_from_base, covariance, ..predicted };
        self.n_without_match = 0;
        self.way_without_match_m = 0.0;
        self.drift = Matrix3::zeros();
        self.arrive(tracked, true);
        tracked
    }

    fn arrive(&mut self, tracked: Tracked, is_matched: bool) {
        self.motion.arrived(tracked.stamp, &tracked.map_from_base, is_matched);
        self.trajectory.push((tracked.stamp, tracked.map_from_base));
        self.state = Some(tracked);
    }
}

/// A place that was searched for must fit as well as scans fit on the way.
const NEAR_COST: f64 = 0.3;

/// Turns covariances of the base's axes into the map's.
fn in_map(map_from_base: &Pose2) -> Matrix3<f64> {
    let mut axes = Matrix3::identity();
    let turn = Rotation2::new(map_from_base.rotation.angle());
    axes.fixed_view_mut::<2, 2>(0, 0).copy_from(turn.matrix());
    axes
}

/// What two independent sources know together; the second alone where that cannot be told.
fn fused(one: &Matrix3<f64>, other: &Matrix3<f64>) -> Matrix3<f64> {
    let together = || (one.try_inverse()? + other.try_inverse()?).try_inverse();
    let sum = together().unwrap_or(*other);
    (sum + sum.transpose()) * 0.5
}
