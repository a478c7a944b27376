//! A sensor owns the device's truth: geometry, resolution, range, noise, dropouts, wire protocol.

use super::{Cx, World, WorldError};
use crate::messages::{MessageFault, Observations, Seen};

/// Turns what the world answers into observations.
#[doc(alias = "driver")]
pub trait Sensor: Send {
    /// Reads what is there now and puts it into `out`; never blocks. Nothing new is no error.
    fn poll(
        &mut self,
        cx: &mut Cx<'_>,
        world: &mut dyn World,
        out: &mut Observations,
    ) -> Result<(), SensorError>;

    /// As [`poll`](Self::poll) for a *virtual* sensor, one with `inputs`: `inputs` is what those sensors saw since this
    /// one last ran. A sensor that is not virtual needs no body here.
    fn derive(
        &mut self,
        cx: &mut Cx<'_>,
        inputs: Seen<'_>,
        out: &mut Observations,
    ) -> Result<(), SensorError> {
        let _ = (cx, inputs, out);
        Err(SensorError::NotVirtual)
    }
}

/// Why a sensor has nothing to give.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SensorError {
    /// The world cannot answer this sensor's probe.
    #[error(transparent)]
    World(#[from] WorldError),
    /// The world answered, but not what was asked.
    #[error("the world answered {found} to a probe for {expected}")]
    WrongAnswer {
        /// What was asked for.
        expected: &'static str,
        /// What came back.
        found: &'static str,
    },
    /// The device does not answer.
    #[error("no answer from {device}: {reason}")]
    Device {
        /// Port or address.
        device: String,
        /// What happened.
        reason: String,
    },
    /// A number that must not go on.
    #[error(transparent)]
    Message(#[from] MessageFault),
    /// This sensor has `inputs` but makes nothing of them.
    #[error("this sensor does not derive anything from `inputs`; remove the key or name a virtual sensor")]
    NotVirtual,
    /// Anything else.
    #[error("{0}")]
    Other(String),
}
