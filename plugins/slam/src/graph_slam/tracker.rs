//! One scan after the other: the robot's place, key frames, loops.

use super::atlas::{Atlas, KeyFrame, TieSettings};
use super::contradiction::{View, denied_share};
use super::front_end::{FrontEnd, Prediction, SURE_FIT};
use super::gyro::{Gyro, Heading};
use super::loops::{Look, LoopSearch, LoopSettings, frames_of, thinned};
use super::surface::{SurfaceLimits, surface_of};
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
    /// Scans with fewer points say nothing.
    pub min_points: usize,
    /// Key frames from one optimization to the next, at least; and the share of all key frames.
    pub optimize_every: usize,
    pub optimize_share: f64,
    /// Key frames from one look for loops to the next.
    pub look_for_loops_every: usize,
    /// Scans that fit nowhere before the robot is lost.
    pub lost_after_scans: u32,
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

/// What was before the scan that comes now.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Before {
    pub stamp: Time,
    pub odom_from_base: Option<Pose2>,
    pub heading: Option<Heading>,
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
    /// It has come here nobody knows how, and no scan has clearly fitted since.
    pub is_doubtful: bool,
    /// When a scan last had enough points.
    pub saw_at: Option<Time>,
    pub before: Option<Before>,
    pub frame_from_base: Pose2,
    /// The odometer at the newest key frame.
    pub odom_from_frame: Option<Pose2>,
    pub covariance: Matrix3<f64>,
    pub first_pose: Pose2,
    pub fit: Fit,
    pub n_missed: u32,
    pub since_optimized: usize,
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
/// A robot whose scans fit no better than this for some time is somewhere else.
const POOR_FIT: f64 = 0.6;
/// Nor is one that meets things where the key frame before saw free space, or the other way round: share of what both see.
const MOST_DENIED: f64 = 0.1;
/// A robot that has doubted its place is sure again where no more than this contradicts it.
const SURELY_DENIED: f64 = 0.05;
/// Nor is a place that was searched for in the whole map taken where more does: corners of buildings are alike.
const HARDLY_DENIED: f64 = 0.03;
/// Narrower views are not judged so: what a depth camera sees of low things changes with how far away they are, and a
/// robot that waited for a good fit would have turned away from all that it could be registered on.
const NARROW_RAD: f64 = std::f64::consts::FRAC_PI_2;
/// So many scans in a row may fit badly before it takes a good one to be sure again.
const MISSED_BY_CHANCE: u32 = 2;
/// Lost robots look for themselves every so many scans ...
const LOOK_EVERY: u32 = 10;
/// ... this often; then the pause doubles with each look in vain ...
const PATIENT_LOOKS: u32 = 8;
/// ... up to so many times as long.
const LONGEST_PAUSE: u32 = 32;

fn is_narrow(view: &View<'_>) -> bool {
    view.scan.bearing_step_rad.abs() * (view.scan.ranges_m.len() as f64) < NARROW_RAD
}

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
            is_doubtful: false,
            saw_at: None,
            before: None,
            frame_from_base: first_pose,
            odom_from_frame: None,
            covariance: Matrix3::identity() * 1e-6,
            first_pose,
            fit: Fit::Guessed,
            n_missed: 0,
            since_optimized: 0,
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

    fn map_from_frame(&self) -> Pose2 {
        self.atlas.graph.pose(self.front.frame).unwrap_or_else(Pose2::identity)
    }

    /// Takes in a scan.
    pub fn take(&mut self, stamp: Time, scan: &LaserScan, base_from_sensor: &Pose3) {
        if self.before.is_some_and(|before| stamp <= before.stamp) {
            self.left_out.late += 1;
            return;
        }
        self.settled.take();
        let surface = surface_of(scan, base_from_sensor, &self.settings.limits);
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
        if may_add && has_points && self.is_key_frame() {
            let frame = KeyFrame {
                scan: scan.clone(),
                base_from_sensor: *base_from_sensor,
                surface,
                is_guessed: self.fit == Fit::Guessed,
            };
            self.add_key_frame(frame);
        }
        self.go_on();
        if self.fit != Fit::Lost {
            self.tracks.push(Track { stamp, frame: self.front.frame, frame_from_base: self.frame_from_base });
        }
    }

    fn place(&mut self, view: &View<'_>, prediction: &Prediction) {
        let surface = view.surface;
        if self.atlas.frames.is_empty() {
            self.fit = if surface.len() < self.settings.min_points { Fit::Guessed } else { Fit::Placed };
            return;
        }
        if surface.len() < self.settings.min_points {
            self.left_out.too_few_points += 1;
            self.guess(prediction);
            return;
        }
        // A lost robot would take the next best corridor for the one that it remembers.
        let is_lost = self.fit == Fit::Lost;
        // Nor is what was seen before a long way without scans any help.
        self.is_adrift |= prediction.is_far;
        self.is_doubtful |= prediction.is_blind;
        let found = if is_lost || prediction.is_far {
            None
        } else {
            self.front.place(&self.atlas, surface, prediction)
        };
        if let Some(found) = found {
            self.frame_from_base = found.reference_from_scan;
            let information = found.information * self.settings.tie.believed_share;
            let [off_m, off_rad] = prediction.deviation;
            let known = nalgebra::Vector3::new(off_m.powi(-2), off_m.powi(-2), off_rad.powi(-2));
            let inverse = (information + Matrix3::from_diagonal(&known)).try_inverse();
            self.covariance = inverse.unwrap_or(self.covariance);
            // A robot that was carried away must not settle where it fits least badly.
            let (least_fit, most_denied) = if is_narrow(view) {
                (0.0, 1.0)
            } else if self.is_doubtful || self.n_missed > MISSED_BY_CHANCE {
                (SURE_FIT, SURELY_DENIED)
            } else {
                (POOR_FIT, MOST_DENIED)
            };
            let denied_share = self.denied_share(view);
            // A doubt was none when nothing is denied any more.
            let is_fine = !self.is_doubtful && found.fit() >= POOR_FIT && denied_share <= HARDLY_DENIED;
            if is_fine || found.fit() >= least_fit && denied_share <= most_denied {
                self.fit = Fit::Placed;
                (self.n_missed, self.is_doubtful) = (0, false);
                return;
            }
            self.fit = Fit::Guessed;
        } else {
            self.left_out.unplaced += 1;
            self.guess(prediction);
        }
        self.n_missed += 1;
        if self.n_missed >= self.settings.lost_after_scans {
            self.fit = Fit::Lost;
            if self.looks_now() {
                self.look_anywhere(view);
            }
        }
    }

    /// How much of the scan contradicts the key frame that the robot is seen from.
    fn denied_share(&self, view: &View<'_>) -> f64 {
        let Some(frame) = self.atlas.frames.get(self.front.frame) else { return 0.0 };
        denied_share(&frame.view(), view, &self.frame_from_base)
    }

    fn guess(&mut self, prediction: &Prediction) {
        let [off_m, off_rad] = prediction.deviation;
        let more = nalgebra::Vector3::new(off_m.powi(2), off_m.powi(2), off_rad.powi(2));
        self.covariance += Matrix3::from_diagonal(&more);
        if self.fit == Fit::Placed {
            self.fit = Fit::Guessed;
        }
    }

    /// Looks in vain make the pause longer: what did not fit anywhere will hardly fit soon.
    fn looks_now(&self) -> bool {
        let lost_for = self.n_missed.saturating_sub(self.settings.lost_after_scans);
        let pauses = lost_for / LOOK_EVERY;
        lost_for.is_multiple_of(LOOK_EVERY)
            && (pauses < PATIENT_LOOKS || pauses.is_power_of_two() || pauses.is_multiple_of(LONGEST_PAUSE))
    }

    /// A lost robot looks for its place in the whole map.
    fn look_anywhere(&mut self, view: &View<'_>) {
        let points = thinned(view.surface.iter().copied());
        let Some(found) = self.search.anywhere(&self.atlas, &points, &self.settings.loops) else { return };
        let (frame, frame_from_base) = (self.front.frame, self.frame_from_base);
        let frames = self.front.frames().to_vec();
        self.stand(found.place, found.place_from_frame, &found.frames);
        if !self.is_sure_of(view) {
            self.stand(frame, frame_from_base, &frames);
            return;
        }
        (self.fit, self.n_missed, self.is_adrift) = (Fit::Placed, 0, false);
        self.is_doubtful = false;
    }

    /// The scan fits where the robot was put, and contradicts nothing: what is alike in parts is not enough.
    fn is_sure_of(&mut self, view: &View<'_>) -> bool {
        let here = Prediction::around(self.frame_from_base);
        let Some(found) = self.front.place(&self.atlas, view.surface, &here) else { return false };
        self.frame_from_base = found.reference_from_scan;
        found.fit() >= SURE_FIT && self.denied_share(view) <= HARDLY_DENIED
    }

    /// The robot is here, as seen from a key frame; how it came here says nothing.
    pub fn stand(&mut self, frame: usize, frame_from_base: Pose2, frames: &[usize]) {
        self.front.look_from(&self.atlas, frame, frames);
        self.frame_from_base = frame_from_base;
        self.odom_from_frame = None;
    }

    fn remember(&mut self, stamp: Time, last: &Pose2) {
        let (odom_from_base, heading) = (self.odom_at(stamp), self.heading_at(stamp));
        let seconds = self.before.map_or(0.0, |before| (stamp - before.stamp).as_secs());
        let motion =
            if self.before.is_some() { last.inverse() * self.frame_from_base } else { Pose2::identity() };
        self.before = Some(Before { stamp, odom_from_base, heading, motion, seconds });
    }

    /// Somebody put the robot here; its odometer and its clock may have begun anew.
    pub fn carry_to(&mut self, map_from_base: &Pose2, covariance: &Matrix3<f64>) {
        self.forget_motion();
        self.covariance = *covariance;
        (self.fit, self.n_missed, self.is_adrift) = (Fit::Guessed, 0, false);
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
    }

    /// Nobody knows where the robot is; it looks for itself at the next scan.
    pub fn lose(&mut self) {
        self.forget_motion();
        self.fit = Fit::Lost;
        self.n_missed = self.settings.lost_after_scans - 1;
    }

    fn forget_motion(&mut self) {
        self.before = None;
        self.odom_from_frame = None;
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
