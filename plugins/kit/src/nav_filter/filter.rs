//! The filter: inertial samples in, poses out, planar poses whenever somebody has one.

use nalgebra::{Matrix2, Matrix3, UnitQuaternion, Vector2};
use rumbo_core::frames::Pose2;
use rumbo_core::time::Time;

use super::aids::{AidKind, floor_velocity, is_gravity, leveled_angles};
use super::fusion::{Anchored, Fusion, anchor, fuse, planar, planar_rows, reckoned, take_alone};
use super::history::History;
use super::intersection::PlanarPose;
use super::leveling::is_reading;
use super::model::{
    ACCEL_BIAS, ATTITUDE, AnchorCross, Covariance, GYRO_BIAS, ImuSample, NavState, POSITION, VELOCITY,
};
use super::moment::{Moment, Tally};
use super::settings::{NavFault, NavSettings};
use crate::compounded::by_parts;

/// Least variance that is kept: below it a covariance counts as none.
pub(super) const LEAST: f64 = 1e-10;
/// Standard deviation of the velocity of a robot that begins anyhow, m/s.
pub(super) const START_M_S: f64 = 0.5;
/// What became of all that came in, since the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NavCounts {
    /// Samples that were used.
    pub n_samples: u64,
    /// Samples that are no readings.
    pub n_bad: u64,
    /// Samples that are not newer than the last one.
    pub n_not_newer: u64,
    /// Gaps that were too long to integrate over.
    pub n_gaps: u64,
    /// Measurements that are older than all that is kept, or younger than the samples.
    pub n_untimely: u64,
    /// Measurements that are too far from what is expected, or no numbers.
    pub n_rejected: u64,
    /// Measurements after which the covariance was none.
    pub n_not_positive: u64,
}
/// The filter.
#[derive(Debug, Clone)]
pub struct NavFilter {
    pub(super) settings: NavSettings,
    pub(super) history: History,
    /// The state's frame: where the robot was at the last step that was measured over the floor.
    pub(super) odom_from_anchor: Pose2,
    /// Its covariance, in the axes of the odometer.
    pub(super) anchor_covariance: Matrix3<f64>,
    pub(super) dead_reckoned: Pose2,
    pub(super) counts: NavCounts,
}

impl NavFilter {
    /// A filter that begins with its first sample.
    ///
    /// # Errors
    /// The first setting that cannot be.
    pub fn new(settings: NavSettings) -> Result<NavFilter, NavFault> {
        if let Some(fault) = settings.faults().into_iter().next() {
            return Err(fault);
        }
        Ok(NavFilter {
            settings,
            history: History::default(),
            odom_from_anchor: Pose2::identity(),
            anchor_covariance: Matrix3::zeros(),
            dead_reckoned: Pose2::identity(),
            counts: NavCounts::default(),
        })
    }

    /// The same robot somewhere else: place, yaw and their covariance are these from now on; attitude and biases stay.
    pub fn place(&mut self, odom_from_base: Pose2, covariance: Matrix3<f64>) {
        if let Some(now) = self.history.now() {
            let mut moment = now.clone();
            anchor(&mut moment);
            moment.by_anchor = AnchorCross::zeros();
            self.history.begin(moment);
        }
        (self.odom_from_anchor, self.anchor_covariance) = (odom_from_base, covariance);
        self.dead_reckoned = odom_from_base;
    }

    /// Takes in a sample of the body. False where it was not used.
    pub fn take_imu(&mut self, stamp: Time, sample: &ImuSample) -> bool {
        if !is_reading(sample, &self.settings) {
            self.counts.n_bad += 1;
            return false;
        }
        let Some(now) = self.history.now() else {
            self.history.begin(self.first(stamp, sample));
            self.counts.n_samples += 1;
            return true;
        };
        if stamp <= now.stamp {
            self.counts.n_not_newer += 1;
            return false;
        }
        let mut tally = Tally::default();
        let next = now.next(stamp, sample, &self.settings, &mut tally);
        let is_gap = stamp - now.stamp > self.settings.max_gap;
        if !is_gap {
            self.dead_reckoned = reckoned(&self.dead_reckoned, &now.state, &next, now.stamp);
        }
        self.history.push(next, self.settings.history);
        self.counts.n_samples += 1;
        self.counts.n_gaps += u64::from(is_gap);
        self.add(tally);
        true
    }

    fn add(&mut self, tally: Tally) {
        self.counts.n_rejected += tally.n_rejected;
        self.counts.n_not_positive += tally.n_not_positive;
    }

    /// Level as the forces say, whatever they are: nothing else is known.
    fn first(&self, stamp: Time, sample: &ImuSample) -> Moment {
        let [roll_rad, pitch_rad] = leveled_angles(&sample.forces_m_s2);
        let nav_from_body = UnitQuaternion::from_euler_angles(roll_rad, pitch_rad, 0.0);
        let state = NavState { nav_from_body, ..NavState::default() };
        let settings = &self.settings;
        let tilt_rad =
            if is_gravity(&sample.forces_m_s2, settings) { settings.leveling_std_rad } else { 0.5 };
        let mut covariance = Covariance::zeros();
        for k in 0..3 {
            covariance[(ATTITUDE + k, ATTITUDE + k)] = tilt_rad.powi(2);
            covariance[(POSITION + k, POSITION + k)] = LEAST;
            covariance[(VELOCITY + k, VELOCITY + k)] = START_M_S.powi(2);
            covariance[(GYRO_BIAS + k, GYRO_BIAS + k)] = settings.gyro_bias_rad_s.powi(2).max(LEAST);
            covariance[(ACCEL_BIAS + k, ACCEL_BIAS + k)] = settings.accel_bias_m_s2.powi(2).max(LEAST);
        }
        let (sample, last_aid) = (*sample, Some(stamp));
        let mut moment = Moment {
            stamp,
            sample,
            state,
            covariance,
            by_anchor: AnchorCross::zeros(),
            is_standing: false,
            last_aid,
            n_refused: [0; AidKind::COUNT],
            wrong_since: None,
            lean2: 0.0,
        };
        // The frame begins with the robot's own yaw, which is therefore certain.
        anchor(&mut moment);
        moment
    }

    /// The robot stands, or moves again, from the newest sample on.
    pub fn set_standing(&mut self, is_standing: bool) {
        if let Some(now) = self.history.now_mut() {
            now.is_standing = is_standing;
        }
    }

    /// The planar pose at a time, seen from where the last step ended, as far as samples and other measurements tell.
    pub fn predicted_step(&self, stamp: Time) -> Option<PlanarPose> {
        let (_, moment) = self.history.at(stamp, &self.settings)?;
        let c = planar_rows(&moment.state);
        Some(PlanarPose { pose: planar(&moment.state), covariance: c * moment.covariance * c.transpose() })
    }

    /// Takes in how the robot moved over the floor from the last step to `stamp`, as scans tell it; the next step begins
    /// there. Without a measurement it only begins there. Returns whether it was used.
    pub fn take_step(&mut self, stamp: Time, step: Option<(&PlanarPose, Fusion)>) -> bool {
        let Some((place, mut moment)) = self.history.at(stamp, &self.settings) else {
            self.counts.n_untimely += 1;
            return false;
        };
        let mut tally = Tally::default();
        let is_used = step.is_some_and(|(step, fusion)| match fusion {
            Fusion::Intersected => fuse(&mut moment, step, &self.settings, &mut tally),
            Fusion::Alone => take_alone(&mut moment, step, &mut tally),
        });
        let anchored = anchor(&mut moment);
        let (by_anchor, by_step) = self.begin_at(&anchored);
        moment.by_anchor = by_anchor * moment.by_anchor + by_step * anchored.with_state;
        self.history.revise(place, moment, &self.settings);
        // What is older is seen from where the step before ended.
        self.history.forget_before(place);
        self.add(tally);
        is_used
    }

    /// Scans alone say how the robot moved since the last step: there are no samples of that time. Attitude and velocity stay
    /// as they were, and what comes next is a gap.
    pub fn carry_on(&mut self, step: &PlanarPose) {
        let (pose, covariance) = (step.pose, step.covariance);
        let alone =
            Anchored { pose, covariance, with_anchor: Matrix3::zeros(), with_state: AnchorCross::zeros() };
        let (by_anchor, _) = self.begin_at(&alone);
        if let Some(now) = self.history.now() {
            let mut moment = now.clone();
            anchor(&mut moment);
            moment.by_anchor = by_anchor * moment.by_anchor;
            self.history.begin(moment);
        }
        self.dead_reckoned *= step.pose;
    }

    /// Where the last step ended.
    pub fn odom_from_anchor(&self) -> Pose2 {
        self.odom_from_anchor
    }

    /// The anchor is there now, seen from where it was. Returns how errors of the old one and
    /// of the step move it.
    fn begin_at(&mut self, to: &Anchored) -> (Matrix3<f64>, Matrix3<f64>) {
        let (by_anchor, by_step) = by_parts(&self.odom_from_anchor, &to.pose);
        let common = by_anchor * to.with_anchor * by_step.transpose();
        let apart = by_anchor * self.anchor_covariance * by_anchor.transpose()
            + by_step * to.covariance * by_step.transpose();
        let sum = apart + common + common.transpose();
        self.anchor_covariance = (sum + sum.transpose()) * 0.5;
        self.odom_from_anchor *= to.pose;
        (by_anchor, by_step)
    }

    /// Takes in a planar pose of that time, in the frame of the output, by covariance intersection. Returns whether it was
    /// used.
    pub fn take_pose(&mut self, stamp: Time, pose: &PlanarPose) -> bool {
        let anchor_from_odom = self.odom_from_anchor.inverse();
        let turn = anchor_from_odom.rotation.to_rotation_matrix().to_homogeneous();
        let seen = PlanarPose {
            pose: anchor_from_odom * pose.pose,
            covariance: turn * pose.covariance * turn.transpose(),
        };
        self.revise(stamp, |moment, settings, tally| fuse(moment, &seen, settings, tally))
    }

    /// Takes in the velocity over the floor (forward, left) at that time. Returns whether it was used.
    pub fn take_velocity(&mut self, stamp: Time, floor_m_s: &Vector2<f64>, r: &Matrix2<f64>) -> bool {
        if !floor_m_s.iter().chain(r.iter()).all(|v| v.is_finite()) {
            self.counts.n_rejected += 1;
            return false;
        }
        self.revise(stamp, |moment, settings, tally| {
            let aid = floor_velocity(&moment.state, floor_m_s, r);
            moment.update(AidKind::Velocity, &aid, settings, tally)
        })
    }

    fn revise(
        &mut self,
        stamp: Time,
        change: impl FnOnce(&mut Moment, &NavSettings, &mut Tally) -> bool,
    ) -> bool {
        let Some((place, mut moment)) = self.history.at(stamp, &self.settings) else {
            self.counts.n_untimely += 1;
            return false;
        };
        let mut tally = Tally::default();
        let is_used = change(&mut moment, &self.settings, &mut tally);
        self.history.revise(place, moment, &self.settings);
        self.add(tally);
        is_used
    }
}
