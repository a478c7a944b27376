//! The whole state as bytes, to go on from later.
//!
//! Layout, little-endian: magic, version, stamps, odometer, number of scans, robot, walls with their ends, lower triangle of
//! the covariance by columns, tentative lines; last the CRC-32 of everything before it. Bytes that are not whole, of another
//! version, or that are no state are refused with their reason. The running means of innovations begin anew.

use super::FilterSettings;
use super::filter::{LineFilter, MapUse};
use super::state::{ROBOT, State};
use super::tentative::{Candidate, Tentative};
use super::wall::Wall;
use nalgebra::{Cholesky, Matrix5, Vector5};
use rumbo_core::time::Time;

const MAGIC: [u8; 8] = *b"RUMBOEKF";
/// Goes up with every change of the layout.
const VERSION: u32 = 1;
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
        let mut out = Writer(Vec::new());
        out.0.extend_from_slice(&MAGIC);
        out.0.extend_from_slice(&VERSION.to_le_bytes());
        out.integers(&[self.start.0]);
        out.stamp(self.now);
        out.stamp(self.odometry_stamp);
        out.numbers(&self.odom_from_base);
        out.integers(&[*n_scans as i64, walls.len() as i64, tentative.candidates.len() as i64]);
        out.numbers(state.robot.as_slice());
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
        let sum = crc32fast::hash(&out.0);
        out.0.extend_from_slice(&sum.to_le_bytes());
        out.0
    }

    /// From bytes, as a filter that builds its map.
    ///
    /// # Errors
    /// Why the bytes are no state.
    pub fn from_bytes(bytes: &[u8], settings: FilterSettings) -> Result<SavedFilter, SavedFault> {
        let body = checked(bytes)?;
        let mut input = Reader(body);
        let saved = read(&mut input, settings)?;
        if !input.0.is_empty() {
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

/// What lies between head and check sum.
fn checked(bytes: &[u8]) -> Result<&[u8], SavedFault> {
    let Some((head, rest)) = bytes.split_first_chunk::<8>() else { return Err(SavedFault::Foreign) };
    if *head != MAGIC {
        return Err(SavedFault::Foreign);
    }
    let Some((version, rest)) = rest.split_first_chunk::<4>() else { return Err(SavedFault::Damaged) };
    let found = u32::from_le_bytes(*version);
    if found != VERSION {
        return Err(SavedFault::Version { found });
    }
    let Some((body, sum)) = rest.split_last_chunk::<4>() else { return Err(SavedFault::Damaged) };
    let whole = bytes.get(..bytes.len() - sum.len()).unwrap_or_default();
    if crc32fast::hash(whole) != u32::from_le_bytes(*sum) {
        return Err(SavedFault::Damaged);
    }
    Ok(body)
}

fn read(input: &mut Reader<'_>, settings: FilterSettings) -> Result<SavedFilter, SavedFault> {
    let (start, now, odometry_stamp) = (Time(input.integer()?), input.stamp()?, input.stamp()?);
    let odom_from_base = [input.number()?, input.number()?, input.number()?];
    let n_scans = input.integer()? as u64;
    let [n_walls, n_candidates] = [input.integer()? as u64, input.integer()? as u64];
    if n_walls.max(n_candidates) > MOST_WALLS {
        return Err(SavedFault::Damaged);
    }
    let mut robot = Vector5::zeros();
    for number in robot.iter_mut() {
        *number = input.number()?;
    }
    let mut state = State::new(robot, &Matrix5::zeros());
    let mut walls = Vec::new();
    for _ in 0..n_walls {
        state.walls.push([input.number()?, input.number()?]);
        walls.push(Wall { ends_m: input.ends_m()? });
    }
    state.covariance.grow(2 * walls.len());
    let size = ROBOT + 2 * walls.len();
    for col in 0..size {
        let mut covariance = state.covariance.view_mut();
        for row in col..size {
            covariance[(row, col)] = input.number()?;
        }
    }
    state.covariance.mirror_lower(size);
    let mut tentative = Tentative::default();
    for _ in 0..n_candidates {
        let (line, piece) = ([input.number()?, input.number()?], Wall { ends_m: input.ends_m()? });
        let (hits, last_scan) = (input.integer()? as u32, input.integer()? as u64);
        tentative.candidates.push(Candidate { line, piece, hits, last_scan });
    }
    let mut filter = LineFilter::building(settings, robot, &Matrix5::zeros());
    (filter.map_use, filter.state, filter.walls) = (MapUse::Build, state, walls);
    (filter.tentative, filter.n_scans) = (tentative, n_scans);
    Ok(SavedFilter { start, now, odom_from_base, odometry_stamp, filter })
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

struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn eight(&mut self) -> Result<[u8; 8], SavedFault> {
        let (eight, rest) = self.0.split_first_chunk::<8>().ok_or(SavedFault::Damaged)?;
        self.0 = rest;
        Ok(*eight)
    }

    fn number(&mut self) -> Result<f64, SavedFault> {
        self.eight().map(f64::from_le_bytes)
    }

    fn integer(&mut self) -> Result<i64, SavedFault> {
        self.eight().map(i64::from_le_bytes)
    }

    fn stamp(&mut self) -> Result<Option<Time>, SavedFault> {
        let (is_there, stamp) = (self.integer()? != 0, Time(self.integer()?));
        Ok(is_there.then_some(stamp))
    }

    fn ends_m(&mut self) -> Result<[[f64; 2]; 2], SavedFault> {
        Ok([[self.number()?, self.number()?], [self.number()?, self.number()?]])
    }
}
