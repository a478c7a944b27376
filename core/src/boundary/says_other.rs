//! What a stage says where the plugin says nothing of its own.

use crate::stages::{AvoidError, BuildError, LocalizeError, MapError, PlanError, SensorError, SlamError};

/// An error that a panic on the plugin's side leaves, or that the poisoned instance answers from then on.
pub(super) trait SaysOther {
    /// As the stage's "anything else".
    fn other(message: String) -> Self;
}

macro_rules! says_other {
    ($($error:ident),*) => { $(
        impl SaysOther for $error {
            fn other(message: String) -> Self {
                $error::Other(message)
            }
        }
    )* };
}
says_other!(PlanError, LocalizeError, SlamError, MapError, AvoidError, SensorError);

impl SaysOther for BuildError {
    fn other(message: String) -> Self {
        BuildError::at("", message)
    }
}
