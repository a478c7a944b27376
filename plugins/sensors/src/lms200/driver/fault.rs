//! What goes wrong, and how often.

/// What happened so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Scans delivered.
    pub n_scans: u64,
    /// Whole scans that came when none were wanted: while the device was looked for or set up.
    pub n_ignored_scans: u64,
    /// Telegrams with a wrong checksum.
    pub n_checksum_failures: u64,
    /// Bytes that belong to no telegram.
    pub n_discarded_bytes: u64,
    /// Telegrams with a right checksum and no meaning.
    pub n_unknown: u64,
    /// Telegrams of ours that the device refused.
    pub n_refused: u64,
    /// Pauses of more than three expected periods between scans.
    pub n_gaps: u64,
    /// How often the connection began anew.
    pub n_restarts: u64,
    /// Telegrams that told of a dirty window.
    pub n_polluted: u64,
    /// Telegrams that told of implausible values.
    pub n_implausible: u64,
    /// Telegrams that told of an error.
    pub n_errors: u64,
}

/// Why an attempt failed.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DriverFault {
    /// At no speed.
    #[error("nothing answers at any speed; is the device switched on, and is this its port?")]
    NotFound,
    /// Bytes came, and no telegram among them.
    #[error(
        "something else answers: bytes come, but no telegram at any speed; is this the port of another device, or are \
         the two data lines swapped?"
    )]
    SomethingElse,
    /// No answer to a command.
    #[error("the device does not answer {step}")]
    NoAnswer {
        /// What was asked.
        step: &'static str,
    },
    /// The device says no.
    #[error("the device refuses {step}")]
    Refused {
        /// What was asked.
        step: &'static str,
    },
    /// The installation mode has another password than the factory's.
    #[error("the device has another password than the factory's, so unit and measuring mode cannot be set")]
    Password,
    /// It woke up anew.
    #[error("the device has restarted")]
    Restarted,
    /// It sends something else than it was told.
    #[error("the device sends scans of another kind than it was told to")]
    OtherScans,
    /// No scans for five seconds.
    #[error("no scan for 5 s; is the cable plugged in?")]
    Silent,
}
