//! From inertial readings, scans and, where asked for, wheels to where the base is.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use rumbo_core::frames::{Pose2, Pose3, lift};
use rumbo_core::messages::{Check, Data, Estimate, Imu, LaserScan, Observation, Odometry, SensorId, Status};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::{Span, Time};
use rumbo_kit::nav_filter::{
    ImuSample, NavCounts, NavFault, NavFilter, NavOutput, NavSettings, NavStatus, PlanarPose,
};
use rumbo_kit::scan_odometry::{MatchStatus, ScanOdometer, ScanOdometrySettings, ScanStep};

use super::standstill::Standstill;

/// All that can be set.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// The filter.
    pub filter: NavSettings,
    /// The registration of scans.
    pub scan: ScanOdometrySettings,
    /// Standard deviation of the wheels' velocity where they are looked at, m/s.
    pub wheels_m_s: Option<f64>,
    /// Without a match for so long the robot is not followed any more, only reckoned.
    pub followed_for: Span,
    /// Without a match and without samples for so long it is lost.
    pub lost_after: Span,
    /// How far a scan without samples may be from the last one: m/s and rad/s.
    pub fastest: [f64; 2],
}

/// What happened to the readings since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Scans that said how the base moved.
    pub n_matched: u64,
    /// Those of them that left a direction to the filter.
    pub n_degenerate: u64,
    /// Scans that said nothing.
    pub n_unmatched: u64,
    /// Scans of a time without samples.
    pub n_alone: u64,
    /// Scans that were not newer than the last.
    pub n_late: u64,
    /// Readings whose numbers cannot be.
    pub n_refused: u64,
}

/// A localizer that was started.
#[derive(Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    filter: NavFilter,
    scans: ScanOdometer,
    standstill: Standstill,
    odometry: OdometryTrack,
    start: (Pose2, Matrix3<f64>),
    start_odometry: Pose2,
    scanner: Option<SensorId>,
    imu: Option<SensorId>,
    last_scan: Option<Time>,
    last_match: Option<Time>,
    counts: Counts,
}

impl Tracker {
    /// At a pose.
    ///
    /// # Errors
    /// The first setting of the filter that cannot be.
    pub fn new(
        settings: TrackerSettings,
        start: (Pose2, Matrix3<f64>),
        start_odometry: Pose2,
    ) -> Result<Tracker, NavFault> {
        let mut filter = NavFilter::new(settings.filter.clone())?;
        filter.place(start.0, start.1);
        Ok(Tracker {
            filter,
            scans: ScanOdometer::new(settings.scan, start.0, start.1),
            settings,
            standstill: Standstill::default(),
            odometry: OdometryTrack::new(),
            start,
            start_odometry,
            scanner: None,
            imu: None,
            last_scan: None,
            last_match: None,
            counts: Counts::default(),
        })
    }

    /// What happened to the readings since the start.
    pub fn counts(&self) -> (Counts, NavCounts) {
        (self.counts, self.filter.counts())
    }

    /// Takes in one reading; one that cannot be is left out and counted.
    pub fn take(&mut self, observation: &Observation) {
        if observation.check().is_err() {
            self.counts.n_refused += 1;
            return;
        }
        match &observation.data {
            Data::Imu(imu) if *self.imu.get_or_insert(observation.sensor) == observation.sensor => {
                let sample = sample_of(imu, &observation.base_from_sensor);
                self.filter.take_imu(observation.stamp, &sample);
            }
            Data::Odometry(odometry) => self.take_wheels(observation.stamp, odometry),
            Data::LaserScan(scan)
                if *self.scanner.get_or_insert(observation.sensor) == observation.sensor =>
            {
                self.take_scan(observation, scan);
            }
            _ => {}
        }
    }

    fn take_wheels(&mut self, stamp: Time, odometry: &Odometry) {
        self.odometry.push(stamp, odometry);
        if let Some(deviation_m_s) = self.settings.wheels_m_s {
            let velocity = Vector2::new(odometry.twist.forward_m_s, odometry.twist.left_m_s);
            self.filter.take_velocity(stamp, &velocity, &(Matrix2::identity() * deviation_m_s.powi(2)));
        }
    }

    fn take_scan(&mut self, observation: &Observation, scan: &LaserScan) {
        let (stamp, mount) = (observation.stamp, &observation.base_from_sensor);
        if self.last_scan.is_some_and(|last| stamp <= last) {
            self.counts.n_late += 1;
            return;
        }
        let since = self.last_scan.replace(stamp);
        let predicted = self.filter.predicted_step(stamp);
        let Some(since) = since else {
            self.scans.take(scan, mount, &Pose2::identity(), &Matrix3::zeros());
            self.last_match = Some(stamp);
            // Steps count from here.
            self.filter.take_step(stamp, None);
            return;
        };
        let prior = predicted.unwrap_or_else(|| self.unknown_step(stamp - since));
        let taken = self.scans.take(scan, mount, &prior.pose, &prior.covariance);
        self.note(&taken, stamp);
        let step = taken.matched.status.is_good().then(|| measured(&taken));
        if predicted.is_some() {
            self.filter.take_step(stamp, step.as_ref());
        } else {
            self.counts.n_alone += 1;
            self.filter.carry_on(step.as_ref().unwrap_or(&prior));
        }
    }

    /// Between two scans without a sample the robot may have moved as fast as it can, nobody knows where to.
    fn unknown_step(&self, gap: Span) -> PlanarPose {
        let [speed_m_s, turn_rad_s] = self.settings.fastest.map(|fastest| fastest * gap.as_secs());
        let deviations = Vector3::new(speed_m_s, speed_m_s, turn_rad_s);
        let covariance = Matrix3::from_diagonal(&deviations.map(|v| v * v + 1e-8));
        PlanarPose { pose: Pose2::identity(), covariance }
    }

    fn note(&mut self, taken: &ScanStep, stamp: Time) {
        let status = taken.matched.status;
        self.counts.n_degenerate += u64::from(status == MatchStatus::Degenerate);
        if status.is_good() {
            self.counts.n_matched += 1;
            self.last_match = Some(stamp);
        } else {
            self.counts.n_unmatched += 1;
        }
        // Along a corridor scans do not say that the robot stands.
        let stands = status == MatchStatus::Ok && self.standstill.see(stamp, &self.scans.odom_from_base());
        if status != MatchStatus::Ok {
            self.standstill.forget();
        }
        self.filter.set_standing(stands);
    }

    /// Where the base is, as of the newest reading.
    pub fn estimate(&self, now: Time) -> Estimate {
        let output = self.filter.output(now);
        let known = output.as_ref().map(|output| output.stamp).max(self.last_scan);
        let stamp = known.unwrap_or(now).min(now);
        let odom_from_base = self.odometry.stamp().map_or(self.start_odometry, |_| self.odometry.at(stamp));
        let Some(output) = output else {
            let (pose, covariance) = self.start;
            let mut estimate = Estimate::planar(stamp, pose, odom_from_base, covariance);
            estimate.status = Status::Converging;
            return estimate;
        };
        let NavOutput { odom_from_base: map_from_base, covariance, .. } = output;
        Estimate {
            stamp,
            map_from_odom: map_from_base * lift(&odom_from_base).inverse(),
            map_from_base,
            covariance,
            status: self.status(now),
            candidates: Vec::new(),
            wish: None,
        }
    }

    fn status(&self, now: Time) -> Status {
        let since_match = self.last_match.map(|last| now - last);
        let is_stale = self.filter.status(now) != NavStatus::Ok;
        match since_match {
            Some(since) if since <= self.settings.followed_for => Status::Tracking,
            Some(since) if is_stale && since > self.settings.lost_after => Status::Lost,
            None if self.settings.wheels_m_s.is_some() && !is_stale => Status::Tracking,
            _ => Status::Converging,
        }
    }
}

/// A reading as the base feels it. Of the forces at a device beside the base's middle, the centrifugal ones are taken off.
fn sample_of(imu: &Imu, base_from_imu: &Pose3) -> ImuSample {
    let rates_rad_s = base_from_imu.rotation * Vector3::from(imu.rates_rad_s);
    let centripetal = rates_rad_s.cross(&rates_rad_s.cross(&base_from_imu.translation.vector));
    let felt = base_from_imu.rotation * Vector3::from(imu.accelerations_m_s2);
    // A device that feels nothing at all has no accelerometer, wherever it sits.
    let forces_m_s2 = if felt == Vector3::zeros() { felt } else { felt - centripetal };
    ImuSample { rates_rad_s, forces_m_s2 }
}

/// The step since the last scan, with the covariance of the match in the axes of where the base was then.
fn measured(taken: &ScanStep) -> PlanarPose {
    let key_from_last = taken.matched.key_from_base * taken.last_from_base.inverse();
    let turn = key_from_last.rotation.inverse().to_rotation_matrix().to_homogeneous();
    let covariance = turn * taken.matched.covariance * turn.transpose();
    PlanarPose { pose: taken.last_from_base, covariance }
}
