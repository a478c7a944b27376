//! One scan on the map: what the map lets expect at the pose by odometry is related to what is seen, and moves the pose
//! (not in the source, which relates each scan to the one before).

use super::all_pairs::{ByPairs, Solution, by_pairs};
use super::correspondence::{Relation, relate};
use super::covariance::{in_axes_of, moved_by};
use super::expected_scan::ExpectedScan;
use super::explained::explained_share;
use super::joint::{Joint, Posterior};
use super::landmark_errors::LandmarkErrors;
use super::mapped_marks::MappedMark;
use super::scan::{Found, SeenScan};
use super::sighting::Sighting;
use super::sureness::LEAST_RELATED;
use super::tracker::{PairRules, TrackerSettings};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_core::map::Grid;
use rumbo_kit::landmarks::{Extractor, Landmark};

/// Follows a robot on a map.
#[derive(Debug)]
pub struct OnMap {
    settings: TrackerSettings,
    extractor: Extractor,
    expected: ExpectedScan,
    known: Vec<Landmark>,
    joint: Joint,
    n_scans: u64,
    /// Scans in a row that refused the pose.
    n_refused: u32,
}

/// The map is looked at anew from a pose that moved by more than this: meters and radians (2 degrees).
const ANEW: (f64, f64) = (0.03, 0.035);
/// At most so often.
const N_LOOKS: usize = 4;
/// A pose is less sure than it thinks if in so many scans in a row another explains so many landmarks more. Noise on
/// landmarks and people do not do that: no pose explains them.
const REFUSED_SCANS: u32 = 3;
const MORE_FIT: usize = 2;
/// By that much, meters and radians.
const DOUBT: (f64, f64) = (0.15, 0.05);

impl OnMap {
    /// Begins at a pose.
    pub fn new(settings: &TrackerSettings, map_from_base: &Pose2, covariance: &Matrix3<f64>) -> OnMap {
        OnMap {
            settings: *settings,
            extractor: Extractor::new(settings.landmarks),
            expected: ExpectedScan::default(),
            known: Vec::new(),
            joint: Joint::new(map_from_base, covariance),
            n_scans: 0,
            n_refused: 0,
        }
    }

    /// Where the odometer leads; see [`Joint::carried`].
    pub fn carried(&self, way: &Pose2, noise: [f64; 3]) -> (Pose2, Matrix3<f64>) {
        self.joint.carried(way, noise)
    }

    /// The robot moved; see [`Joint::carry`].
    pub fn carry(&mut self, way: &Pose2, noise: [f64; 3]) {
        self.joint.carry(way, noise);
    }

    /// The robot may have moved; see [`Joint::widen`].
    pub fn widen(&mut self, [reach_m, turn_rad]: [f64; 2]) {
        self.joint.widen(reach_m, turn_rad);
    }

    /// There is no map now: the odometry stands.
    pub fn look_without_map(&mut self, way: &Pose2, noise: [f64; 3]) -> Found {
        self.joint.carry(way, noise);
        Found::by_odometry(self.joint.map_from_base(), self.joint.pose_covariance(), 0)
    }

    /// The landmarks of `seen`, a scan, say where the robot is, of which the odometer says that it moved by `way`.
    pub fn look(
        &mut self,
        scan: &SeenScan<'_>,
        seen: &[Landmark],
        (way, noise): (&Pose2, [f64; 3]),
        map: (u64, &Grid),
    ) -> Found {
        self.n_scans += 1;
        self.joint.carry(way, noise);
        let (predicted, covariance) = (self.joint.map_from_base(), self.joint.pose_covariance());
        match self.settings.pairs {
            Some(rules) => {
                let found = self.by_pairs(scan, seen, (predicted, covariance), map, &rules);
                self.joint = Joint::new(&found.map_from_base, &found.covariance);
                found
            }
            None => self.by_all(scan, seen, predicted, map),
        }
    }

    /// Landmarks that the map lets expect from a place of the sensor, and the share of the scan that it explains.
    fn expect(&mut self, scan: &SeenScan<'_>, map_from_sensor: &Pose2, map: (u64, &Grid)) -> Option<f64> {
        let fan = &scan.fan;
        let ranges = self.expected.trace(map, map_from_sensor, fan, scan.ranges_m.len());
        self.known.clear();
        self.known.extend_from_slice(self.extractor.extract(fan, ranges.iter().copied()));
        explained_share(ranges, scan.ranges_m, fan.min_range_m, fan.max_range_m)
    }

    fn by_pairs(
        &mut self,
        scan: &SeenScan<'_>,
        seen: &[Landmark],
        (predicted, covariance): (Pose2, Matrix3<f64>),
        map: (u64, &Grid),
        rules: &PairRules,
    ) -> Found {
        let base = scan.base_from_sensor;
        let map_from_a = predicted * base;
        let explained = self.expect(scan, &map_from_a, map);
        let arm = predicted.rotation * base.translation.vector;
        let local = in_axes_of(&map_from_a, &moved_by(&covariance, &arm));
        let odometry = Solution { a_from_b: Pose2::identity(), covariance: local };
        let relations = relate(&self.known, seen, &odometry.a_from_b, &self.settings.within);
        let mut found = Found::by_odometry(predicted, covariance, relations.len());
        found.explained = explained;
        if relations.len() < LEAST_RELATED {
            return found;
        }
        if let Some(ByPairs { solution, n_estimates }) = by_pairs(&relations, &odometry, rules) {
            let map_from_sensor = map_from_a * solution.a_from_b;
            found.map_from_base = map_from_sensor * base.inverse();
            let back = found.map_from_base.translation.vector - map_from_sensor.translation.vector;
            found.covariance = moved_by(&in_axes_of(&map_from_a.inverse(), &solution.covariance), &back);
            found.n_estimates = n_estimates;
        }
        found
    }

    fn by_all(
        &mut self,
        scan: &SeenScan<'_>,
        seen: &[Landmark],
        predicted: Pose2,
        map: (u64, &Grid),
    ) -> Found {
        let errors = self.settings.errors.on_cells_of(map.1.resolution_m());
        let mut found = Found::by_odometry(predicted, self.joint.pose_covariance(), 0);
        let mut pose =
            Vector3::new(predicted.translation.x, predicted.translation.y, predicted.rotation.angle());
        let mut accepted: Option<Posterior> = None;
        for _ in 0..N_LOOKS {
            let map_from_sensor = pose2(pose.x, pose.y, pose.z) * scan.base_from_sensor;
            found.explained = self.expect(scan, &map_from_sensor, map);
            let relations = relate(&self.known, seen, &Pose2::identity(), &self.settings.within);
            found.n_related = relations.len();
            let sightings = self.sightings(&relations, &map_from_sensor, &errors);
            let Some(posterior) = self.joint.posterior(&sightings, &pose, &scan.base_from_sensor) else {
                break;
            };
            let moved = posterior.pose() - pose;
            pose = posterior.pose();
            let is_settled = moved.xy().norm() <= ANEW.0 && wrap_angle(moved.z).abs() <= ANEW.1;
            if is_settled {
                self.watch_refusals(&sightings, &posterior, &scan.base_from_sensor);
            }
            accepted = Some(posterior);
            if is_settled {
                break;
            }
        }
        let n_possible = accepted.as_ref().map_or(0, |posterior| posterior.n_possible);
        found.n_estimates = n_possible;
        if let Some(posterior) = accepted.filter(|_| n_possible >= LEAST_RELATED) {
            self.joint.accept(posterior);
        }
        if self.n_refused >= REFUSED_SCANS {
            self.n_refused = 0;
            self.joint.widen(DOUBT.0, DOUBT.1);
        }
        found.map_from_base = self.joint.map_from_base();
        found.covariance = self.joint.pose_covariance();
        found.n_related = n_possible;
        found
    }

    /// Counts scans in a row that a pose farther off than it may be would explain much better, and most of.
    fn watch_refusals(&mut self, sightings: &[Sighting], posterior: &Posterior, base_from_sensor: &Pose2) {
        let n = sightings.len();
        let is_refused = n >= posterior.n_fit + MORE_FIT && {
            let mut doubting = self.joint.clone();
            doubting.widen(DOUBT.0, DOUBT.1);
            let freely = doubting.posterior(sightings, &posterior.pose(), base_from_sensor);
            let n_fit = freely.map_or(0, |freely| freely.n_fit);
            n_fit >= posterior.n_fit + MORE_FIT && 3 * n_fit >= 2 * n
        };
        self.n_refused = if is_refused { self.n_refused + 1 } else { 0 };
    }

    fn sightings(
        &mut self,
        relations: &[Relation],
        map_from_sensor: &Pose2,
        errors: &LandmarkErrors,
    ) -> Vec<Sighting> {
        let Self { joint, extractor, n_scans, .. } = self;
        let readings = extractor.readings();
        let sighting = |relation: &Relation| {
            let [a, b] = relation.known.beams.map(|idx| readings.get(idx as usize).map(|r| r.place));
            let mapped = MappedMark::of(&relation.known, [a?, b?], map_from_sensor);
            let (slot, pivot) = joint.slot_of(mapped, *n_scans, errors);
            Some(Sighting::new(relation, mapped, pivot, slot, errors))
        };
        relations.iter().filter_map(sighting).collect()
    }
}
