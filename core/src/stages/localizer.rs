//! A localizer says where the robot is.

use super::Cx;
use crate::map::Map;
use crate::messages::{Estimate, MessageFault, Prior, Seen};

/// Turns what was seen and the map into an estimate.
#[doc(alias = "amcl")]
pub trait Localizer: Send {
    /// Begins anew from what is known now.
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError>;

    /// Takes in everything since the last update. `map` is as the step before left it.
    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError>;
}

/// Why there is no estimate.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LocalizeError {
    /// It cannot start from this prior.
    #[error("cannot start from {prior}; this localizer needs {needs}")]
    Prior {
        /// What it was given.
        prior: &'static str,
        /// What it needs.
        needs: &'static str,
    },
    /// The map lacks a layer.
    #[error("the map has no {layer} layer")]
    MissingLayer {
        /// The layer.
        layer: &'static str,
    },
    /// It was asked for an estimate before it was started.
    #[error("the localizer was not started")]
    NotStarted,
    /// A number that must not go on.
    #[error(transparent)]
    Message(#[from] MessageFault),
    /// It can only go on if the robot moves, and this world does not drive.
    #[error("needs the robot to move ({wish}), but this world cannot drive; use a simulation or a robot")]
    NeedsMotion {
        /// What it wished for.
        wish: String,
    },
    /// Anything else.
    #[error("{0}")]
    Other(String),
}
