//! The commands between finding the device and its first scan.

use rumbo_core::time::Span;

use super::{Command, Configuration, Mode, Settings};
use crate::lms200::protocol::FACTORY_PASSWORD;

/// A command that waits for its answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Step {
    Status,
    Type,
    AskSpeed,
    ConfirmSpeed,
    ReadConfiguration,
    Install(Configuration),
    Write(Configuration),
    Leave,
    Variant,
    Start,
}

impl Step {
    pub fn command(&self, settings: &Settings) -> Command {
        match self {
            Self::Status | Self::ConfirmSpeed => Command::Status,
            Self::Type => Command::Type,
            Self::AskSpeed => Command::Switch(Mode::Speed(settings.speed)),
            Self::ReadConfiguration => Command::ReadConfiguration,
            Self::Install(_) => Command::Switch(Mode::Installation(FACTORY_PASSWORD)),
            Self::Write(configuration) => Command::WriteConfiguration(configuration.clone()),
            Self::Leave => Command::Switch(Mode::OnRequest),
            Self::Variant => Command::Variant(settings.variant),
            Self::Start if settings.partials => Command::Switch(Mode::Partials),
            Self::Start => Command::Switch(Mode::Continuous),
        }
    }

    /// How long the device may take: writing takes long because it goes to an EEPROM, mode changes up to 3 s.
    pub fn budget(&self) -> Span {
        match self {
            Self::Write(_) => Span(15_000_000_000),
            Self::Install(_) | Self::Leave | Self::Variant | Self::Start => Span(3_000_000_000),
            _ => Span(1_000_000_000),
        }
    }

    pub fn name(&self) -> &'static str {
        match self {
            Self::Status => "a request for its status",
            Self::Type => "a request for its type",
            Self::AskSpeed => "a change of the line's speed",
            Self::ConfirmSpeed => "at the new speed of the line",
            Self::ReadConfiguration => "a request for its configuration",
            Self::Install(_) => "the password for installation mode",
            Self::Write(_) => "a new configuration",
            Self::Leave => "the end of installation mode",
            Self::Variant => "a change of field of view and resolution",
            Self::Start => "the start of continuous output",
        }
    }
}
