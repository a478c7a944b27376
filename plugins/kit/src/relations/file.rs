//! Files of relations: lines of `t1 t2 x y z roll pitch yaw`, seconds, meters and radians, plain or gzip.

use std::path::Path;

use nalgebra::{Translation3, UnitQuaternion};
use rumbo_core::frames::Pose3;
use rumbo_core::time::Time;

use crate::log_file::words::Words;
use crate::log_file::{FaultKind, LineFault};
use crate::trajectory::TrajectoryError;
use crate::trajectory::table::Table;

const PATTERN: &str = "t1 t2 x y z roll pitch yaw";

/// How the robot moved from one time to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relation {
    /// When it was at the first pose.
    pub from: Time,
    /// When it was at the second.
    pub to: Time,
    /// The second pose, seen from the first.
    pub first_from_second: Pose3,
}

/// Reads a file of relations, and a sentence for each thing that people should know of it.
///
/// # Errors
/// [`TrajectoryError`] for a file that is missing, a folder or without relations, and for a line that cannot be read.
pub fn read_relations(path: &Path) -> Result<(Vec<Relation>, Vec<String>), TrajectoryError> {
    let mut table = Table::open(path, PATTERN)?;
    let mut relations = Vec::new();
    while let Some(row) = table.next() {
        let read = relation(Words::new(row.line, row.words).of("relation"));
        relations.extend(table.accept(read, "a file of relations")?);
    }
    if relations.is_empty() {
        let (path, found) = (path.to_owned(), format!("no relation ({})", table.why_empty()));
        return Err(TrajectoryError::Empty { path, found, expected: format!("lines of `{PATTERN}`") });
    }
    Ok((relations, table.notes()))
}

fn relation(mut words: Words<'_>) -> Result<Relation, LineFault> {
    let (from, to) = (words.stamp("t1")?, words.stamp("t2")?);
    let translation = Translation3::new(words.number("x")?, words.number("y")?, words.number("z")?);
    let [roll, pitch, yaw] = [words.number("roll")?, words.number("pitch")?, words.number("yaw")?];
    let n = words.n_left();
    if n > 0 {
        let found = format!("followed by {n} more words");
        return Err(words.fault(FaultKind::CountDiffers, "end", found, PATTERN));
    }
    let rotation = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok(Relation { from, to, first_from_second: Pose3::from_parts(translation, rotation) })
}
