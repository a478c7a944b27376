//! Maps as bytes. Tiles that several maps share are written once, and shared again when they are read.

use super::TileMap;
use super::level::TileLevel;
use super::tile::{N_CELLS, Tile};
use rumbo_core::seal::Reader;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Writes and reads the maps of one state, in the same order.
#[derive(Debug, Default)]
pub struct TileCode {
    /// Tiles written so far, by level, place and version.
    written: BTreeMap<(u32, [i64; 2], u64), u32>,
    read: Vec<Arc<Tile>>,
}

/// A tile that has not been written before.
const NEW: u32 = u32::MAX;
/// No map is larger, tiles along an edge.
const MOST_TILES: i64 = 1 << 20;

impl TileCode {
    /// Adds a map.
    pub fn write(&mut self, map: &TileMap, bytes: &mut Vec<u8>) {
        bytes.extend((map.levels().len() as u32).to_le_bytes());
        bytes.extend(map.finest().map_or(1.0, TileLevel::resolution_m).to_le_bytes());
        bytes.extend(map.finest().map_or(1.0, TileLevel::unit).to_le_bytes());
        for (k, level) in (0u32..).zip(map.levels()) {
            bytes.extend((level.tiles().count() as u32).to_le_bytes());
            for (place, tile) in level.tiles() {
                place.iter().for_each(|v| bytes.extend(v.to_le_bytes()));
                let key = (k, place, tile.version);
                if let Some(number) = self.written.get(&key) {
                    bytes.extend(number.to_le_bytes());
                    continue;
                }
                self.written.insert(key, self.written.len() as u32);
                bytes.extend(NEW.to_le_bytes());
                bytes.extend(tile.version.to_le_bytes());
                bytes.extend(tile.cells.iter().map(|cell| *cell as u8));
            }
        }
    }

    /// The next map; none where the bytes are not one.
    pub fn read(&mut self, rest: &mut Reader<'_>) -> Option<TileMap> {
        let (n_levels, resolution_m) = (rest.u32()?, rest.f64()?);
        let unit = f32::from_le_bytes(rest.chunk()?);
        let is_length = |v: f64| v.is_finite() && v > 0.0;
        let is_sound = (1..=16).contains(&n_levels) && is_length(resolution_m) && is_length(unit.into());
        let mut map = is_sound.then(|| TileMap::of_unit(resolution_m, n_levels, unit))?;
        for level in map.levels_mut() {
            for _ in 0..rest.u32()? {
                let place = [rest.i64()?, rest.i64()?];
                if place.iter().any(|v| v.abs() > MOST_TILES) {
                    return None;
                }
                let number = rest.u32()?;
                let tile = if number == NEW {
                    self.read_tile(rest)?
                } else {
                    self.read.get(number as usize)?.clone()
                };
                level.put(place, tile);
            }
        }
        Some(map)
    }

    fn read_tile(&mut self, rest: &mut Reader<'_>) -> Option<Arc<Tile>> {
        let mut tile = Tile { version: u64::from_le_bytes(rest.chunk()?), ..Tile::unknown() };
        for (cell, byte) in tile.cells.iter_mut().zip(rest.take(N_CELLS)?) {
            *cell = *byte as i8;
        }
        let tile = Arc::new(tile);
        self.read.push(Arc::clone(&tile));
        Some(tile)
    }
}
