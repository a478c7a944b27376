//! Where a scan was taken, as recorded poses have it.

use rumbo_core::frames::Pose2;
use rumbo_core::time::{Span, Time};
use rumbo_kit::log_file::PoseTrack;

/// Recorded poses over the time of the run.
#[derive(Debug, Clone, Default)]
pub struct Follower {
    track: PoseTrack,
    only_exact: bool,
    gap: Span,
}

/// What the record says of one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Place {
    /// The robot was here.
    At(Pose2),
    /// The robot was between two poses, and only scans at poses are wanted.
    OnTheWay,
    /// Before the first pose, or in a gap.
    Unknown,
    /// The record is over.
    Over,
}

impl Follower {
    /// Stamps of poses and scans are the same numbers, rounded to 10 µs in some files.
    pub const SAME: Span = Span(100_000);

    /// Poses with absolute stamps, in a run that begins at `origin`.
    pub fn new(absolute: &PoseTrack, origin: Time, only_exact: bool, gap: Span) -> Follower {
        let mut track = PoseTrack::default();
        absolute.iter().for_each(|(stamp, pose)| track.push(Time::ZERO + (stamp - origin), pose));
        Follower { track, only_exact, gap }
    }

    /// Where the robot was at this time of the run.
    pub fn place(&self, stamp: Time) -> Place {
        if let Some(pose) = self.track.exact(stamp, Self::SAME) {
            return Place::At(pose);
        }
        match self.track.between(stamp, self.gap) {
            Some(_) if self.only_exact => Place::OnTheWay,
            Some(pose) => Place::At(pose),
            None if self.track.last().is_none_or(|(last, _)| stamp > last) => Place::Over,
            None => Place::Unknown,
        }
    }
}
