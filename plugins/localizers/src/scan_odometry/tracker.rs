//! From scans, gyro and wheels to where the base is.

use super::params::Prediction;
use super::prediction::{Motion, MotionNoise};
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Check, Data, Estimate, LaserScan, Observation, SensorId, Status};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::Time;
use rumbo_kit::scan_odometry::{MatchStatus, ScanOdometer, ScanOdometrySettings, ScanStep};

/// All that can be set.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// The registration.
    pub scan: ScanOdometrySettings,
    /// What a match begins from.
    pub prediction: Prediction,
    /// How far predictions may be off.
    pub noise: MotionNoise,
    /// After so many failed matches in a row the robot is lost.
    pub lost_after_scans: u32,
}

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
    /// Readings whose numbers cannot be.
    pub n_refused: u64,
}

/// A localizer that was started.
#[derive(Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    odometer: ScanOdometer,
    motion: Motion,
    /// What the pipeline's odometry says: what the correction of it is made from, and nothing else.
    odometry: OdometryTrack,
    start_odometry: Pose2,
    scanner: Option<SensorId>,
    /// Stamp of the last scan.
    last_scan: Option<Time>,
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
            motion: Motion::new(settings.prediction, settings.noise),
            settings,
            odometry: OdometryTrack::new(),
            start_odometry: odom_from_base,
            scanner: None,
            last_scan: None,
            n_failed: 0,
            counts: Counts::default(),
            last_step: None,
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
            _ => {}
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
        let (step, covariance) = self
            .last_scan
            .map_or((Pose2::identity(), Matrix3::zeros()), |last| self.motion.step(last, stamp));
        let other = self.last_scan.and_then(|last| self.motion.other_step(last, stamp));
        let other = other.as_ref().map(|(step, covariance)| (step, covariance));
        let mount = &observation.base_from_sensor;
        let taken = self.odometer.take_with(scan, mount, (&step, &covariance), other);
        self.note(&taken, stamp);
        self.last_scan = Some(stamp);
        self.last_step = Some(taken);
    }

    fn note(&mut self, taken: &ScanStep, stamp: Time) {
        self.counts.n_keys += u64::from(taken.is_key);
        // There is nothing that the first scan could match.
        let Some(last) = self.last_scan else { return };
        let status = taken.matched.status;
        self.counts.n_matched += u64::from(status.is_good());
        self.counts.n_degenerate += u64::from(status == MatchStatus::Degenerate);
        self.counts.n_too_few += u64::from(status == MatchStatus::TooFewPoints);
        let is_misfit = matches!(status, MatchStatus::LowOverlap | MatchStatus::Diverged);
        self.counts.n_misfits += u64::from(is_misfit);
        if status.is_good() {
            self.n_failed = 0;
            self.motion.learn(&taken.last_from_base, last, stamp);
        } else {
            self.n_failed = self.n_failed.saturating_add(1);
        }
    }

    /// Where the base is: as of the last scan, carried on by readings that are newer.
    pub fn estimate(&self, now: Time) -> Estimate {
        let (mut map_from_base, mut covariance) =
            (self.odometer.odom_from_base(), self.odometer.covariance());
        let mut stamp = self.last_scan;
        if let (Some(last), Some(newest)) = (self.last_scan, self.motion.newest())
            && newest > last
        {
            let (step, step_covariance) = self.motion.step(last, newest);
            let turned = map_from_base.rotation.to_rotation_matrix().to_homogeneous();
            covariance += turned * step_covariance * turned.transpose();
            map_from_base *= step;
            stamp = Some(newest);
        }
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
