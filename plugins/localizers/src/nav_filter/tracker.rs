//! From inertial readings, scans and, where asked for, wheels to where the base is.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use rumbo_core::frames::{Pose2, Pose3, lift};
use rumbo_core::messages::{Check, Data, Estimate, Imu, LaserScan, Observation, Odometry, SensorId, Status};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::{Span, Time};
use rumbo_kit::nav_filter::{
    Fusion, ImuSample, NavCounts, NavFault, NavFilter, NavOutput, NavSettings, NavStatus, PlanarPose,
};
use rumbo_kit::scan_odometry::{MatchStatus, ScanOdometer, ScanOdometrySettings, ScanStep};

use super::standstill::Standstill;
use super::unseen::{UsualSpeed, forget_unseen};

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
    /// Standard deviation of the attitude by which tilted scans were leveled, radians.
    pub leveled_within_rad: f64,
    /// Scans that are less sure than this in a direction do not see it, meters; absent where the match alone says so.
    pub seen_within_m: Option<f64>,
    /// How fast the robot drives where scans do not see the way, if that is known.
    pub usual_speed: Option<UsualSpeed>,
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
    /// Scans that did not see the way.
    pub n_unseen: u64,
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
    /// When the device last spoke, and what rates it said, as the base turned, rad/s.
    last_rates: Option<(Time, Vector3<f64>)>,
    last_scan: Option<Time>,
    /// Where the filter was for the key scan, and where the scans say that the last one was seen from there.
    odom_from_key: Pose2,
    key_from_scanned: Pose2,
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
            last_rates: None,
            last_scan: None,
            odom_from_key: start.0,
            key_from_scanned: Pose2::identity(),
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
                let (stamp, mount) = (observation.stamp, &observation.base_from_sensor);
                let sample = sample_of(stamp, imu, mount, self.last_rates);
                if self.filter.take_imu(stamp, &sample) {
                    self.last_rates = Some((stamp, sample.rates_rad_s));
                }
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
            self.odom_from_key = self.filter.odom_from_anchor();
            return;
        };
        let prior = predicted.unwrap_or_else(|| self.unknown_step(stamp - since));
        // Seen from the key scan, the filter and the scans need not have been at the same place for the last one.
        let key_from_anchor = self.odom_from_key.inverse() * self.filter.odom_from_anchor();
        let step = self.key_from_scanned.inverse() * key_from_anchor * prior.pose;
        let taken = self.scans.take(scan, mount, &step, &prior.covariance);
        self.note(&taken, stamp);
        let mut is_unseen = taken.matched.status != MatchStatus::Ok;
        let step = taken.matched.status.is_good().then(|| {
            let mut step = measured(&taken, &key_from_anchor);
            step.covariance += leveling_covariance(scan, mount, self.settings.leveled_within_rad);
            let within_m = self.settings.seen_within_m;
            is_unseen |= within_m.is_some_and(|within_m| forget_unseen(&mut step.covariance, within_m));
            step
        });
        if predicted.is_some() {
            let fusion = match taken.matched.status {
                MatchStatus::Ok => Fusion::Alone,
                _ => Fusion::Intersected,
            };
            self.filter.take_step(stamp, step.as_ref().map(|step| (step, fusion)));
        } else {
            self.counts.n_alone += 1;
            self.filter.carry_on(step.as_ref().unwrap_or(&prior));
        }
        if is_unseen {
            self.counts.n_unseen += 1;
            self.take_usual_speed(stamp, stamp - since);
        }
        self.key_from_scanned = taken.matched.key_from_base;
        if taken.is_key {
            self.odom_from_key = self.filter.odom_from_anchor();
            self.key_from_scanned = Pose2::identity();
        }
    }

    /// Nobody saw the way: the robot probably drives as fast as it usually does.
    fn take_usual_speed(&mut self, stamp: Time, since_last: Span) {
        if let Some(usual) = self.settings.usual_speed {
            let (velocity, covariance) = usual.velocity(since_last.as_secs());
            self.filter.take_velocity(stamp, &velocity, &covariance);
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

/// A reading as the base feels it: what a device beside the base's middle feels of the base's turning is taken off. How the
/// rates change is known by the reading before; what that errs by, the next one takes back.
fn sample_of(
    stamp: Time,
    imu: &Imu,
    base_from_imu: &Pose3,
    before: Option<(Time, Vector3<f64>)>,
) -> ImuSample {
    let rates_rad_s = base_from_imu.rotation * Vector3::from(imu.rates_rad_s);
    let felt = base_from_imu.rotation * Vector3::from(imu.accelerations_m_s2);
    // A device that feels nothing at all has no accelerometer, wherever it sits.
    if felt == Vector3::zeros() {
        return ImuSample { rates_rad_s, forces_m_s2: felt };
    }
    let arm_m = base_from_imu.translation.vector;
    let change_rad_s2 = before
        .filter(|(last, _)| stamp > *last && stamp - *last <= LONGEST_CHANGE)
        .map_or(Vector3::zeros(), |(last, rates)| (rates_rad_s - rates) / (stamp - last).as_secs());
    let by_turning = rates_rad_s.cross(&rates_rad_s.cross(&arm_m)) + change_rad_s2.cross(&arm_m);
    ImuSample { rates_rad_s, forces_m_s2: felt - by_turning }
}

/// Readings farther apart say nothing about how the rates change.
const LONGEST_CHANGE: Span = Span(100_000_000);

/// What a scan of a tilted laser errs by, beyond what its points show, because its attitude does: its points move along the
/// floor by as much as they lie higher or lower than the laser, and all of them the same way as it rises over the base.
fn leveling_covariance(scan: &LaserScan, base_from_sensor: &Pose3, std_rad: f64) -> Matrix3<f64> {
    let up = base_from_sensor.rotation * Vector3::z();
    let sine = up.xy().norm();
    // A device that looks level needed no attitude.
    if sine < 1e-9 {
        return Matrix3::zeros();
    }
    let (sum_m, n) = scan
        .ranges_m
        .iter()
        .filter(|range_m| range_m.is_finite())
        .fold((0.0, 0.0), |(sum_m, n), range_m| (sum_m + f64::from(*range_m), n + 1.0));
    let reach_m = if n > 0.0 { sum_m / n } else { 0.0 };
    let place_m = (reach_m * sine).hypot(base_from_sensor.translation.z) * std_rad;
    Matrix3::from_diagonal(&Vector3::new(place_m, place_m, sine * std_rad).map(|std| std * std))
}

/// The step from where the filter was for the last scan to where this one was made, in the axes of the former: what the
/// filter did not believe of the steps before is not lost.
fn measured(taken: &ScanStep, key_from_anchor: &Pose2) -> PlanarPose {
    let anchor_from_key = key_from_anchor.inverse();
    let turn = anchor_from_key.rotation.to_rotation_matrix().to_homogeneous();
    let covariance = turn * taken.matched.covariance * turn.transpose();
    PlanarPose { pose: anchor_from_key * taken.matched.key_from_base, covariance }
}
