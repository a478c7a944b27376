//! From readings to a belief: what comes when, which mark is which, and when to begin anew.

use nalgebra::{Matrix2, Matrix3, Vector2};
use rumbo_core::frames::{Pose2, Pose3, Twist, flatten};
use rumbo_core::messages::{Mark, Marks, Odometry, Status};
use rumbo_core::time::Time;
use rumbo_kit::odometry_history::{OdometryHistory, Reading};

use super::belief::{Belief, GATE};
use super::fix::locate;
use super::known_marks::{KnownMark, KnownMarks};
use super::recent::Recent;
use super::sighting::Sighting;
use super::sureness::Sureness;
use crate::deviations::deviations;

/// How the filter works.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// Errors of the odometer over a meter or radian (distance, direction, turn), where they are not what it claims.
    pub odometry_noise: [Option<f64>; 3],
    /// Standard deviations of the odometer's scales: distance and turn.
    pub scale_deviations: [f64; 2],
    /// Standard deviation of ranges where it is not what the sensor claims, meters.
    pub range_deviation_m: Option<f64>,
    /// Part of it that grows with the range, m/m.
    pub range_share: f64,
    /// Standard deviation of bearings where it is not what the sensor claims, radians.
    pub bearing_deviation_rad: Option<f64>,
    /// Marks without identity are taken for the one that they must be.
    pub match_unknown: bool,
    /// When it is sure.
    pub sureness: Sureness,
    /// A way of the odometer beyond this and beyond what the robot can drive is a jump, meters.
    pub jump_m: f64,
    /// The fastest that the robot is: m/s and rad/s.
    pub max_speed: [f64; 2],
}

/// What happened to the sightings of one update.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// They corrected the pose.
    pub n_used: u32,
    /// They do not fit what is expected.
    pub n_refused: u32,
    /// Their identity is not on the map, or not known.
    pub n_unknown: u32,
    /// They came too late or too early for the odometer.
    pub n_untimely: u32,
}

/// A filter that was started.
#[derive(Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    /// None until marks say where the robot is.
    belief: Option<Belief>,
    odometry: OdometryHistory,
    start_odometry: Pose2,
    twist: Twist,
    noise: [f64; 3],
    recent: Recent,
    n_refused_in_row: u32,
    counts: Counts,
}

/// No camera measures better than this, whatever it claims: meters and radians.
const LEAST_DEVIATIONS: [f64; 2] = [0.002, 0.001];
/// Before the first reading the odometer may have moved unseen for this long, seconds.
const BEFORE_FIRST_S: f64 = 1.0;
/// A mark without identity must fit worse to every other one by so much (squared Mahalanobis distance).
const AMBIGUOUS: f64 = 9.0;
/// A fix that is less sure than this is none: meters and radians.
const WORST_FIX: [f64; 2] = [1.0, 0.35];

impl Tracker {
    /// About here, or anywhere.
    pub fn new(
        settings: TrackerSettings,
        at: Option<(Pose2, Matrix3<f64>)>,
        odom_from_base: Pose2,
    ) -> Tracker {
        let belief = at.map(|(pose, covariance)| Belief::at(&pose, &covariance, settings.scale_deviations));
        Tracker {
            settings,
            belief,
            odometry: OdometryHistory::default(),
            start_odometry: odom_from_base,
            twist: Twist::ZERO,
            noise: [0.0; 3],
            recent: Recent::default(),
            n_refused_in_row: 0,
            counts: Counts::default(),
        }
    }

    /// The belief; none while the robot may be anywhere.
    pub fn belief(&self) -> Option<&Belief> {
        self.belief.as_ref()
    }

    /// The newest reading of the odometer, of which the belief is.
    pub fn newest(&self) -> (Option<Time>, Pose2) {
        self.odometry.newest().map_or((None, self.start_odometry), |(stamp, pose)| (Some(stamp), pose))
    }

    /// How sure it is.
    pub fn status(&self) -> Status {
        let sure =
            |belief: &Belief| self.settings.sureness.status(&belief.pose_covariance(), self.n_refused_in_row);
        self.belief.as_ref().map_or(Status::Lost, sure)
    }

    /// What happened to the sightings since the last time.
    pub fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.counts)
    }

    /// A reading of the odometer moves the belief if it is the newest.
    pub fn take_odometry(&mut self, stamp: Time, reading: &Odometry) {
        let (last, old) = self.newest();
        let step = old.inverse() * reading.odom_from_base;
        let is_jump = last.is_none_or(|last| stamp > last) && self.is_jump(last, stamp, &step);
        if is_jump {
            self.jump(last, stamp);
        }
        if self.odometry.push(stamp, reading.odom_from_base) != Reading::Newest {
            return;
        }
        (self.twist, self.noise) = (reading.twist, self.noise_of(reading));
        if let (Some(belief), false) = (&mut self.belief, is_jump) {
            belief.advance(&step, self.noise);
        }
    }

    fn noise_of(&self, reading: &Odometry) -> [f64; 3] {
        let known = self.settings.odometry_noise;
        std::array::from_fn(|k| known[k].unwrap_or(reading.noise[k].abs()))
    }

    fn elapsed_s(last: Option<Time>, stamp: Time) -> f64 {
        last.map_or(BEFORE_FIRST_S, |last| (stamp - last).as_secs())
    }

    fn is_jump(&self, last: Option<Time>, stamp: Time, step: &Pose2) -> bool {
        let reach_m = self.settings.max_speed[0] * Self::elapsed_s(last, stamp);
        let way_m = step.translation.vector.norm();
        !way_m.is_finite() || way_m > self.settings.jump_m + 2.0 * reach_m
    }

    /// The odometer begins anew. The pose stays where it is, but nobody knows what happened meanwhile.
    fn jump(&mut self, last: Option<Time>, stamp: Time) {
        let elapsed_s = Self::elapsed_s(last, stamp);
        let [reach_m, reach_rad] = self.settings.max_speed.map(|most| most * elapsed_s);
        // Before the first reading the prior's pose of the odometer was a guess.
        if let (Some(belief), true) = (&mut self.belief, last.is_some()) {
            belief.widen(reach_m, reach_rad);
        }
        self.odometry.clear();
        self.recent.clear();
    }

    /// Marks that a sensor saw at a time.
    pub fn take_marks(&mut self, stamp: Time, base_from_sensor: &Pose3, seen: &Marks, known: &KnownMarks) {
        let Some(now_from_then) = self.odometry.now_from_then(stamp, &self.twist) else {
            self.counts.n_untimely += seen.marks.len() as u32;
            return;
        };
        let base_from_sensor = now_from_then * flatten(base_from_sensor);
        let (newest, odom_from_base) = self.newest();
        for mark in &seen.marks {
            let sighting = self.sighting(mark, seen, &base_from_sensor);
            if let Some(identity) = mark.identity.filter(|identity| known.get(*identity).is_some()) {
                self.recent.keep(newest.unwrap_or(stamp), identity, &sighting, &odom_from_base);
            }
            self.take_sighting(mark.identity, &sighting, known);
        }
        let is_lost = self.status() == Status::Lost;
        if is_lost {
            self.look_for_fix(&odom_from_base, known);
        }
    }

    fn sighting(&self, mark: &Mark, seen: &Marks, base_from_sensor: &Pose2) -> Sighting {
        let TrackerSettings { range_deviation_m, range_share, bearing_deviation_rad, .. } = &self.settings;
        let range_m = range_deviation_m.unwrap_or(seen.range_deviation_m) + range_share * mark.range_m;
        let bearing_rad = bearing_deviation_rad.unwrap_or(seen.bearing_deviation_rad);
        let deviations = Vector2::new(range_m, bearing_rad).sup(&LEAST_DEVIATIONS.into());
        Sighting {
            measured: Vector2::new(mark.range_m, mark.bearing_rad),
            noise: Matrix2::from_diagonal(&deviations.map(|deviation| deviation * deviation)),
            base_from_sensor: *base_from_sensor,
        }
    }

    fn take_sighting(&mut self, identity: Option<u32>, sighting: &Sighting, known: &KnownMarks) {
        let Some(belief) = &mut self.belief else { return };
        let mark = match identity {
            Some(identity) => known.get(identity).copied(),
            None if self.settings.match_unknown => nearest(belief, sighting, known),
            None => None,
        };
        let Some(mark) = mark else {
            self.counts.n_unknown += 1;
            return;
        };
        if belief.distance(sighting, &mark) <= GATE && belief.correct(sighting, &mark) {
            self.counts.n_used += 1;
            self.n_refused_in_row = 0;
        } else {
            self.counts.n_refused += 1;
            self.n_refused_in_row = self.n_refused_in_row.saturating_add(1);
        }
    }

    /// Begins anew where three marks or more agree.
    fn look_for_fix(&mut self, odom_from_base: &Pose2, known: &KnownMarks) {
        let seen = self.recent.seen_from(odom_from_base, self.noise);
        let known_of = |(identity, sighting)| Some((sighting, *known.get(identity)?));
        let sightings: Vec<(Sighting, KnownMark)> = seen.into_iter().filter_map(known_of).collect();
        let Some(fix) = locate(&sightings) else { return };
        let [position_m, heading_rad] = deviations(&fix.covariance);
        if position_m > WORST_FIX[0] || heading_rad > WORST_FIX[1] {
            return;
        }
        match &mut self.belief {
            Some(belief) => belief.put(&fix.map_from_base, &fix.covariance),
            None => {
                let scales = self.settings.scale_deviations;
                self.belief = Some(Belief::at(&fix.map_from_base, &fix.covariance, scales));
            }
        }
        self.n_refused_in_row = 0;
    }
}

/// The mark that a sighting without identity must be of: within the gate, and no other nearly as near.
fn nearest(belief: &Belief, sighting: &Sighting, known: &KnownMarks) -> Option<KnownMark> {
    let mut distances: Vec<(f64, KnownMark)> =
        known.iter().map(|(_, mark)| (belief.distance(sighting, mark), *mark)).collect();
    distances.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (best, mark) = distances.first().copied()?;
    let is_only = distances.get(1).is_none_or(|(second, _)| *second >= best + AMBIGUOUS);
    (best <= GATE && is_only).then_some(mark)
}
