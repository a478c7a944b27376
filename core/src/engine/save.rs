//! The map as it is saved.

use super::localization::Finder;
use super::step::Engine;
use crate::map::Map;
use crate::stages::{MapError, SlamError};

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
    /// Name of the section of the builder or of `[slam]`.
    pub section: String,
    /// What it says.
    pub error: MapError,
}

impl Engine {
    /// The map as it is to be saved, and what belongs beside it. The run itself goes on with the map that it has.
    ///
    /// # Errors
    /// The first of `[slam]` and the builders that cannot.
    pub fn save_map(&self) -> Result<SavedMap, SaveError> {
        let (mut map, mut kept) = (self.slam_map()?, Vec::new());
        for seat in &self.builders {
            let saved = seat.stage.save(&mut map);
            let saved = saved.map_err(|error| SaveError { section: seat.name.clone(), error })?;
            kept.extend(saved.map(|bytes| (seat.name.clone(), bytes)));
        }
        Ok(SavedMap { map, kept })
    }

    /// The map as `[slam]` knows it now, from the same poses as [`Engine::trajectory`]; without `[slam]` the run's own.
    ///
    /// # Errors
    /// When it cannot.
    pub fn slam_map(&self) -> Result<Map, SaveError> {
        let (mut map, seat) = (self.map.clone(), &self.localization.finder);
        if let Finder::Slam { slam, .. } = &seat.stage {
            let failed = |error: SlamError| MapError::Other(error.to_string());
            let saved = slam.save_map(&mut map).map_err(failed);
            saved.map_err(|error| SaveError { section: seat.name.clone(), error })?;
        }
        Ok(map)
    }
}
