//! What is remembered, as bytes to keep beside a map.
//!
//! Layout, little-endian: magic, version, fingerprint of the map with what was learned; columns, rows, edge of a cell and
//! corner of the raster; number of visits; number of cells of which something is remembered and for each its index, what it
//! became (0 as it was made, 1 occupied, 2 free), visits that saw it occupied and visits that saw it free; one bit a cell
//! for those that a laser met; last the CRC-32 of everything before it.

use super::evidence::Verdict;
use super::memory::{CellMemory, Memory};
use super::raster::Raster;
use rumbo_core::seal::{Broken, Reader, Seal};
use rumbo_kit::GridSize;

/// Goes up with every change of the layout, or of what it means.
const VERSION: u32 = 1;
const SEAL: Seal = Seal { magic: *b"RUMBOLCH", version: VERSION };

/// Why bytes are not the memory of visits to a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MemoryFault {
    /// Something else.
    #[error("this is no memory of visits; `rumbo map` writes one beside the map")]
    Foreign,
    /// Written by a later version.
    #[error(
        "its version is {found}, this program reads {VERSION}; take the program that wrote it, or begin anew without it"
    )]
    Version {
        /// The version.
        found: u32,
    },
    /// A part is missing or changed.
    #[error("it is damaged or cut off; take a copy, or begin anew without it")]
    Damaged,
    /// It belongs to another map.
    #[error(
        "it belongs to another map, or the map was changed by hand since; name the map that was saved with it or the one \
         that the first visit began with, or begin anew without it"
    )]
    OtherMap,
}

impl From<Broken> for MemoryFault {
    fn from(broken: Broken) -> Self {
        match broken {
            Broken::Foreign => MemoryFault::Foreign,
            Broken::Version(found) => MemoryFault::Version { found },
            Broken::Damaged => MemoryFault::Damaged,
        }
    }
}

/// What is remembered of visits to the map of this raster, as it is with what was learned.
pub fn memory_bytes(memory: &Memory, raster: &Raster) -> Vec<u8> {
    let mut learned = raster.clone();
    memory.apply(&mut learned);
    let size = raster.size();
    let mut bytes = SEAL.begin(128 + memory.cells.len() * 7 + size.n_cells() / 8);
    bytes.extend(learned.fingerprint());
    bytes.extend((size.width as u32).to_le_bytes());
    bytes.extend((size.height as u32).to_le_bytes());
    bytes.extend(raster.resolution_m().to_le_bytes());
    raster.corner().iter().for_each(|number| bytes.extend(number.to_le_bytes()));
    bytes.extend(memory.n_visits.to_le_bytes());
    bytes.extend((memory.cells.len() as u32).to_le_bytes());
    for (index, cell) in &memory.cells {
        bytes.extend((*index as u32).to_le_bytes());
        let learned = match cell.learned {
            None => 0,
            Some(Verdict::Occupied) => 1,
            Some(Verdict::Free) => 2,
        };
        bytes.extend([learned, cell.occupied_visits, cell.free_visits]);
    }
    let bit = |(place, is_set): (usize, &bool)| u8::from(*is_set) << place;
    let bits = memory.was_met.chunks(8).map(|cells| cells.iter().enumerate().map(bit).sum::<u8>());
    bytes.extend(bits);
    Seal::close(bytes)
}

/// What these bytes remember, and the map that has come of it: `raster` is the map that was saved with them, or any earlier
/// one of the same visits.
///
/// # Errors
/// Why the bytes are not that.
pub fn memory_of(bytes: &[u8], raster: &Raster) -> Result<(Memory, Raster), MemoryFault> {
    let rest = SEAL.open(bytes)?;
    let (place, memory) = parts(rest).ok_or(MemoryFault::Damaged)?;
    let mut learned = raster.clone();
    memory.apply(&mut learned);
    let is_same_map = raster.is_at(place.size, place.resolution_m, place.corner)
        && learned.fingerprint().as_slice() == place.fingerprint;
    if is_same_map { Ok((memory, learned)) } else { Err(MemoryFault::OtherMap) }
}

/// The map that it belongs to.
struct Place<'b> {
    fingerprint: &'b [u8],
    size: GridSize,
    resolution_m: f64,
    corner: [f64; 3],
}

/// What stands between version and checksum; none where it does not hold together.
fn parts(mut rest: Reader<'_>) -> Option<(Place<'_>, Memory)> {
    let fingerprint = rest.take(32)?;
    let size = GridSize::new(rest.u32()? as usize, rest.u32()? as usize);
    let n_cells = size.width.checked_mul(size.height)?;
    let resolution_m = rest.f64()?;
    let corner = [rest.f64()?, rest.f64()?, rest.f64()?];
    let n_visits = rest.u32()?;
    let mut memory = Memory { n_visits, ..Memory::default() };
    let mut least = 0;
    for _ in 0..rest.u32()? {
        let index = rest.u32()? as usize;
        let [learned, occupied_visits, free_visits] = rest.chunk()?;
        let learned = match learned {
            0 => None,
            1 => Some(Verdict::Occupied),
            2 => Some(Verdict::Free),
            _ => return None,
        };
        let cell = CellMemory { learned, occupied_visits, free_visits };
        let is_sound = (least..n_cells).contains(&index) && cell != CellMemory::default();
        if !is_sound || (occupied_visits > 0 && free_visits > 0) {
            return None;
        }
        least = index + 1;
        memory.cells.insert(index, cell);
    }
    let bits = rest.take(n_cells.div_ceil(8))?;
    memory.was_met =
        (0..n_cells).map(|cell| bits.get(cell / 8).is_some_and(|bits| bits >> (cell % 8) & 1 == 1)).collect();
    rest.is_empty().then_some((Place { fingerprint, size, resolution_m, corner }, memory))
}

#[cfg(test)]
mod tests;
