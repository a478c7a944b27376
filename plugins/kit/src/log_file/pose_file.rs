//! Files of poses: lines of `t x y theta` (seconds, meters, radians), or a log that has poses in it.

use std::path::Path;

use rumbo_core::time::Time;

use super::beam_rule::BeamOverride;
use super::error::{Damage, FaultKind, LineFault, LogError};
use super::lines::{LONGEST_LINE, Line, Lines};
use super::pose_track::PoseTrack;
use super::tally::Tally;
use super::timeline::{MomentData, Timeline};
use super::words::Words;

/// Poses from a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RecordedPoses {
    /// The poses at their absolute stamps.
    pub track: PoseTrack,
    /// What could not be read.
    pub tally: Tally,
}

/// Reads a file of `t x y theta` lines (what follows on a line is passed over), or the poses inside a log: those of
/// `VERTEX2` lines, else the first pose of each laser message.
///
/// # Errors
/// [`LogError`] for a file that is missing, a folder, empty, or has no pose in it.
pub fn read_poses(path: &Path) -> Result<RecordedPoses, LogError> {
    match Timeline::open(path, BeamOverride::default()) {
        Ok(mut timeline) => {
            let mut track = PoseTrack::default();
            while let Some(moment) = timeline.next() {
                if let MomentData::Scan(scan) = moment.data {
                    track.push(scan.stamp, scan.map_from_base);
                    timeline.recycle(scan.ranges_m);
                }
            }
            let tally = timeline.tally().clone();
            some_poses(path, RecordedPoses { track, tally })
        }
        Err(LogError::NoRecords { .. }) => some_poses(path, read_lines(path)?),
        Err(error) => Err(error),
    }
}

fn some_poses(path: &Path, poses: RecordedPoses) -> Result<RecordedPoses, LogError> {
    if !poses.track.is_empty() {
        return Ok(poses);
    }
    let found = match poses.tally.sentences().into_iter().next() {
        Some(sentence) => format!("no pose ({sentence})"),
        None => "no pose".to_owned(),
    };
    let expected = "lines of `t x y theta`, or a log with laser messages";
    Err(LogError::NoRecords { path: path.to_owned(), found, expected })
}

fn read_lines(path: &Path) -> Result<RecordedPoses, LogError> {
    let mut lines = Lines::open(path)?;
    let mut poses = RecordedPoses::default();
    loop {
        let line = lines.next();
        match line {
            Line::Whole | Line::Unfinished => {
                let is_blank = lines.bytes.trim_ascii().is_empty() || lines.bytes.starts_with(b"#");
                if is_blank {
                    continue;
                }
                match pose(Words::new(lines.number, &lines.bytes)) {
                    // A cut through the last number of a line goes unseen; so the line without an end is not trusted.
                    _ if line == Line::Unfinished => {
                        let found = "the last line has no end".to_owned();
                        let damage = Damage { line: lines.number, is_truncated: true, found };
                        poses.tally.damage = Some(damage);
                    }
                    Ok((stamp, map_from_base)) => poses.track.push(stamp, map_from_base),
                    Err(fault) => poses.tally.count(&fault),
                }
            }
            Line::TooLong => poses.tally.count(&LineFault {
                line: lines.number,
                kind: FaultKind::LineTooLong,
                field: "pose".to_owned(),
                found: format!("longer than {LONGEST_LINE} bytes"),
                expected: "t x y theta".to_owned(),
            }),
            Line::Damaged(damage) => {
                poses.tally.damage = Some(damage);
                break;
            }
            Line::End => break,
        }
    }
    Ok(poses)
}

fn pose(words: Words<'_>) -> Result<(Time, rumbo_core::frames::Pose2), LineFault> {
    let mut words = words.of("pose");
    Ok((words.stamp("t")?, words.pose(["x", "y", "theta"], 1.0)?))
}
