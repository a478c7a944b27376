//! From readings to a pose: what comes when, what the wheels did meanwhile, and who fuses it.

use nalgebra::{Matrix3, Rotation2, Vector2};
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2};
use rumbo_core::messages::{Imu, Odometry, PositionFix, Status};
use rumbo_core::time::{Span, Time};
use rumbo_kit::odometry_history::{OdometryHistory, Reading};

use super::alignment::Alignment;
use super::ekf::{Ekf, EkfSettings};
use super::heading::{Heading, base_yaw_rad};
use super::mean3::Mean3;
use super::params::{Fusion, HeadingSource};
use super::pulled::{Pulled, PulledSettings, Taken};
use super::seen_fix::SeenFix;
use crate::deviations::deviations;

/// How the localizer works.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackerSettings {
    /// How fixes and wheels come together.
    pub fusion: Fusion,
    /// Where the yaw comes from.
    pub heading: HeadingSource,
    /// Bound of the even errors of fixes where it is not what the sensor claims, meters.
    pub error_m: Option<f64>,
    /// For wheels that fixes pull back.
    pub pulled: PulledSettings,
    /// For the Kalman filter.
    pub ekf: EkfSettings,
    /// After so long without one, older fixes are not averaged any more.
    pub outage: Span,
    /// Variance of a measured yaw, rad².
    pub yaw_variance_rad2: f64,
    /// Errors of the odometer over a meter or radian (distance, direction, turn), where they are not what it claims.
    pub odometry_noise: [Option<f64>; 3],
    /// Followed while the position deviates by at most this, meters.
    pub sure_m: f64,
    /// And the heading by at most this, radians.
    pub sure_rad: f64,
    /// A way of the odometer beyond this and beyond what the robot can drive is a jump, meters.
    pub jump_m: f64,
    /// The fastest that the robot is: m/s and rad/s.
    pub max_speed: [f64; 2],
}

/// What happened to the readings of one update.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Fixes that corrected the position.
    pub n_used: u32,
    /// Fixes, and measured yaws, that do not fit what is expected.
    pub n_refused: u32,
    /// Fixes, and measured yaws, from which all began anew.
    pub n_placed: u32,
    /// Readings that came too late or too early for the odometer.
    pub n_untimely: u32,
}

/// A localizer that was started.
#[derive(Debug)]
pub struct Tracker {
    settings: TrackerSettings,
    filter: Filter,
    /// As measured, or as the wheels turned it; the Kalman filter has its own once it has begun.
    heading: Heading,
    odometry: OdometryHistory,
    start_odometry: Pose2,
    twist: Twist,
    noise: [f64; 3],
    /// The newest reading of any kind.
    newest: Option<Time>,
    counts: Counts,
}

#[derive(Debug)]
enum Filter {
    Mean3(Mean3),
    Pulled(Pulled),
    Ekf(Ekf),
    /// The Kalman filter before there is a pose to begin with.
    Before(Alignment),
}

/// Before the first reading the odometer may have moved unseen for this long, seconds.
const BEFORE_FIRST_S: f64 = 1.0;

impl Tracker {
    /// About here, or anywhere.
    pub fn new(
        settings: TrackerSettings,
        at: Option<(Pose2, Matrix3<f64>)>,
        odom_from_base: Pose2,
    ) -> Tracker {
        let start = at
            .map(|(pose, covariance)| (pose.translation.vector, covariance[(0, 0)].max(covariance[(1, 1)])));
        let filter = match (settings.fusion, at) {
            (Fusion::Mean3, _) => Filter::Mean3(Mean3::new(start, settings.max_speed[0], settings.outage)),
            (Fusion::Odometry, _) => Filter::Pulled(Pulled::new(settings.pulled, start)),
            (Fusion::Ekf, Some((pose, covariance))) => Filter::Ekf(Ekf::at(settings.ekf, &pose, &covariance)),
            (Fusion::Ekf, None) => Filter::Before(Alignment::default()),
        };
        let heading = at.map_or(Heading::default(), |(pose, covariance)| {
            Heading::of(pose.rotation.angle(), covariance[(2, 2)])
        });
        Tracker {
            settings,
            filter,
            heading,
            odometry: OdometryHistory::default(),
            start_odometry: odom_from_base,
            twist: Twist::ZERO,
            noise: [0.0; 3],
            newest: None,
            counts: Counts::default(),
        }
    }

    /// The base in the map at a time, and the covariance of x, y, yaw; nothing while nobody knows.
    pub fn pose(&self, now: Time) -> Option<(Pose2, Matrix3<f64>)> {
        let (position_m, variance_m2) = match &self.filter {
            Filter::Ekf(ekf) => return Some((ekf.pose(), ekf.pose_covariance())),
            Filter::Before(_) => return None,
            Filter::Mean3(mean) => mean.position(now)?,
            Filter::Pulled(pulled) => pulled.position()?,
        };
        let (yaw_rad, yaw_variance_rad2) = self.heading.known()?;
        let diagonal = nalgebra::Vector3::new(variance_m2, variance_m2, yaw_variance_rad2);
        Some((pose2(position_m.x, position_m.y, yaw_rad), Matrix3::from_diagonal(&diagonal)))
    }

    /// What the measured yaw is thought to be off by, radians.
    pub fn yaw_bias_rad(&self) -> Option<f64> {
        match &self.filter {
            Filter::Ekf(ekf) => Some(ekf.mean[3]),
            _ => None,
        }
    }

    /// How sure a pose with this covariance is.
    pub fn status(&self, covariance: &Matrix3<f64>) -> Status {
        let [position_m, heading_rad] = deviations(covariance);
        let is_sure = position_m <= self.settings.sure_m && heading_rad <= self.settings.sure_rad;
        if is_sure { Status::Tracking } else { Status::Converging }
    }

    /// The stamp of the newest reading, of the odometer where there is one; and the odometer's pose, which the pose is of.
    pub fn newest(&self) -> (Option<Time>, Pose2) {
        self.odometry.newest().map_or((self.newest, self.start_odometry), |(stamp, pose)| (Some(stamp), pose))
    }

    /// What happened to the readings since the last time.
    pub fn take_counts(&mut self) -> Counts {
        std::mem::take(&mut self.counts)
    }

    /// A reading of the odometer moves the pose if it is the newest.
    pub fn take_odometry(&mut self, stamp: Time, reading: &Odometry) {
        let last = self.odometry.newest().map(|(stamp, _)| stamp);
        let step = self.newest().1.inverse() * reading.odom_from_base;
        let elapsed_s = last.map_or(BEFORE_FIRST_S, |last| (stamp - last).as_secs());
        let is_jump = last.is_none_or(|last| stamp > last) && self.is_jump(elapsed_s, &step);
        if is_jump {
            self.jump(last.is_none(), elapsed_s);
        }
        if self.odometry.push(stamp, reading.odom_from_base) != Reading::Newest {
            self.counts.n_untimely += u32::from(last.is_some_and(|last| stamp < last));
            return;
        }
        self.twist = reading.twist;
        self.noise =
            std::array::from_fn(|k| self.settings.odometry_noise[k].unwrap_or(reading.noise[k].abs()));
        if !is_jump {
            self.advance(last, stamp, &step);
        }
    }

    fn advance(&mut self, last: Option<Time>, stamp: Time, step: &Pose2) {
        match &mut self.filter {
            Filter::Pulled(pulled) => {
                if let Some((yaw_rad, _)) = self.heading.known() {
                    pulled.advance(step, yaw_rad);
                }
            }
            Filter::Ekf(ekf) => {
                ekf.advance(step, self.noise);
                ekf.age(last.map_or(0.0, |last| (stamp - last).as_secs()));
            }
            // The source does not look at the wheels.
            Filter::Mean3(_) | Filter::Before(_) => {}
        }
        self.heading.turn(step, self.noise);
    }

    fn is_jump(&self, elapsed_s: f64, step: &Pose2) -> bool {
        let way_m = step.translation.vector.norm();
        !way_m.is_finite() || way_m > self.settings.jump_m + 2.0 * self.settings.max_speed[0] * elapsed_s
    }

    /// The odometer begins anew. The pose stays where it is, but nobody knows what happened meanwhile; before the first
    /// reading the odometer's pose was a guess.
    fn jump(&mut self, is_first: bool, elapsed_s: f64) {
        let [reach_m, reach_rad] = self.settings.max_speed.map(|most| most * elapsed_s);
        self.odometry.clear();
        if let Filter::Before(alignment) = &mut self.filter {
            alignment.clear();
        }
        if is_first {
            return;
        }
        self.heading.widen(reach_rad);
        match &mut self.filter {
            Filter::Pulled(pulled) => pulled.widen(reach_m),
            Filter::Ekf(ekf) => ekf.widen(reach_m, reach_rad),
            Filter::Mean3(_) | Filter::Before(_) => {}
        }
    }

    /// An attitude of a unit that is mounted like this.
    pub fn take_imu(&mut self, stamp: Time, base_from_sensor: &Pose3, imu: &Imu) {
        let Some(attitude_rad) = imu.attitude_rad.filter(|_| self.settings.heading == HeadingSource::Imu)
        else {
            return;
        };
        let Some(now_from_then) = self.odometry.now_from_then(stamp, &self.twist) else {
            self.counts.n_untimely += 1;
            return;
        };
        let yaw_then_rad = base_yaw_rad(attitude_rad, base_from_sensor);
        let (yaw_rad, variance_rad2) =
            (yaw_then_rad - now_from_then.rotation.angle(), self.settings.yaw_variance_rad2);
        self.heading.set(yaw_rad, variance_rad2);
        if let Filter::Ekf(ekf) = &mut self.filter {
            let taken = ekf.take_yaw(yaw_rad, variance_rad2);
            self.counts.n_refused += u32::from(taken == Taken::Refused);
            self.counts.n_placed += u32::from(taken == Taken::Placed);
        }
        self.note(stamp);
    }

    /// A fix of a receiver that is mounted like this.
    pub fn take_fix(&mut self, stamp: Time, base_from_sensor: &Pose3, fix: &PositionFix) {
        let Some(now_from_then) = self.odometry.now_from_then(stamp, &self.twist) else {
            self.counts.n_untimely += 1;
            return;
        };
        let fix = SeenFix::new(fix, base_from_sensor, &now_from_then, self.settings.error_m);
        let taken = match (&mut self.filter, self.heading.known()) {
            (Filter::Ekf(ekf), _) => ekf.take_fix(&fix),
            (Filter::Before(_), known) => self.begin(&fix, known),
            (_, None) => return,
            (Filter::Pulled(pulled), Some((yaw_rad, _))) => pulled.take_fix(&fix, yaw_rad),
            (Filter::Mean3(mean), Some((yaw_rad, _))) => {
                let lever_m: Vector2<f64> = Rotation2::new(yaw_rad) * fix.lever_then_m;
                mean.take_fix(stamp, fix.antenna_m - lever_m, fix.mean_variance_m2());
                Taken::Used
            }
        };
        match taken {
            Taken::Used => self.counts.n_used += 1,
            Taken::Placed => self.counts.n_placed += 1,
            Taken::Refused => self.counts.n_refused += 1,
        }
        self.note(stamp);
    }

    /// The Kalman filter's first fix: with a measured yaw at once, else when the way between fixes tells the yaw.
    fn begin(&mut self, fix: &SeenFix, known: Option<(f64, f64)>) -> Taken {
        if let Some((yaw_rad, variance_rad2)) = known {
            self.filter = Filter::Ekf(Ekf::at_fix(self.settings.ekf, fix, yaw_rad, variance_rad2));
            return Taken::Placed;
        }
        let odom_from_base = self.newest().1;
        let Filter::Before(alignment) = &mut self.filter else { return Taken::Refused };
        alignment.take_fix(fix, &odom_from_base);
        let sure_rad2 = self.settings.sure_rad.powi(2);
        let found = alignment.pose(&odom_from_base).filter(|(_, covariance)| covariance[(2, 2)] <= sure_rad2);
        if let (HeadingSource::Odometry, Some((pose, covariance))) = (self.settings.heading, found) {
            self.filter = Filter::Ekf(Ekf::at(self.settings.ekf, &pose, &covariance));
        }
        Taken::Used
    }

    /// The newest time of readings.
    fn note(&mut self, stamp: Time) {
        self.newest = Some(self.newest.map_or(stamp, |newest| newest.max(stamp)));
    }
}
