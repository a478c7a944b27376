//! One plugin in the seats of map builder and localizer at once.

use super::Cx;
use crate::map::Map;
use crate::messages::{Estimate, MessageFault, Prior, Seen, StampedPose};

/// Builds the map and finds the robot in it at the same time.
pub trait Slam: Send {
    /// Begins anew from what is known now, and prepares its layers: whatever was in them is gone. With `Prior::Saved` it
    /// goes on from what it saved, with its map and the robot where it was; the odometer may have begun anew since then.
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError>;

    /// Takes in everything since the last update, and writes the layers that it declares. It is asked whatever it said
    /// before: a SLAM that says `Status::Lost` goes on looking.
    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError>;

    /// Somebody says where the robot is in the map that was built so far, or with `Prior::Unknown` that it may be
    /// anywhere in it. The map stays. A pose is where the next match begins, and is used only once; nothing is to be
    /// concluded on the way between the places before and after, since the robot may have been carried. After an error
    /// it goes on as if nobody had said anything.
    #[doc(alias = "initialpose")]
    fn relocate(&mut self, _prior: &Prior, _map: &mut Map) -> Result<(), SlamError> {
        Err(SlamError::CannotRelocate)
    }

    /// Where the robot was at all scans, as it is known now (after loops were closed, or in the best of several
    /// hypotheses), oldest first; empty where the plugin does not keep it.
    #[doc(alias = "nav_msgs/Path")]
    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        Ok(Vec::new())
    }

    /// Nobody will ask for the [`Slam::trajectory`], nor save a state that has it: what is kept for that alone is dropped from
    /// now on, so that a long run needs no more memory than a short one. Nothing else changes; who needs the trajectory to
    /// close loops keeps it. Asked before the first update, and stays so through every `start`.
    fn keep_no_trajectory(&mut self) {}

    /// Brings its layers of a map that somebody wants to save to what is known now: drawn from the poses of
    /// [`Slam::trajectory`], where the map that it works with lags behind them. That map stays.
    fn save_map(&self, _map: &mut Map) -> Result<(), SlamError> {
        Ok(())
    }

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
    /// It cannot be told where the robot is once it has begun.
    #[error("this plugin cannot be told where the robot is once it has a map; it goes on with what it knows")]
    CannotRelocate,
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
