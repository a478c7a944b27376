//! One scan after the other: the robot's place, key frames, loops.

use super::atlas::{Atlas, KeyFrame, TieSettings};
use super::contradiction::View;
use super::front_end::FrontEnd;
use super::loops::{Look, LoopSearch, LoopSettings, frames_of};
use super::surface::{Surface, SurfaceLimits};
use crate::gyro::{Gyro, Heading};
use crate::rbpf_slam::archive::turned_into;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, Pose3, lift};
use rumbo_core::messages::{LaserScan, StampedPose};
use rumbo_core::time::Time;
use rumbo_kit::odometry_history::OdometryHistory;
use std::cell::OnceCell;

/// How the robot is followed and its map kept.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TrackerSettings {
    pub limits: SurfaceLimits,
    pub tie: TieSettings,
    pub loops: LoopSettings,
    /// A scan becomes a key frame when the robot has gone so far since the last one, meters, or turned so far, radians.
    pub key_frame_every: [f64; 2],
    /// Key frames that a scan is registered on.
    pub n_recent: usize,
    /// After so many visits a place gets no more key frames.
    pub most_visits: usize,
    /// Scans with fewer points say nothing.
    pub min_points: usize,
    /// Key frames from one optimization to the next, at least; and the share of all key frames.
    pub optimize_every: usize,
    pub optimize_share: f64,
    /// Key frames from one look for loops to the next.
    pub look_for_loops_every: usize,
    /// Scans that fit nowhere before the robot is lost.
    pub lost_after_scans: u32,
    /// Somebody may ask where the robot was.
    pub keeps_tracks: bool,
    /// Rounds of registering all neighbors again, for the trajectory.
    pub refine_rounds: usize,
}

/// How a scan came to its place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fit {
    /// It fits.
    Placed,
    /// Dead reckoning.
    Guessed,
    /// Nobody knows.
    Lost,
}

/// A scan as seen from a key frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Track {
    pub stamp: Time,
    pub frame: usize,
    pub frame_from_base: Pose2,
}

/// What odometer and gyroscope said at some time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Reckoned {
    pub stamp: Time,
    pub odom_from_base: Option<Pose2>,
    pub heading: Option<Heading>,
}

impl Reckoned {
    /// The turn since then by the gyroscope, radians.
    pub fn turn_since(&self, then: &Reckoned) -> Option<f64> {
        self.heading?.since(&then.heading?)
    }
}

/// What was before the scan that comes now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Before {
    pub reckoned: Reckoned,
    /// Motion from the scan before that, for robots without an odometer.
    pub motion: Pose2,
    pub seconds: f64,
}

/// Scans that are left out, and why.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct LeftOut {
    pub late: u32,
    pub too_few_points: u32,
    pub unplaced: u32,
}

/// The robot among its key frames.
#[derive(Debug)]
pub(super) struct Tracker {
    pub settings: TrackerSettings,
    pub atlas: Atlas,
    pub front: FrontEnd,
    pub search: LoopSearch,
    pub odometry: OdometryHistory,
    pub gyro: Gyro,
    /// It has come here without scans, and has met nothing since that it knew before.
    pub is_adrift: bool,
    /// Nobody knew the way that scans did not show before this key frame was taken, and it has met nothing since that is older.
    pub unsure_since: Option<usize>,
    /// It has come here nobody knows how, and no scan has clearly fitted since.
    pub is_doubtful: bool,
    /// When a scan last had enough points.
    pub saw_at: Option<Time>,
    pub before: Option<Before>,
    pub frame_from_base: Pose2,
    /// At the newest key frame.
    pub frame_reckoned: Option<Reckoned>,
    /// In the axes of the key frame.
    pub covariance: Matrix3<f64>,
    pub first_pose: Pose2,
    pub fit: Fit,
    pub n_missed: u32,
    pub since_optimized: usize,
    /// Frames in a row whose ties are far off.
    pub n_strained: usize,
    /// A search for a loop that is not over yet.
    pub look: Option<Look>,
    /// Frames that are to be tied to neighbors after a loop: the first, and the one after the last.
    pub catch_up: [usize; 2],
    pub tracks: Vec<Track>,
    pub left_out: LeftOut,
    pub n_loops: usize,
    /// Goes up whenever key frames have moved.
    pub n_moves: u64,
    /// The key frames after everything was registered once more, since somebody asked.
    settled: OnceCell<Atlas>,
}

/// After so long without a scan the odometer is all there is, seconds.
pub(super) const BLIND_AFTER_S: f64 = 1.0;
impl Tracker {
    pub fn new(settings: TrackerSettings, first_pose: Pose2) -> Tracker {
        Tracker {
            settings,
            atlas: Atlas::new(settings.tie),
            front: FrontEnd::default(),
            search: LoopSearch::default(),
            odometry: OdometryHistory::default(),
            gyro: Gyro::default(),
            is_adrift: false,
            unsure_since: None,
            is_doubtful: false,
            saw_at: None,
            before: None,
            frame_from_base: first_pose,
            frame_reckoned: None,
            covariance: Matrix3::identity() * 1e-6,
            first_pose,
            fit: Fit::Guessed,
            n_missed: 0,
            since_optimized: 0,
            n_strained: 0,
            look: None,
            catch_up: [0; 2],
            tracks: Vec::new(),
            left_out: LeftOut::default(),
            n_loops: 0,
            n_moves: 0,
            settled: OnceCell::new(),
        }
    }

    /// The robot at the last scan.
    pub fn map_from_base(&self) -> Pose2 {
        self.map_from_frame() * self.frame_from_base
    }

    pub(super) fn map_from_frame(&self) -> Pose2 {
        self.atlas.graph.pose(self.front.frame).unwrap_or_else(Pose2::identity)
    }

    /// Takes in a scan.
    pub fn take(&mut self, stamp: Time, scan: &LaserScan, base_from_sensor: &Pose3) {
        if self.before.is_some_and(|before| stamp <= before.reckoned.stamp) {
            self.left_out.late += 1;
            return;
        }
        self.settled.take();
        let surface = Surface::of(scan, base_from_sensor, &self.settings.limits);
        let prediction = self.predict(stamp);
        let last = self.frame_from_base;
        self.frame_from_base = prediction.frame_from_base;
        let view = View { scan, base_from_sensor, surface: &surface };
        self.place(&view, &prediction);
        self.remember(stamp, &last);
        let has_points = surface.len() >= self.settings.min_points;
        let was_blind = self.saw_at.is_none_or(|seen| (stamp - seen).as_secs() > BLIND_AFTER_S);
        if has_points {
            self.saw_at = Some(stamp);
        }
        // Where a scan suddenly fits nowhere, the robot may have been carried away: no place for a key frame.
        let may_add = self.fit == Fit::Placed || self.fit == Fit::Guessed && was_blind && !self.is_doubtful;
        let is_due = may_add && has_points && self.is_key_frame();
        let is_known = is_due && self.fit == Fit::Placed && {
            self.meets_known(&view) || !self.is_adrift && self.goes_on_from_known(&view)
        };
        if is_due && !is_known {
            let frame = KeyFrame {
                scan: scan.clone(),
                base_from_sensor: *base_from_sensor,
                surface,
                is_guessed: self.fit == Fit::Guessed,
            };
            self.add_key_frame(frame);
        }
        self.go_on();
        if self.fit != Fit::Lost && self.settings.keeps_tracks {
            self.tracks.push(Track { stamp, frame: self.front.frame, frame_from_base: self.frame_from_base });
        }
    }

    /// The robot is here, as seen from a key frame; how it came here says nothing.
    pub fn stand(&mut self, frame: usize, frame_from_base: Pose2, frames: &[usize]) {
        let new_from_old = self.atlas.pose(frame).inverse() * self.map_from_frame();
        self.covariance = turned_into(&new_from_old.inverse(), &self.covariance);
        self.front.look_from(&self.atlas, frame, frames);
        self.frame_from_base = frame_from_base;
        self.frame_reckoned = None;
    }

    fn remember(&mut self, stamp: Time, last: &Pose2) {
        let reckoned = self.reckoned_at(stamp);
        let seconds = self.before.map_or(0.0, |before| (stamp - before.reckoned.stamp).as_secs());
        let motion =
            if self.before.is_some() { last.inverse() * self.frame_from_base } else { Pose2::identity() };
        self.before = Some(Before { reckoned, motion, seconds });
    }

    /// Somebody put the robot here; its odometer and its clock may have begun anew.
    pub fn carry_to(&mut self, map_from_base: &Pose2, covariance: &Matrix3<f64>) {
        self.forget_motion();
        self.covariance = *covariance;
        (self.fit, self.n_missed) = (Fit::Guessed, 0);
        self.is_placed_again();
        self.is_doubtful = false;
        let off_m = |frame: &usize| {
            let off = self.atlas.pose(*frame).translation.vector - map_from_base.translation.vector;
            (off.norm() * 1e6) as u64
        };
        let Some(nearest) = (0..self.atlas.frames.len()).min_by_key(off_m) else {
            self.first_pose = *map_from_base;
            return;
        };
        let frames = frames_of(&self.atlas, nearest);
        self.stand(nearest, self.atlas.pose(nearest).inverse() * map_from_base, &frames);
        self.covariance = turned_into(&self.atlas.pose(nearest), covariance);
    }

    /// It is where it was seen before, or somebody says where.
    pub(super) fn is_placed_again(&mut self) {
        (self.is_adrift, self.unsure_since) = (false, None);
    }

    /// Nobody knows where the robot is; it looks for itself at the next scan.
    pub fn lose(&mut self) {
        self.forget_motion();
        self.fit = Fit::Lost;
        self.n_missed = self.settings.lost_after_scans - 1;
    }

    fn forget_motion(&mut self) {
        self.before = None;
        self.frame_reckoned = None;
        self.odometry.clear();
        self.gyro.begin_anew();
        self.saw_at = None;
    }

    /// The key frames after everything was registered once more: what trajectory and map are told from.
    pub fn settled(&self) -> &Atlas {
        self.settled.get_or_init(|| {
            let mut atlas = self.atlas.clone();
            atlas.optimize(10);
            atlas.refine(self.settings.refine_rounds);
            atlas
        })
    }

    /// Where the robot was at all scans.
    pub fn trajectory(&self) -> Vec<StampedPose> {
        let atlas = self.settled();
        let mut poses: Vec<StampedPose> = Vec::with_capacity(self.tracks.len());
        for track in &self.tracks {
            if poses.last().is_some_and(|last| last.stamp >= track.stamp) {
                continue;
            }
            let map_from_base = atlas.pose(track.frame) * track.frame_from_base;
            poses.push(StampedPose { stamp: track.stamp, map_from_base: lift(&map_from_base) });
        }
        poses
    }
}
