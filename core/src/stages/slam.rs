//! One plugin in the seats of map builder and localizer at once.

use super::Cx;
use crate::map::Map;
use crate::messages::{Estimate, MessageFault, Prior, Seen};

/// Builds the map and finds the robot in it at the same time.
pub trait Slam: Send {
    /// Begins anew from what is known now, and prepares its layers.
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError>;

    /// Takes in everything since the last update, and writes the layers that it declares.
    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError>;

    /// Its whole state, to continue from later as `Prior::Saved`.
    fn save(&self) -> Result<Vec<u8>, SlamError> {
        Err(SlamError::CannotSave)
    }
}

/// Why there is no estimate and no map.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SlamError {
    /// It cannot start from this prior.
    #[error("cannot start from {prior}; this plugin needs {needs}")]
    Prior {
        /// What it was given.
        prior: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// It has no saved form.
    #[error("this plugin cannot save its state")]
    CannotSave,
    /// A number that must not go on.
    #[error(transparent)]
    Message(#[from] MessageFault),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}
