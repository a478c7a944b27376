//! Follows the robot from scan to scan, and decides when the filter takes one in.

mod estimate;
mod gyro;
mod loops;
mod odometer;
mod steps;
mod trial;

use super::archive::Archive;
use super::closing::Closing;
use super::diary::Diary;
use super::filter::Filter;
use super::follower::Follower;
use super::motion::Step;
use super::proposal::coordinates;
use super::settings::TrackerSettings;
use nalgebra::{Matrix3, Vector3};
use odometer::Odometer;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::messages::{Check, Data, Observation, Seen, StampedPose};
use rumbo_core::time::Time;
use rumbo_kit::scan_match::ScanPoints;
use rumbo_kit::streams::Streams;
use rumbo_kit::turn_way_turn::noisy;
use std::collections::VecDeque;

/// What was left out or went wrong, and how often.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Scans that were used.
    pub scans: u64,
    /// Scans that were late, came twice, or could not be read.
    pub scans_dropped: u64,
    /// Scans that matched nothing.
    pub unmatched: u64,
    /// Scans that do not see every direction.
    pub degenerate: u64,
    /// Scans that the filter took in.
    pub updates: u64,
    /// Times that particles were drawn anew.
    pub resampled: u64,
    /// Times that no particle had any weight.
    pub without_weight: u64,
    /// Loops that were closed by bending the way.
    pub loops: u64,
    /// Readings of the odometer that were late or no numbers.
    pub odometry_dropped: u64,
    /// Readings of the inertial unit that were late or no numbers.
    pub imu_dropped: u64,
    /// Jumps of the odometer.
    pub odometry_jumps: u64,
}

/// A robot that maps where it goes.
#[derive(Debug)]
pub struct Tracker {
    pub(super) settings: TrackerSettings,
    pub(super) filter: Filter,
    pub(super) follower: Follower,
    /// Particles have their maps in a frame in which the robot began, so that no direction of the world is special to cells
    /// and chance.
    pub(super) map_from_start: Pose2,
    pub(super) archive: Archive,
    pub(super) diary: Diary,
    pub(super) odometer: Odometer,
    pub(super) counters: Counters,
    pub(super) is_started: bool,
    /// It goes on from a saved state or was told where it is, and nothing has been seen since.
    pub(super) may_be_another_clock: bool,
    /// The last scan.
    pub(super) stamp: Option<Time>,
    /// When the filter took in a scan last.
    pub(super) step_stamp: Time,
    /// The robot at the last scan, seen from that step, as it was followed.
    pub(super) step_from_base: Pose2,
    /// The same as the odometer has it.
    pub(super) since_step: Step,
    /// Covariance of the last match.
    pub(super) covariance: Matrix3<f64>,
    /// Scans in a row that matched nothing.
    pub(super) n_unmatched: u32,
    /// Way since the last match, meters.
    pub(super) way_unmatched_m: f64,
    /// The way since a lost robot was found, while that is not proven, meters.
    pub(super) proven_m: Option<f64>,
    /// Nobody knew how far the robot went between these steps of the filter and the one before, and it has come to no place since
    /// that it saw earlier.
    pub(super) adrift_since: Option<usize>,
    closing: Closing,
    points: ScanPoints,
    waiting: VecDeque<Observation>,
}

/// Scans that wait for the odometer at most; then the oldest are dropped.
const MOST_WAITING: usize = 50;

impl Tracker {
    /// Not started yet.
    pub fn new(settings: TrackerSettings, streams: Streams) -> Tracker {
        Tracker {
            filter: Filter::new(settings.filter.clone(), streams),
            follower: Follower::new(settings.follow),
            map_from_start: Pose2::identity(),
            archive: Archive::default(),
            diary: Diary::default(),
            odometer: Odometer::new(settings.max_odom_jump_m),
            counters: Counters::default(),
            is_started: false,
            may_be_another_clock: false,
            stamp: None,
            step_stamp: Time::default(),
            step_from_base: Pose2::identity(),
            since_step: Step::default(),
            covariance: Matrix3::zeros(),
            n_unmatched: 0,
            way_unmatched_m: 0.0,
            proven_m: None,
            adrift_since: None,
            closing: Closing::default(),
            points: ScanPoints::default(),
            waiting: VecDeque::new(),
            settings,
        }
    }

    /// Begins anew at a pose.
    pub fn start(&mut self, map_from_base: &Pose2, covariance: &Matrix3<f64>) {
        self.filter.begin(&Pose2::identity());
        self.follower.clear();
        self.map_from_start = *map_from_base;
        (self.archive, self.diary) = (Archive::default(), Diary::default());
        self.odometer = Odometer::new(self.settings.max_odom_jump_m);
        (self.counters, self.is_started, self.stamp) = (Counters::default(), true, None);
        (self.step_stamp, self.step_from_base) = (Time::default(), Pose2::identity());
        (self.since_step, self.covariance) = (Step::default(), *covariance);
        (self.n_unmatched, self.way_unmatched_m, self.proven_m) = (0, 0.0, None);
        self.adrift_since = None;
        self.may_be_another_clock = false;
        self.waiting.clear();
    }

    /// The robot is about there in the map that was made so far, wherever it was before.
    pub fn relocate(&mut self, map_from_base: &Pose2, covariance: &Matrix3<f64>) {
        let turn = Matrix3::from(nalgebra::Rotation3::from_axis_angle(
            &Vector3::z_axis(),
            -self.map_from_start.rotation.angle(),
        ));
        let in_start = turn * covariance * turn.transpose();
        let root = in_start.cholesky().map_or_else(Matrix3::zeros, |factor| factor.l());
        let start_from_base = self.map_from_start.inverse() * map_from_base;
        let at = coordinates(&start_from_base);
        self.filter.place(&start_from_base, |rng| {
            let drawn = at + root * Vector3::from(noisy([0.0; 3], [1.0; 3], rng));
            pose2(drawn.x, drawn.y, drawn.z)
        });
        let deviation = |k: usize| covariance[(k, k)].max(0.0);
        self.follower.clear();
        self.step_from_base = Pose2::identity();
        self.since_step = Step { stray: [deviation(0).max(deviation(1)), deviation(2)], ..Step::default() };
        (self.covariance, self.n_unmatched, self.way_unmatched_m) = (*covariance, 0, 0.0);
        (self.proven_m, self.adrift_since) = (None, None);
        self.odometer.forget();
        self.waiting.clear();
        self.may_be_another_clock = true;
    }

    /// Its numbers.
    pub fn settings(&self) -> &TrackerSettings {
        &self.settings
    }

    /// Where the frame of the particles' maps is in the map that is given out.
    pub fn map_from_start(&self) -> &Pose2 {
        &self.map_from_start
    }

    /// The filter.
    pub fn filter(&self) -> &Filter {
        &self.filter
    }

    /// What went wrong.
    pub fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Whether `start` was called.
    pub fn is_started(&self) -> bool {
        self.is_started
    }

    /// The robot at all scans, as the best particle has it now.
    pub fn trajectory(&self) -> Vec<StampedPose> {
        let way = self.filter.lineage().way_of(self.filter.best_index());
        self.diary.trajectory(
            &way.iter().map(|start_from_base| self.map_from_start * start_from_base).collect::<Vec<_>>(),
        )
    }

    /// Takes in everything that was seen, and says whether the filter took in a scan.
    pub fn update(&mut self, now: Time, seen: Seen<'_>) -> bool {
        let mut is_new = false;
        if let Some(first) = seen.iter().next().filter(|_| self.may_be_another_clock) {
            self.may_be_another_clock = false;
            if self.stamp.is_some_and(|last| first.stamp <= last) {
                self.begin_clock_anew(first.stamp);
            }
        }
        for observation in seen.iter().filter(|observation| observation.valid && observation.stamp <= now) {
            match &observation.data {
                Data::Odometry(odometry) => {
                    self.odometer.take(observation.stamp, odometry, &mut self.counters)
                }
                Data::Imu(imu) => {
                    let is_used =
                        self.odometer.turns.take(observation.stamp, imu, &observation.base_from_sensor);
                    self.counters.imu_dropped += u64::from(!is_used);
                }
                Data::LaserScan(_) => self.queue(observation),
                _ => {}
            }
        }
        while let Some(observation) = self.next_scan(now) {
            if let Data::LaserScan(scan) = &observation.data {
                is_new |= self.take_scan(&observation, scan);
            }
        }
        is_new
    }

    /// The clock is another one, and then the odometer is too. The map stays, and the robot is where it was.
    fn begin_clock_anew(&mut self, now: Time) {
        (self.stamp, self.step_stamp) = (None, now);
        self.diary.begin_clock_anew();
        self.odometer.forget();
    }

    fn queue(&mut self, observation: &Observation) {
        let newest = self.waiting.back().map(|last| last.stamp).or(self.stamp);
        let is_late = newest.is_some_and(|newest| observation.stamp <= newest);
        if is_late || observation.check().is_err() {
            self.counters.scans_dropped += 1;
            return;
        }
        self.waiting.push_back(observation.clone());
        if self.waiting.len() > MOST_WAITING {
            self.waiting.pop_front();
            self.counters.scans_dropped += 1;
        }
    }

    /// The oldest scan for whose time the odometer has spoken, or will not.
    fn next_scan(&mut self, now: Time) -> Option<Observation> {
        let stamp = self.waiting.front()?.stamp;
        if self.odometer.is_ready(stamp, now) { self.waiting.pop_front() } else { None }
    }

    /// Nothing has matched for long.
    pub(super) fn is_lost(&self) -> bool {
        self.n_unmatched >= self.settings.lost_after_scans
    }
}
