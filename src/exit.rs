//! How the command ends.

use std::process::ExitCode;

/// What the caller of the command is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exit {
    /// It worked.
    Success,
    /// It ran, without success.
    NoSuccess,
    /// The input has faults.
    Faults,
    /// The command itself failed.
    Internal,
    /// Somebody asked to stop.
    Interrupted,
}

impl Exit {
    /// The number that the operating system passes on.
    pub fn code(self) -> u8 {
        match self {
            Exit::Success => 0,
            Exit::NoSuccess => 1,
            Exit::Faults => 2,
            Exit::Internal => 3,
            // What shells expect after an interrupt: 128 and the number of the signal.
            Exit::Interrupted => 130,
        }
    }
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit.code())
    }
}

/// Why a verb could not do its work.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// The input has faults, and this says which.
    #[error("{0}")]
    Usage(String),
    /// The command itself failed.
    #[error("{0}")]
    Internal(String),
    /// The input has faults; they have been shown.
    #[error("the faults above")]
    Told(Exit),
    /// Standard output was closed.
    #[error("standard output is closed")]
    NobodyReads,
}

impl Failure {
    /// How the command ends.
    pub fn exit(&self) -> Exit {
        match self {
            Failure::Usage(_) => Exit::Faults,
            Failure::Internal(_) => Exit::Internal,
            Failure::Told(exit) => *exit,
            Failure::NobodyReads => Exit::Success,
        }
    }
}
