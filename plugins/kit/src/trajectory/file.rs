//! Trajectories from files, plain or gzip.

use std::path::Path;

use rumbo_core::frames::lift;
use rumbo_core::time::Time;

use super::pose_line::{pose_line, stamp_line};
use super::table::{Row, Table};
use super::{StampedPose, Trajectory, TrajectoryError, TrajectoryFormat};
use crate::log_file::{BeamOverride, MomentData, Timeline};

/// A trajectory and what is worth knowing of its file.
#[derive(Debug, Clone, PartialEq)]
pub struct TrajectoryFile {
    /// The poses.
    pub trajectory: Trajectory,
    /// How the file was understood.
    pub format: TrajectoryFormat,
    /// False where a stamp is no more than the number of the pose (from 0) taken as seconds.
    pub has_stamps: bool,
    /// A sentence for each thing that people should know, without the name of the file.
    pub notes: Vec<String>,
}

/// Reads a trajectory; without `format` it is told from the first line that is no comment. `times` is for KITTI files: a
/// file with one stamp for each pose.
///
/// Poses that are not finite are left out and poses out of order are sorted in; both are noted.
///
/// # Errors
/// [`TrajectoryError`] for a file that is missing, a folder, empty or of another kind, for a line that cannot be read,
/// and for stamps that do not belong to the poses.
pub fn read_trajectory(
    path: &Path,
    format: Option<TrajectoryFormat>,
    times: Option<&Path>,
) -> Result<TrajectoryFile, TrajectoryError> {
    let format = match format {
        Some(format) => format,
        None => recognized(path)?,
    };
    let (poses, has_stamps, mut notes) = match format {
        TrajectoryFormat::Log | TrajectoryFormat::Odometry => from_log(path, format)?,
        _ => from_lines(path, format, times)?,
    };
    let n = poses.len();
    let (trajectory, repairs) = Trajectory::of(poses);
    if repairs.n_out_of_order > 0 {
        let steps = repairs.n_out_of_order;
        notes.push(format!("the stamps step backwards in {steps} places; the poses were sorted"));
    }
    if repairs.n_repeated > 0 {
        let repeated = repairs.n_repeated;
        notes.push(format!("{repeated} of {n} poses have the stamp of another one; the first of each stays"));
    }
    if trajectory.poses().is_empty() {
        let reasons = if notes.is_empty() { String::new() } else { format!(" ({})", notes.join("; ")) };
        return Err(TrajectoryError::Empty {
            path: path.to_owned(),
            found: format!("no pose{reasons}"),
            expected: format!("lines of `{}`", format.pattern()),
        });
    }
    Ok(TrajectoryFile { trajectory, format, has_stamps, notes })
}

/// The format of the first line that says something.
fn recognized(path: &Path) -> Result<TrajectoryFormat, TrajectoryError> {
    const EXPECTED: &str = "a trajectory (TUM, KITTI or `t x y theta`) or a robot log";
    let mut table = Table::open(path, EXPECTED)?;
    match table.next() {
        Some(Row { line, words, .. }) => TrajectoryFormat::of_line(words).ok_or_else(|| {
            let n_words = words.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count();
            TrajectoryError::UnknownFormat { path: path.to_owned(), line, n_words }
        }),
        None => Err(TrajectoryError::Empty {
            path: path.to_owned(),
            found: table.why_empty(),
            expected: EXPECTED.to_owned(),
        }),
    }
}

type Found = (Vec<StampedPose>, bool, Vec<String>);

/// The words of a log's readers about its lines are kept as notes: real logs are damaged.
fn from_log(path: &Path, format: TrajectoryFormat) -> Result<Found, TrajectoryError> {
    let timeline = Timeline::open(path, BeamOverride::default());
    let mut timeline =
        timeline.map_err(|error| TrajectoryError::of_lines(error, "a robot log with poses in it"))?;
    let (mut of_scans, mut of_odometry) = (Vec::new(), Vec::new());
    let is_odometry = format == TrajectoryFormat::Odometry;
    while let Some(moment) = timeline.next() {
        match moment.data {
            MomentData::Scan(scan) => {
                let pose = if is_odometry { scan.odom_from_base } else { scan.map_from_base };
                of_scans.push(StampedPose { stamp: scan.stamp, world_from_body: lift(&pose) });
                timeline.recycle(scan.ranges_m);
            }
            MomentData::Odometry(odometry) if is_odometry => {
                let world_from_body = lift(&odometry.odom_from_base);
                of_odometry.push(StampedPose { stamp: odometry.stamp, world_from_body });
            }
            MomentData::Odometry(_) => {}
        }
    }
    // Both channels are in order already. Poses of scans come first, so that they stay where both have the same stamp.
    of_scans.append(&mut of_odometry);
    let (merged, _) = Trajectory::of(of_scans);
    let mut tally = timeline.tally().clone();
    // Beams say nothing about poses.
    tally.guessed = None;
    Ok((merged.poses().to_vec(), true, tally.sentences()))
}

fn from_lines(path: &Path, format: TrajectoryFormat, times: Option<&Path>) -> Result<Found, TrajectoryError> {
    let mut table = Table::open(path, format.pattern())?;
    let (mut poses, mut n_lines) = (Vec::new(), 0);
    while let Some(row) = table.next() {
        let index = Time::from_secs(n_lines as f64);
        let read = pose_line(row.line, row.words, format, index);
        n_lines += 1;
        if let Some(pose) = table.accept(read, format.name())? {
            poses.push(pose);
        }
    }
    let mut notes = table.notes();
    let is_kitti = format == TrajectoryFormat::Kitti;
    match times {
        Some(times) if is_kitti => {
            let stamps = stamps(times)?;
            if stamps.len() != n_lines {
                let (path, times, n_stamps) = (path.to_owned(), times.to_owned(), stamps.len());
                return Err(TrajectoryError::Times { path, times, n_stamps, n_poses: n_lines });
            }
            for pose in &mut poses {
                let idx = pose.stamp.as_secs() as usize;
                pose.stamp = stamps.get(idx).copied().unwrap_or(pose.stamp);
            }
        }
        Some(_) => notes.push("its lines have stamps, so the times file was not used".to_owned()),
        None => {}
    }
    Ok((poses, !is_kitti || times.is_some(), notes))
}

/// One stamp a line.
fn stamps(path: &Path) -> Result<Vec<Time>, TrajectoryError> {
    let mut table = Table::open(path, "one stamp a line, in seconds")?;
    let mut stamps = Vec::new();
    while let Some(row) = table.next() {
        let stamp = stamp_line(row.line, row.words);
        stamps.push(stamp.map_err(|fault| TrajectoryError::of_line(path, fault, "a file of stamps"))?);
    }
    Ok(stamps)
}
