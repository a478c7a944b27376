//! A model on disk, so that it is built once for a map.
//!
//! Layout, little-endian: magic, version, fingerprint of the map and of everything that the model depends on, width,
//! height, one byte a place, number of bands; of each band the numbers of its looks and of its list bytes, then looks, ends
//! and lists; the number of entries of the index of regions, and where there are any its ends and lists; last the CRC-32 of everything before it. A file that is not whole, of another version or of another map is
//! refused with its reason, and one that is accepted holds together.

use super::band::Band;
use super::build::{LandmarkModel, band_places};
use super::order::CellOrder;
use super::regions::{N_HASHES, RegionIndex};
use super::surroundings::ModelSettings;
use crate::GridSize;
use crate::landmarks::WallFit;
use rumbo_core::map::Grid;
use rumbo_core::seal::{Broken, Reader, Seal};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};

/// Goes up with every change of the layout or of what a model of the same map would hold.
const VERSION: u32 = 2;
const SEAL: Seal = Seal { magic: *b"RUMBOLMK", version: VERSION };
/// No model of a map that can be loaded is larger, bytes.
const MOST_BYTES: u64 = 4 << 30;

/// Why a file is not the model that was asked for.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelFileError {
    /// The system says no.
    #[error("{0}")]
    System(#[from] std::io::Error),
    /// Another kind of file.
    #[error("this is no landmark model")]
    Foreign,
    /// Written by another version.
    #[error("its version is {found}, expected {VERSION}")]
    Version {
        /// The version.
        found: u32,
    },
    /// It belongs to another map or other parameters.
    #[error("it was made for another map or with other parameters")]
    Stale,
    /// A part is missing or changed.
    #[error("it is damaged or cut off")]
    Damaged,
}

impl From<Broken> for ModelFileError {
    fn from(broken: Broken) -> Self {
        match broken {
            Broken::Foreign => ModelFileError::Foreign,
            Broken::Version(found) => ModelFileError::Version { found },
            Broken::Damaged => ModelFileError::Damaged,
        }
    }
}

/// What a model depends on, as one number: cells, size, and all settings.
pub fn fingerprint(grid: &Grid, settings: &ModelSettings) -> [u8; 32] {
    let mut hash = Sha256::new();
    hash.update(grid.width().to_le_bytes());
    hash.update(grid.height().to_le_bytes());
    hash.update(grid.resolution_m().to_le_bytes());
    add_settings(&mut hash, settings);
    let classes: Vec<u8> = grid.cells.iter().map(|cell| grid.class_of(*cell) as u8).collect();
    hash.update(classes);
    hash.finalize().into()
}

/// Eight hexadecimal digits that name settings: models of one map that were made with other settings lie side by side.
pub fn settings_name(settings: &ModelSettings) -> String {
    let mut hash = Sha256::new();
    add_settings(&mut hash, settings);
    hash.finalize().iter().take(4).map(|byte| format!("{byte:02x}")).collect()
}

fn add_settings(hash: &mut Sha256, settings: &ModelSettings) {
    let landmarks = &settings.landmarks;
    let numbers = [
        settings.range_m,
        landmarks.discontinuity_m,
        landmarks.corner_m,
        landmarks.wall_m,
        landmarks.range_deviation_m,
    ];
    numbers.into_iter().for_each(|number| hash.update(number.to_le_bytes()));
    let counts = [settings.n_rays as u64, landmarks.least_readings as u64];
    counts.into_iter().for_each(|count| hash.update(count.to_le_bytes()));
    let is_hough = landmarks.wall_fit == WallFit::Hough;
    hash.update([u8::from(is_hough), u8::from(landmarks.spares_grazed_walls)]);
}

/// Writes a model beside its place and then moves it there: others never see half of it.
///
/// # Errors
/// What the system says.
pub fn save_model(path: &Path, model: &LandmarkModel, fingerprint: &[u8; 32]) -> Result<(), ModelFileError> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let number = NUMBER.fetch_add(1, Ordering::Relaxed);
    let beside = path.with_added_extension(format!("{}-{number}.part", std::process::id()));
    let written = File::create_new(&beside)
        .and_then(|mut file| file.write_all(&bytes_of(model, fingerprint)).and_then(|()| file.sync_all()))
        .and_then(|()| std::fs::rename(&beside, path));
    if let Err(error) = written {
        // What is left of it is of no use; that it cannot be removed says no more than the error itself.
        let _ = std::fs::remove_file(&beside);
        return Err(error.into());
    }
    Ok(())
}

/// Reads the model with this fingerprint.
///
/// # Errors
/// Why the file is not that.
pub fn load_model(path: &Path, fingerprint: &[u8; 32]) -> Result<LandmarkModel, ModelFileError> {
    let file = File::open(path)?;
    let found = file.metadata()?;
    if !found.is_file() || found.len() > MOST_BYTES {
        return Err(ModelFileError::Foreign);
    }
    let mut bytes = Vec::new();
    file.take(MOST_BYTES).read_to_end(&mut bytes)?;
    model_of(&bytes, fingerprint)
}

fn bytes_of(model: &LandmarkModel, fingerprint: &[u8; 32]) -> Vec<u8> {
    let mut bytes = SEAL.begin(model.n_bytes() + 128);
    bytes.extend(fingerprint);
    let counts = [model.size.width, model.size.height].map(|n| (n as u32).to_le_bytes());
    bytes.extend(counts.concat());
    bytes.extend(&model.n_landmarks);
    bytes.extend((model.bands.len() as u32).to_le_bytes());
    for band in &model.bands {
        bytes.extend((band.codes.len() as u32).to_le_bytes());
        bytes.extend((band.lists.len() as u32).to_le_bytes());
        band.codes.iter().chain(&band.ends).for_each(|number| bytes.extend(number.to_le_bytes()));
        bytes.extend(&band.lists);
    }
    let RegionIndex { ends, regions } = &model.regions;
    bytes.extend((regions.len() as u32).to_le_bytes());
    ends.iter().chain(regions).for_each(|number| bytes.extend(number.to_le_bytes()));
    Seal::close(bytes)
}

fn model_of(bytes: &[u8], fingerprint: &[u8; 32]) -> Result<LandmarkModel, ModelFileError> {
    let mut rest = SEAL.open(bytes)?;
    if rest.take(fingerprint.len()).is_none_or(|found| found != fingerprint) {
        return Err(ModelFileError::Stale);
    }
    parts(rest).filter(is_sound).ok_or(ModelFileError::Damaged)
}

/// What stands between fingerprint and checksum.
fn parts(mut rest: Reader<'_>) -> Option<LandmarkModel> {
    let size = GridSize::new(rest.u32()? as usize, rest.u32()? as usize);
    size.width.checked_mul(size.height)?;
    let order = CellOrder::new(size);
    let n_landmarks = rest.take(order.n_places())?.to_vec();
    let n_bands = rest.u32()? as usize;
    let mut bands = Vec::new();
    for _ in 0..n_bands {
        let [n_codes, n_bytes] = [rest.u32()? as usize, rest.u32()? as usize];
        let (codes, ends) = (rest.u32s(n_codes)?, rest.u32s(n_codes)?);
        bands.push(Band { codes, ends, lists: rest.take(n_bytes)?.to_vec() });
    }
    let n_regions = rest.u32()? as usize;
    let n_ends = if n_regions > 0 { N_HASHES } else { 0 };
    let regions = RegionIndex { ends: rest.u32s(n_ends)?, regions: rest.u32s(n_regions)? };
    rest.is_empty().then_some(LandmarkModel { size, order, n_landmarks, bands, regions })
}

fn is_sound(model: &LandmarkModel) -> bool {
    let cells_of_bands = model.n_landmarks.chunks(band_places(model.n_places()));
    model.regions.is_sound(model.n_places())
        && cells_of_bands.len() == model.bands.len()
        && model.bands.iter().zip(cells_of_bands).all(|(band, cells)| band.is_sound(cells))
}
