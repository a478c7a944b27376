//! A saved SLAM as a file: whose it is, where the robot was, and what the plugin itself wrote.
//!
//! Layout, little-endian: the word `RUMBOSLM`, the version (u32), the plugin's name and version (u32 length and UTF-8
//! each), the robot in the map (x and y in meters, cosine and sine of its heading) and the covariance of x, y, yaw by
//! rows as f64, one byte that is 1 where the robot was lost, the plugin's bytes (u64 length), the CRC-32 of all that.

use crate::frames::Pose2;
use crate::seal::{Broken, Reader, Seal};
use nalgebra::{Complex, Matrix3, Translation2, UnitComplex};
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

const SEAL: Seal = Seal { magic: *b"RUMBOSLM", version: 1 };
/// How far the squared norm of a heading may be from 1: rounding, nothing else.
const UNIT: f64 = 1e-6;

/// A saved SLAM.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedState {
    /// Name of the plugin that saved it.
    pub plugin: String,
    /// Its version.
    pub version: String,
    /// The robot in the map.
    pub map_from_base: Pose2,
    /// Covariance of x, y, yaw.
    pub covariance: Matrix3<f64>,
    /// Nobody knew where the robot was.
    pub is_lost: bool,
    /// What the plugin saved.
    pub bytes: Vec<u8>,
}

/// Why a file is no saved SLAM that can be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum StateFault {
    /// It cannot be read.
    #[error("cannot read {path}: {reason}")]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        reason: String,
    },
    /// Something else.
    #[error("{path} is no saved SLAM; `rumbo run --save-state` writes one")]
    Foreign {
        /// The file.
        path: PathBuf,
    },
    /// Another version of the format.
    #[error("{path} is of the version {found}, this program reads version {}", SEAL.version)]
    Version {
        /// The file.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// A part is missing or changed.
    #[error("{path} is damaged or cut off")]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// It was saved by another plugin.
    #[error("{path} was saved by `{found}`, and [slam] is `{expected}`")]
    OtherPlugin {
        /// The file.
        path: PathBuf,
        /// Whose it is.
        found: String,
        /// Who shall go on from it.
        expected: String,
    },
}

impl SavedState {
    /// As bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut out = SEAL.begin(self.bytes.len() + 256);
        for text in [&self.plugin, &self.version] {
            out.extend((text.len() as u32).to_le_bytes());
            out.extend(text.as_bytes());
        }
        let Pose2 { translation, rotation } = &self.map_from_base;
        let pose = [translation.x, translation.y, rotation.re, rotation.im];
        let covariance = self.covariance.transpose();
        pose.iter().chain(covariance.iter()).for_each(|number| out.extend(number.to_le_bytes()));
        out.push(self.is_lost.into());
        out.extend((self.bytes.len() as u64).to_le_bytes());
        out.extend(&self.bytes);
        Seal::close(out)
    }

    /// Writes the file, whole or not at all: what was there stays until the new one is complete.
    ///
    /// # Errors
    /// What the system says.
    pub fn write(&self, path: &Path) -> io::Result<()> {
        let part = path.with_added_extension(format!("{}.part", std::process::id()));
        let written = File::create(&part).and_then(|mut file| {
            file.write_all(&self.to_bytes())?;
            file.sync_all()
        });
        let moved = written.and_then(|()| std::fs::rename(&part, path));
        if moved.is_err() {
            // Whether the part can be removed changes nothing of what is told.
            let _ = std::fs::remove_file(&part);
        }
        moved
    }

    /// Reads a file that the plugin `plugin` shall go on from.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn read(path: &Path, plugin: &str) -> Result<SavedState, StateFault> {
        let path_buf = || path.to_path_buf();
        let bytes = std::fs::read(path)
            .map_err(|error| StateFault::File { path: path_buf(), reason: error.to_string() })?;
        let state = Self::from_bytes(&bytes).map_err(|broken| match broken {
            Broken::Foreign => StateFault::Foreign { path: path_buf() },
            Broken::Version(found) => StateFault::Version { path: path_buf(), found },
            Broken::Damaged => StateFault::Damaged { path: path_buf() },
        })?;
        if state.plugin != plugin {
            let (found, expected) = (state.plugin, plugin.to_owned());
            return Err(StateFault::OtherPlugin { path: path_buf(), found, expected });
        }
        Ok(state)
    }

    fn from_bytes(bytes: &[u8]) -> Result<SavedState, Broken> {
        let content = SEAL.open(bytes)?;
        Self::content(content).filter(SavedState::is_sound).ok_or(Broken::Damaged)
    }

    /// What lies under the seal.
    fn content(mut rest: Reader<'_>) -> Option<SavedState> {
        let (plugin, version) = (text(&mut rest)?, text(&mut rest)?);
        let [x, y, re, im] = numbers(&mut rest)?;
        let rotation = UnitComplex::new_unchecked(Complex::new(re, im));
        let map_from_base = Pose2::from_parts(Translation2::new(x, y), rotation);
        let covariance = Matrix3::from_row_slice(&numbers::<9>(&mut rest)?);
        let is_lost = rest.chunk::<1>()? == [1];
        let n = usize::try_from(u64::from_le_bytes(rest.chunk()?)).ok()?;
        let bytes = rest.take(n)?.to_vec();
        rest.is_empty().then_some(SavedState { plugin, version, map_from_base, covariance, is_lost, bytes })
    }

    fn is_sound(&self) -> bool {
        let Pose2 { translation, rotation } = &self.map_from_base;
        let norm2 = rotation.re * rotation.re + rotation.im * rotation.im;
        translation.x.is_finite()
            && translation.y.is_finite()
            && (norm2 - 1.0).abs() <= UNIT
            && self.covariance.iter().all(|number| number.is_finite())
    }
}

fn text(rest: &mut Reader<'_>) -> Option<String> {
    let n = usize::try_from(rest.u32()?).ok()?;
    String::from_utf8(rest.take(n)?.to_vec()).ok()
}

fn numbers<const N: usize>(rest: &mut Reader<'_>) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = rest.f64()?;
    }
    Some(numbers)
}

#[cfg(test)]
mod tests;
