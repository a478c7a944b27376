//! From scans, gyro and wheels to where the base is.

use super::drift::{Agility, Drift};
use super::params::Prediction;
use super::prediction::{Guess, Motion};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_core::messages::{Check, Data, DepthImage, Estimate, LaserScan, Observation, SensorId, Status};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::Time;
use rumbo_kit::scan_odometry::{
    MatchStatus, PosePrior, ScanOdometer, ScanOdometrySettings, ScanPoints, ScanStep, SlicePitch,
};

/// All that can be set.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// The registration.
    pub scan: ScanOdometrySettings,
    /// What a match begins from.
    pub prediction: Prediction,
    /// A velocity is carried on for at most so long after the last match, seconds.
    pub carry_on_s: f64,
    /// How far a gyro may be off, rad/s.
    pub gyro_rad_s: f64,
    /// How velocities change.
    pub agility: Agility,
    /// The middle of depth pictures tells how the body pitches.
    pub has_slice: bool,
    /// After so many failed matches in a row the robot is lost.
    pub lost_after_scans: u32,
}

/// On a body that pitches, what a scanner sees lower than this is the floor, meters.
const FLOOR_M: f64 = 0.05;

/// What happened to the readings since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Scans that said where the base is.
    pub n_matched: u64,
    /// Those of them that left a direction to the prediction.
    pub n_degenerate: u64,
    /// Scans with too few points.
    pub n_too_few: u64,
    /// Scans that fitted nothing.
    pub n_misfits: u64,
    /// Scans that became key scans.
    pub n_keys: u64,
    /// Scans that were not newer than the last.
    pub n_late: u64,
    /// Scans of other scanners.
    pub n_other: u64,
    /// Depth pictures that said how the body pitches.
    pub n_pitched: u64,
    /// Readings whose numbers cannot be.
    pub n_refused: u64,
}

/// A localizer that was started.
#[derive(Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    odometer: ScanOdometer,
    motion: Motion,
    drift: Drift,
    /// What the pipeline's odometry says: what the correction of it is made from, and nothing else.
    odometry: OdometryTrack,
    start_odometry: Pose2,
    scanner: Option<SensorId>,
    /// How the body pitches, where that is asked for, and the camera that says so.
    pitch: Option<SlicePitch>,
    camera: Option<SensorId>,
    /// Stamp of the last scan.
    last_scan: Option<Time>,
    /// Stamp of the last one that matched.
    last_match: Option<Time>,
    n_failed: u32,
    counts: Counts,
    last_step: Option<ScanStep>,
}

impl Tracker {
    /// At a pose.
    pub fn new(
        settings: TrackerSettings,
        map_from_base: Pose2,
        covariance: Matrix3<f64>,
        odom_from_base: Pose2,
    ) -> Tracker {
        Tracker {
            odometer: ScanOdometer::new(settings.scan, map_from_base, covariance),
            motion: Motion::new(settings.prediction, settings.carry_on_s, settings.gyro_rad_s),
            drift: Drift::new(settings.agility, &covariance),
            odometry: OdometryTrack::new(),
            start_odometry: odom_from_base,
            scanner: None,
            pitch: settings.has_slice.then(SlicePitch::default),
            camera: None,
            last_scan: None,
            last_match: None,
            n_failed: 0,
            counts: Counts::default(),
            last_step: None,
            settings,
        }
    }

    /// What happened to the readings since the start.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The last match.
    pub fn last_step(&self) -> Option<&ScanStep> {
        self.last_step.as_ref()
    }

    /// Takes in one reading; one that cannot be is left out and counted.
    pub fn take(&mut self, observation: &Observation) {
        if observation.check().is_err() {
            self.counts.n_refused += 1;
            return;
        }
        let stamp = observation.stamp;
        match &observation.data {
            Data::Imu(imu) => {
                self.motion.take_imu(stamp, &observation.base_from_sensor, imu);
            }
            Data::Odometry(odometry) => {
                self.motion.take_wheels(stamp, odometry);
                self.odometry.push(stamp, odometry);
            }
            Data::LaserScan(scan) => self.take_scan(observation, scan),
            Data::DepthImage(image) => self.take_picture(observation, image),
            _ => {}
        }
    }

    fn take_picture(&mut self, observation: &Observation, image: &DepthImage) {
        let Some(pitch) = &mut self.pitch else { return };
        if *self.camera.get_or_insert(observation.sensor) == observation.sensor {
            let is_said = pitch.take(observation.stamp, image, &observation.base_from_sensor);
            self.counts.n_pitched += u64::from(is_said);
        }
    }

    fn take_scan(&mut self, observation: &Observation, scan: &LaserScan) {
        if *self.scanner.get_or_insert(observation.sensor) != observation.sensor {
            self.counts.n_other += 1;
            return;
        }
        let stamp = observation.stamp;
        if self.last_scan.is_some_and(|last| stamp <= last) {
            self.counts.n_late += 1;
            return;
        }
        let (mount, lowest_m) = match &self.pitch {
            Some(pitch) => (pitch.level_from_base(stamp) * observation.base_from_sensor, FLOOR_M),
            None => (observation.base_from_sensor, f64::NEG_INFINITY),
        };
        let place = |points: &mut ScanPoints| points.place_above(scan, &mount, lowest_m);
        let taken = match self.last_scan {
            Some(last) => self.follow(place, last, stamp),
            None => self.odometer.take_placed(place, &Pose2::identity(), &Matrix3::zeros()),
        };
        self.note(&taken, stamp);
        self.last_scan = Some(stamp);
        self.last_step = Some(taken);
    }

    /// Predicts, looks, corrects.
    fn follow(&mut self, place: impl FnOnce(&mut ScanPoints), last: Time, stamp: Time) -> ScanStep {
        let (twist, age) = (self.drift.twist(), self.last_match.map(|matched| last - matched));
        let guess = self.motion.guess(last, stamp, twist, age);
        let other = self.motion.other_guess(last, stamp, twist, age);
        let seconds = (stamp - last).as_secs();
        let predict = |guess: &Guess| {
            let key_from_base = self.odometer.key_from_base();
            let drift = self.drift.predicted(&key_from_base, guess, seconds);
            let prior =
                PosePrior { key_from_base: key_from_base * guess.step, covariance: drift.base_covariance() };
            (drift, prior, guess.is_by_velocity)
        };
        let (first, other) = (predict(&guess), other.as_ref().map(predict));
        let (matched, is_other) = self.odometer.look(place, &first.1, other.as_ref().map(|other| &other.1));
        let (mut drift, prior, is_by_velocity) = other.filter(|_| is_other).unwrap_or(first);
        let mut key_from_base = prior.key_from_base;
        let mut odom_from_key = self.odometer.odom_from_key();
        if matched.status.is_good() && !is_by_velocity {
            key_from_base = matched.key_from_base;
            drift.adopt(&matched.covariance);
        } else if matched.status.is_good() {
            let mut beside = numbers(&matched.key_from_base) - numbers(&prior.key_from_base);
            beside.z = wrap_angle(beside.z);
            let correction = drift.take(&beside, &matched.information);
            key_from_base = moved(&key_from_base, &correction.base);
            odom_from_key = moved(&odom_from_key, &correction.key);
        }
        self.drift = drift;
        self.odometer.shift_key(odom_from_key);
        let covariance = self.drift.base_covariance();
        let taken = self.odometer.settle(&matched, &key_from_base, &covariance);
        if !is_by_velocity && matched.status == MatchStatus::Ok {
            self.drift.learn(&taken.last_from_base, &prior.covariance, seconds);
        }
        if taken.is_key {
            self.drift.begin_key(&odom_from_key, &key_from_base);
        }
        taken
    }

    fn note(&mut self, taken: &ScanStep, stamp: Time) {
        self.counts.n_keys += u64::from(taken.is_key);
        // There is nothing that the first scan could match.
        if self.last_scan.is_none() {
            return;
        }
        let status = taken.matched.status;
        self.counts.n_matched += u64::from(status.is_good());
        self.counts.n_degenerate += u64::from(status == MatchStatus::Degenerate);
        self.counts.n_too_few += u64::from(status == MatchStatus::TooFewPoints);
        let is_misfit = matches!(status, MatchStatus::LowOverlap | MatchStatus::Diverged);
        self.counts.n_misfits += u64::from(is_misfit);
        if status.is_good() {
            self.n_failed = 0;
            self.last_match = Some(stamp);
        } else {
            self.n_failed = self.n_failed.saturating_add(1);
        }
    }

    /// Where the base is: as of the last scan, carried on by readings that are newer.
    pub fn estimate(&self, now: Time) -> Estimate {
        let (odom_from_key, mut key_from_base) =
            (self.odometer.odom_from_key(), self.odometer.key_from_base());
        let (mut drift, mut stamp) = (self.drift, self.last_scan);
        if let (Some(last), Some(newest)) = (self.last_scan, self.motion.newest())
            && newest > last
        {
            let age = self.last_match.map(|matched| last - matched);
            let guess = self.motion.guess(last, newest, drift.twist(), age);
            drift = drift.predicted(&key_from_base, &guess, (newest - last).as_secs());
            key_from_base *= guess.step;
            stamp = Some(newest);
        }
        let map_from_base = odom_from_key * key_from_base;
        let covariance = drift.covariance(&odom_from_key, &key_from_base);
        let stamp = stamp.unwrap_or(now).min(now);
        let odom_from_base = self.odometry.stamp().map_or(self.start_odometry, |_| self.odometry.at(stamp));
        let mut estimate = Estimate::planar(stamp, map_from_base, odom_from_base, covariance);
        estimate.status = match self.n_failed {
            0 => Status::Tracking,
            n if n < self.settings.lost_after_scans => Status::Converging,
            _ => Status::Lost,
        };
        estimate
    }
}

/// x, y, yaw of a pose.
fn numbers(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}

/// A pose with a correction in its own frame's axes.
fn moved(pose: &Pose2, by: &Vector3<f64>) -> Pose2 {
    let at = numbers(pose) + by;
    pose2(at.x, at.y, at.z)
}
