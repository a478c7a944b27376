//! What one robot wrote down, and where it was.

use std::path::Path;

use rumbo_core::time::Time;

use super::error::MrclamError;
use super::order::{Stamped, sorted};
use super::shared::{read_barcodes, read_landmarks};
use super::table;
use crate::log_file::PoseTrack;

/// What the wheels were told at a time, until the next time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Velocity {
    /// From when on, absolute.
    pub stamp: Time,
    /// Forward, meters per second.
    pub forward_m_s: f64,
    /// Counter-clockwise, radians per second.
    pub turn_rad_s: f64,
}

/// A landmark that the camera recognized.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// When, absolute.
    pub stamp: Time,
    /// Which one.
    pub subject: u32,
    /// How far, meters.
    pub range_m: f64,
    /// Where, counter-clockwise from straight ahead, radians.
    pub bearing_rad: f64,
}

/// What one robot wrote down, in the order of the stamps.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RobotLog {
    /// Its velocities.
    pub velocities: Vec<Velocity>,
    /// The landmarks that it saw. Sightings of other robots, which move, are left out.
    pub sightings: Vec<Sighting>,
    /// Sightings of other robots.
    pub n_robots_seen: u64,
    /// What people should know of the files.
    pub sentences: Vec<String>,
}

/// Where one robot was.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RobotTruth {
    /// Poses at their absolute stamps.
    pub track: PoseTrack,
    /// What people should know of the file.
    pub sentences: Vec<String>,
}

/// What a row of the measurements says.
#[derive(Debug, Clone, Copy)]
struct Measured {
    barcode: u32,
    range_m: f64,
    bearing_rad: f64,
}

/// Reads what a robot wrote down.
///
/// # Errors
/// [`MrclamError`] for a table that is missing, empty or cannot be read at all.
pub fn read_robot(folder: &Path, robot: u32) -> Result<RobotLog, MrclamError> {
    let mut log = RobotLog::default();
    read_velocities(folder, robot, &mut log)?;
    read_sightings(folder, robot, &mut log)?;
    Ok(log)
}

/// Reads where a robot was.
///
/// # Errors
/// [`MrclamError`] for a table that is missing, empty or cannot be read at all.
pub fn read_truth(folder: &Path, robot: u32) -> Result<RobotTruth, MrclamError> {
    let name = format!("Robot{robot}_Groundtruth.dat");
    let table = table::read(table::find(folder, &name)?, "Groundtruth", |words| {
        let stamp = words.stamp("time")?;
        Ok(Stamped { stamp, told: words.pose(["x", "y", "orientation"], 1.0)? })
    })?;
    let table = table.with_rows("time x y orientation")?;
    let (name, mut sentences) = (table.name(), table.sentences());
    let (rows, order) = sorted(table.rows, &name);
    sentences.extend(order);
    let mut track = PoseTrack::default();
    rows.into_iter().for_each(|row| track.push(row.stamp, row.told));
    Ok(RobotTruth { track, sentences })
}

fn read_velocities(folder: &Path, robot: u32, log: &mut RobotLog) -> Result<(), MrclamError> {
    let name = format!("Robot{robot}_Odometry.dat");
    let table = table::read(table::find(folder, &name)?, "Odometry", |words| {
        let stamp = words.stamp("time")?;
        Ok(Stamped { stamp, told: [words.number("forward_velocity")?, words.number("angular_velocity")?] })
    })?;
    let table = table.with_rows("time forward_velocity angular_velocity")?;
    let name = table.name();
    log.sentences.extend(table.sentences());
    let (rows, order) = sorted(table.rows, &name);
    log.sentences.extend(order);
    let velocity = |Stamped { stamp, told: [forward_m_s, turn_rad_s] }: Stamped<[f64; 2]>| Velocity {
        stamp,
        forward_m_s,
        turn_rad_s,
    };
    log.velocities = rows.into_iter().map(velocity).collect();
    Ok(())
}

fn read_sightings(folder: &Path, robot: u32, log: &mut RobotLog) -> Result<(), MrclamError> {
    let (barcodes, landmarks) = (read_barcodes(folder)?, read_landmarks(folder)?);
    let name = format!("Robot{robot}_Measurement.dat");
    let table = table::read(table::find(folder, &name)?, "Measurement", |words| {
        let (stamp, barcode) = (words.stamp("time")?, table::whole(words, "subject")?);
        let (range_m, bearing_rad) = (table::not_negative(words, "range")?, words.number("bearing")?);
        Ok(Stamped { stamp, told: Measured { barcode, range_m, bearing_rad } })
    })?;
    let table = table.with_rows("time barcode range bearing")?;
    let name = table.name();
    log.sentences.extend(table.sentences());
    let (mut n_unknown, mut first) = (0_u64, None);
    for row in table.rows.iter().filter(|row| !barcodes.contains_key(&row.told.told.barcode)) {
        n_unknown += 1;
        first.get_or_insert((row.told.told.barcode, row.line));
    }
    if let Some((barcode, line)) = first {
        log.sentences.push(format!(
            "{name}: left out {n_unknown} sightings of bar codes that Barcodes.dat does not have, first {barcode} in \
             line {line}"
        ));
    }
    let (rows, order) = sorted(table.rows, &name);
    log.sentences.extend(order);
    for Stamped { stamp, told: Measured { barcode, range_m, bearing_rad } } in rows {
        let Some(&subject) = barcodes.get(&barcode) else { continue };
        if landmarks.iter().any(|landmark| landmark.subject == subject) {
            log.sightings.push(Sighting { stamp, subject, range_m, bearing_rad });
        } else {
            log.n_robots_seen += 1;
        }
    }
    Ok(())
}
