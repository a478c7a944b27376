//! Where the robot really was, as far as somebody wrote it down.

use rumbo_core::frames::{Pose2, flatten, lift};
use rumbo_core::stages::Truth;
use rumbo_core::time::{Span, Time};
use rumbo_kit::log_file::PoseTrack;

/// True poses over the time of the run.
#[derive(Debug, Default)]
pub struct KnownTruth {
    track: PoseTrack,
    /// The poses come with the scans of the log.
    is_inside: bool,
    now: Option<Truth>,
    n_known: u64,
}

impl KnownTruth {
    /// Between poses that are farther apart than this nothing is known.
    pub const GAP: Span = Span(2_000_000_000);
    /// Stamps in files of poses are rounded by as much.
    const ROUNDED: Span = Span(10_000);

    /// Poses whose stamps are absolute, in a log that begins at `origin`.
    pub fn of_file(absolute: &PoseTrack, origin: Time) -> KnownTruth {
        let mut track = PoseTrack::default();
        absolute.iter().for_each(|(stamp, pose)| track.push(Time::ZERO + (stamp - origin), pose));
        KnownTruth { track, ..KnownTruth::default() }
    }

    /// Poses that come with the scans.
    pub fn inside() -> KnownTruth {
        KnownTruth { is_inside: true, ..KnownTruth::default() }
    }

    /// A scan was read ahead.
    pub fn read(&mut self, stamp: Time, map_from_base: Pose2) {
        if self.is_inside {
            self.track.push(stamp, map_from_base);
        }
    }

    /// It is now so late.
    pub fn advance(&mut self, now: Time) {
        let pose = self.track.exact(now, Self::ROUNDED).or_else(|| self.track.between(now, Self::GAP));
        self.n_known += u64::from(pose.is_some());
        self.now = pose.map(|pose| Truth {
            map_from_base: lift(&pose),
            twist: self.track.twist(now),
            clearance_m: f64::INFINITY,
            contact_episodes: None,
            driven_contact_episodes: None,
        });
        if self.is_inside {
            self.track.forget_before(now - Self::GAP);
        }
    }

    /// What is known of now.
    pub fn now(&self) -> Option<&Truth> {
        self.now.as_ref()
    }

    /// The first pose and its time.
    pub fn first(&self) -> Option<(Time, Pose2)> {
        self.track.first()
    }

    /// The pose of now, or the first one if that is about now.
    pub fn pose_about(&self, now: Time) -> Option<Pose2> {
        let known = self.now().map(|truth| flatten(&truth.map_from_base));
        let first = || self.first().filter(|(time, _)| (*time - now).0.abs() <= Self::GAP.0);
        known.or_else(|| first().map(|(_, pose)| pose))
    }

    /// Poses are there, but none fitted so far.
    pub fn is_useless(&self) -> bool {
        !self.track.is_empty() && self.n_known == 0
    }
}
