//! The map as it is saved.

use super::step::Engine;
use crate::map::Map;
use crate::stages::MapError;

/// A map to be saved.
#[derive(Debug, Clone, PartialEq)]
pub struct SavedMap {
    /// The map, with what only a whole visit tells.
    pub map: Map,
    /// What map builders keep beside it until the next visit, each with the builder's name.
    pub kept: Vec<(String, Vec<u8>)>,
}

/// A map builder cannot save.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{section}: {error}")]
pub struct SaveError {
    /// Name of the builder's section.
    pub section: String,
    /// What it says.
    pub error: MapError,
}

impl Engine {
    /// The map as it is to be saved, and what belongs beside it. The run itself goes on with the map that it has.
    ///
    /// # Errors
    /// The first builder that cannot.
    pub fn save_map(&self) -> Result<SavedMap, SaveError> {
        let (mut map, mut kept) = (self.map.clone(), Vec::new());
        for seat in &self.builders {
            let saved = seat.stage.save(&mut map);
            let saved = saved.map_err(|error| SaveError { section: seat.name.clone(), error })?;
            kept.extend(saved.map(|bytes| (seat.name.clone(), bytes)));
        }
        Ok(SavedMap { map, kept })
    }
}
