//! Reading the lists of a folder.

use std::path::{Component, Path, PathBuf};

use rumbo_core::time::{Span, Time};

use super::error::RgbdError;
use crate::log_file::LineFault;
use crate::log_file::{FaultKind, words::Words, words::shown};
use crate::mrclam::MrclamError;
use crate::mrclam::order::{Stamped, sorted};
use crate::mrclam::table;
use crate::trajectory::{Trajectory, TrajectoryFormat, read_trajectory};

const PICTURES: &str = "depth.txt";
const POSES: &str = "groundtruth.txt";
const ACCELERATIONS: &str = "accelerometer.txt";

/// A depth picture of a folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DepthFrame {
    /// When it was taken.
    pub stamp: Time,
    /// Its file, which was there when the folder was read.
    pub path: PathBuf,
}

/// What a folder has, in the order of the stamps, no two pictures at the same.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RgbdFolder {
    /// Depth pictures; at least one.
    pub frames: Vec<DepthFrame>,
    /// Specific force along the axes of the accelerometer (x left, y up, z along the optical axis), m/s²; may be empty.
    pub accelerations_m_s2: Vec<(Time, [f64; 3])>,
    /// What people should know of the files.
    pub sentences: Vec<String>,
}

impl RgbdFolder {
    /// The first stamp: where the time of a run begins.
    pub fn origin(&self) -> Time {
        let first_picture = self.frames.first().map(|frame| frame.stamp);
        let first_acceleration = self.accelerations_m_s2.first().map(|(stamp, _)| *stamp);
        first_picture.into_iter().chain(first_acceleration).min().unwrap_or(Time::ZERO)
    }
}

/// Pictures that are farther apart than this are told.
const GAP: Span = Span(1_000_000_000);

/// The folder looks like one of this kind.
pub fn is_folder(folder: &Path) -> bool {
    table::find(folder, PICTURES).is_ok()
}

/// Reads the lists of a folder; no picture is opened.
///
/// # Errors
/// [`RgbdError`] for a list that is missing, empty or cannot be read at all, and where no listed picture is there.
pub fn read_folder(folder: &Path) -> Result<RgbdFolder, RgbdError> {
    let mut read = RgbdFolder::default();
    read_pictures(folder, &mut read)?;
    match table::find(folder, ACCELERATIONS) {
        Ok(path) => read_accelerations(path, &mut read)?,
        Err(MrclamError::Missing { .. }) => {}
        Err(error) => return Err(error.into()),
    }
    Ok(read)
}

/// Where the optical center was, and what people should know of the file.
///
/// # Errors
/// [`RgbdError`] where there is no such file, or it is not whole.
pub fn read_camera_track(folder: &Path) -> Result<(Trajectory, Vec<String>), RgbdError> {
    let path = table::find(folder, POSES).map_err(|error| match error {
        MrclamError::Missing { folder, .. } => RgbdError::NoPoses { folder },
        other => other.into(),
    })?;
    let read = read_trajectory(&path, Some(TrajectoryFormat::Tum), None)?;
    let sentences = read.notes.iter().map(|note| format!("{POSES}: {note}")).collect();
    Ok((read.trajectory, sentences))
}

fn read_pictures(folder: &Path, read: &mut RgbdFolder) -> Result<(), RgbdError> {
    let table = table::read(table::find(folder, PICTURES)?, "depth", |words| {
        Ok(Stamped { stamp: words.stamp("timestamp")?, told: file_name(words)? })
    })?;
    let table = table.with_rows("timestamp filename")?;
    let (name, n_listed) = (table.name(), table.rows.len());
    read.sentences.extend(table.sentences());
    let (rows, order) = sorted(table.rows, &name);
    read.sentences.extend(order);
    let (mut missing, mut repeated) = (Vec::new(), Vec::new());
    for Stamped { stamp, told } in rows {
        let path = folder.join(&told);
        if !path.is_file() {
            missing.push(told);
        } else if read.frames.last().is_some_and(|last| last.stamp == stamp) {
            repeated.push(told);
        } else {
            read.frames.push(DepthFrame { stamp, path });
        }
    }
    if read.frames.is_empty() {
        let first = missing.into_iter().next().unwrap_or_default();
        return Err(RgbdError::NoPictures { folder: folder.to_owned(), n_listed, first });
    }
    for (found, what) in
        [(missing, "that are not there"), (repeated, "with the stamp of the picture before them")]
    {
        if let Some(first) = found.first() {
            let n = found.len();
            read.sentences.push(format!("{name}: left out {n} pictures {what}, first {first}"));
        }
    }
    read.sentences.extend(gaps(&read.frames).map(|gaps| format!("{name}: {gaps}")));
    Ok(())
}

/// A path inside of the folder, and nowhere else.
fn file_name(words: &mut Words<'_>) -> Result<String, LineFault> {
    let word = words.word("filename")?;
    let is_inside = |name: &&str| {
        Path::new(name).components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
    };
    let name = std::str::from_utf8(word).ok().filter(is_inside);
    name.map(str::to_owned).ok_or_else(|| {
        words.fault(FaultKind::OutOfRange, "filename", shown(word), "a path inside of the folder")
    })
}

fn gaps(frames: &[DepthFrame]) -> Option<String> {
    let between = frames.iter().zip(frames.iter().skip(1)).map(|(a, b)| (b.stamp - a.stamp, a.stamp));
    let gaps: Vec<(Span, Time)> = between.filter(|(gap, _)| *gap > GAP).collect();
    let (longest, after) = gaps.iter().max_by_key(|(gap, after)| (*gap, std::cmp::Reverse(*after)))?;
    let n = gaps.len();
    Some(format!(
        "{n} gaps of more than 1 s between pictures, the longest of {:.3} s after the one of {:.6} s",
        longest.as_secs(),
        after.as_secs()
    ))
}

fn read_accelerations(path: PathBuf, read: &mut RgbdFolder) -> Result<(), RgbdError> {
    let table = table::read(path, "accelerometer", |words| {
        let stamp = words.stamp("timestamp")?;
        Ok(Stamped { stamp, told: [words.number("ax")?, words.number("ay")?, words.number("az")?] })
    })?;
    let name = table.name();
    read.sentences.extend(table.sentences());
    let (rows, order) = sorted(table.rows, &name);
    read.sentences.extend(order);
    read.accelerations_m_s2 = rows.into_iter().map(|row| (row.stamp, row.told)).collect();
    let n = read.accelerations_m_s2.len();
    read.accelerations_m_s2.dedup_by_key(|(stamp, _)| *stamp);
    let n_repeated = n - read.accelerations_m_s2.len();
    if n_repeated > 0 {
        read.sentences
            .push(format!("{name}: left out {n_repeated} rows with the stamp of the row before them"));
    }
    Ok(())
}
