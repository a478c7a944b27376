//! The whole state as bytes, to go on from later.
//!
//! Layout, little-endian: magic, version, stamps, odometer, number of scans, robot, errors of the odometer, walls with their ends, lower triangle of
//! the covariance by columns, tentative lines; last the CRC-32 of everything before it. Bytes that are not whole, of another
//! version, or that are no state are refused with their reason. The running means of innovations begin anew.

use super::FilterSettings;
use super::filter::{LineFilter, MapUse};
use super::tentative::{Candidate, Tentative};
use super::wall::Wall;
use nalgebra::{Cholesky, Matrix5, Vector5};
use rumbo_core::seal::{Broken, Reader, Seal};
use rumbo_core::time::Time;

/// Goes up with every change of the layout.
const VERSION: u32 = 2;
const SEAL: Seal = Seal { magic: *b"RUMBOEKF", version: VERSION };
/// No map that the filter can carry has more walls.
const MOST_WALLS: u64 = 20_000;

/// Why bytes are no saved state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SavedFault {
    /// Something else.
    #[error("this was not saved by a line filter")]
    Foreign,
    /// Written by another version.
    #[error("its version is {found}, expected {VERSION}")]
    Version {
        /// The version.
        found: u32,
    },
    /// A part is missing or changed.
    #[error("it is damaged or cut off")]
    Damaged,
    /// The filter estimates other errors of its odometer than the one that saved it.
    #[error(
        "it has {found} errors of the odometer, this filter estimates {expected}; keep `odometer_errors` as it was"
    )]
    OtherErrors {
        /// Errors that were saved.
        found: u64,
        /// Errors that are estimated.
        expected: u64,
    },
    /// It is whole, but its numbers are no state.
    #[error("its numbers are no state: {what}")]
    Impossible {
        /// What is wrong.
        what: &'static str,
    },
}

/// What is saved.
#[derive(Debug, Clone)]
pub struct SavedFilter {
    /// Time of the first reading.
    pub start: Time,
    /// Time of the state; none before the first reading.
    pub now: Option<Time>,
    /// The odometer's last reading: x, y (m), yaw (rad).
    pub odom_from_base: [f64; 3],
    /// When that was; none where it came with the start.
    pub odometry_stamp: Option<Time>,
    /// The filter.
    pub filter: LineFilter,
}

impl SavedFilter {
    /// As bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let LineFilter { state, walls, tentative, n_scans, .. } = &self.filter;
        let mut out = Writer(SEAL.begin(0));
        out.integers(&[self.start.0]);
        out.stamp(self.now);
        out.stamp(self.odometry_stamp);
        out.numbers(&self.odom_from_base);
        out.integers(&[*n_scans as i64, walls.len() as i64, tentative.candidates.len() as i64]);
        out.integers(&[state.odometer.len() as i64]);
        out.numbers(state.robot.as_slice());
        out.numbers(&state.odometer);
        for (line, wall) in state.walls.iter().zip(walls) {
            out.numbers(line);
            wall.ends_m.iter().for_each(|end| out.numbers(end));
        }
        let covariance = state.covariance.view();
        for col in 0..covariance.ncols() {
            (col..covariance.nrows()).for_each(|row| out.numbers(&[covariance[(row, col)]]));
        }
        for Candidate { line, piece, hits, last_scan } in &tentative.candidates {
            out.numbers(line);
            piece.ends_m.iter().for_each(|end| out.numbers(end));
            out.integers(&[i64::from(*hits), *last_scan as i64]);
        }
        Seal::close(out.0)
    }

    /// From bytes, as a filter that builds its map.
    ///
    /// # Errors
    /// Why the bytes are no state.
    pub fn from_bytes(bytes: &[u8], settings: FilterSettings) -> Result<SavedFilter, SavedFault> {
        let mut input = SEAL.open(bytes)?;
        let expected = settings.odometer.estimated().count() as u64;
        let saved = read(&mut input, settings, expected)?;
        if !input.is_empty() {
            return Err(SavedFault::Damaged);
        }
        if !saved.filter.state.is_finite() || !saved.odom_from_base.iter().all(|v| v.is_finite()) {
            return Err(SavedFault::Impossible { what: "a number is not finite" });
        }
        let covariance = saved.filter.state.covariance.view().into_owned();
        if Cholesky::new(covariance).is_none() {
            return Err(SavedFault::Impossible { what: "its covariance is not positive definite" });
        }
        Ok(saved)
    }
}

impl From<Broken> for SavedFault {
    fn from(broken: Broken) -> Self {
        match broken {
            Broken::Foreign => SavedFault::Foreign,
            Broken::Version(found) => SavedFault::Version { found },
            Broken::Damaged => SavedFault::Damaged,
        }
    }
}

/// What lies between.
fn read(input: &mut Reader<'_>, settings: FilterSettings, expected: u64) -> Result<SavedFilter, SavedFault> {
    let head = head(input).ok_or(SavedFault::Damaged)?;
    let found = head.n_odometer;
    if found != expected {
        return Err(SavedFault::OtherErrors { found, expected });
    }
    body(input, settings, head).ok_or(SavedFault::Damaged)
}

/// What comes before the numbers of the state.
struct Head {
    start: Time,
    now: Option<Time>,
    odometry_stamp: Option<Time>,
    odom_from_base: [f64; 3],
    n_scans: u64,
    n_walls: u64,
    n_candidates: u64,
    n_odometer: u64,
}

/// None where something is missing.
fn head(input: &mut Reader<'_>) -> Option<Head> {
    let (start, now, odometry_stamp) = (Time(input.i64()?), stamp(input)?, stamp(input)?);
    let odom_from_base = [input.f64()?, input.f64()?, input.f64()?];
    let n_scans = input.i64()? as u64;
    let [n_walls, n_candidates, n_odometer] = [input.i64()? as u64, input.i64()? as u64, input.i64()? as u64];
    let head =
        Head { start, now, odometry_stamp, odom_from_base, n_scans, n_walls, n_candidates, n_odometer };
    (n_walls.max(n_candidates) <= MOST_WALLS).then_some(head)
}

/// The state; none where something is missing.
fn body(input: &mut Reader<'_>, settings: FilterSettings, head: Head) -> Option<SavedFilter> {
    let Head { start, now, odometry_stamp, odom_from_base, n_scans, n_walls, n_candidates, .. } = head;
    let mut robot = Vector5::zeros();
    for number in robot.iter_mut() {
        *number = input.f64()?;
    }
    let mut filter = LineFilter::building(settings, robot, &Matrix5::zeros());
    let state = &mut filter.state;
    for number in &mut state.odometer {
        *number = input.f64()?;
    }
    let mut walls = Vec::new();
    for _ in 0..n_walls {
        state.walls.push([input.f64()?, input.f64()?]);
        walls.push(Wall { ends_m: ends_m(input)? });
    }
    state.covariance.grow(2 * walls.len());
    let size = state.covariance.size();
    for col in 0..size {
        let mut covariance = state.covariance.view_mut();
        for row in col..size {
            covariance[(row, col)] = input.f64()?;
        }
    }
    state.covariance.mirror_lower(size);
    let mut tentative = Tentative::default();
    for _ in 0..n_candidates {
        let (line, piece) = ([input.f64()?, input.f64()?], Wall { ends_m: ends_m(input)? });
        let (hits, last_scan) = (input.i64()? as u32, input.i64()? as u64);
        tentative.candidates.push(Candidate { line, piece, hits, last_scan });
    }
    (filter.map_use, filter.walls) = (MapUse::Build, walls);
    (filter.tentative, filter.n_scans) = (tentative, n_scans);
    Some(SavedFilter { start, now, odom_from_base, odometry_stamp, filter })
}

struct Writer(Vec<u8>);

impl Writer {
    fn numbers(&mut self, numbers: &[f64]) {
        numbers.iter().for_each(|number| self.0.extend_from_slice(&number.to_le_bytes()));
    }

    fn integers(&mut self, integers: &[i64]) {
        integers.iter().for_each(|integer| self.0.extend_from_slice(&integer.to_le_bytes()));
    }

    fn stamp(&mut self, stamp: Option<Time>) {
        self.integers(&[i64::from(stamp.is_some()), stamp.map_or(0, |stamp| stamp.0)]);
    }
}

fn stamp(input: &mut Reader<'_>) -> Option<Option<Time>> {
    let (is_there, stamp) = (input.i64()? != 0, Time(input.i64()?));
    Some(is_there.then_some(stamp))
}

fn ends_m(input: &mut Reader<'_>) -> Option<[[f64; 2]; 2]> {
    Some([[input.f64()?, input.f64()?], [input.f64()?, input.f64()?]])
}
