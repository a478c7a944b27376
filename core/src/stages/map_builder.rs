//! A map builder fills the layers that it declares, in place, and keeps no handle on the map.

use super::Cx;
use crate::map::{GridFault, Map};
use crate::messages::{Estimate, Seen};

/// Turns what was seen, and from where, into map layers.
pub trait MapBuilder: Send {
    /// Prepares its layers: loads them, or makes empty ones.
    fn start(&mut self, map: &mut Map) -> Result<(), MapError>;

    /// Adds what was seen. Runs last in a step, after the localizer has used the map.
    fn insert(&mut self, cx: &mut Cx<'_>, input: &MapInput<'_>, map: &mut Map) -> Result<(), MapError>;

    /// Asked when somebody saves the map: brings what only a whole visit tells into `map`, which is what will be saved, and
    /// gives what must be kept beside it until the next visit; no bytes are as good as `None`. May be asked again;
    /// the builder itself goes on as if nobody had.
    fn save(&self, _map: &mut Map) -> Result<Option<Vec<u8>>, MapError> {
        Ok(None)
    }
}

/// What a map builder gets.
#[derive(Debug, Clone, Copy)]
pub struct MapInput<'a> {
    /// Observations since this builder last ran.
    pub seen: Seen<'a>,
    /// Where the robot is.
    pub estimate: &'a Estimate,
}

/// Why there is no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// A file cannot be read.
    #[error("cannot read the map {path}: {reason}")]
    File {
        /// The file.
        path: String,
        /// What is wrong with it, and what would be right.
        reason: String,
    },
    /// A grid that cannot be.
    #[error(transparent)]
    Grid(#[from] GridFault),
    /// A layer that this builder works on is not there.
    #[error("the map has no {layer} layer; name a map builder that gives it before this one")]
    MissingLayer {
        /// The layer.
        layer: &'static str,
    },
    /// Anything else.
    #[error("{0}")]
    Other(String),
}
