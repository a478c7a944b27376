//! What people should know about the base.

/// What happened to the connection, or to the base.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LinkEvent {
    /// It answers.
    #[error("the base {name} answers")]
    Found {
        /// Its name.
        name: String,
    },
    /// It does not answer any more.
    #[error("the base is lost: {reason}; it stops by itself, and is looked for")]
    Lost {
        /// What is known.
        reason: String,
    },
    /// Somebody pressed the emergency stop, or let it go.
    #[error("{}", if *is_pressed {
        "the emergency stop of the base is pressed: no motor runs"
    } else {
        "the emergency stop of the base is released: it drives on"
    })]
    Emergency {
        /// It is pressed now.
        is_pressed: bool,
    },
    /// The battery is nearly empty.
    #[error("the battery of the base is low: {:.1} V", f64::from(*millivolts) / 1e3)]
    BatteryLow {
        /// Its voltage.
        millivolts: u32,
    },
    /// No command came in time.
    #[error("the base has stopped by itself: commands came too late")]
    StoppedByItself,
}
