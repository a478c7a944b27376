//! Errors of the stages as status codes with a place, numbers and words, and back into the same variants.

mod plan_error;

use super::abi::*;
use super::convert::{cut_into, text_in};
use super::words::intern;
use crate::frames::Point2;
use crate::stages::{AvoidError, BuildError, LocalizeError, MapError, SensorError, SlamError};
use std::ffi::c_char;

impl rumbo_error {
    /// No error.
    pub(super) fn none() -> rumbo_error {
        rumbo_error {
            size: size_of::<rumbo_error>(),
            place: rumbo_point::default(),
            values: [0.0; 2],
            path: [0; 256],
            text: [0; 512],
            message: [0; 1024],
            help: [0; 512],
        }
    }

    /// Forgets what was in it.
    pub(super) fn clear(&mut self) {
        self.place = rumbo_point::default();
        self.values = [0.0; 2];
        for first in [&mut self.path[..], &mut self.text, &mut self.message, &mut self.help] {
            first[..1].fill(0 as c_char);
        }
    }

    pub(super) fn message(&self) -> String {
        text_in(&self.message)
    }

    /// What was said, or that nothing was said.
    pub(super) fn words(&self, code: i32) -> String {
        let message = self.message();
        if message.is_empty() { format!("failed with status {code} and said nothing") } else { message }
    }

    fn noun(&self) -> &'static str {
        intern(&text_in(&self.text))
    }

    fn point(&self) -> Point2 {
        Point2::new(self.place.x_m, self.place.y_m)
    }

    pub(super) fn say(&mut self, message: &str) {
        cut_into(&mut self.message, message);
    }
}

/// An error of a stage that crosses the boundary.
pub(super) trait Crosses: std::fmt::Display {
    /// Its code; fills in what the code asks for, but for the message.
    fn code(&self, error: &mut rumbo_error) -> i32;
    /// From a code and what came with it.
    fn from_code(code: i32, error: &rumbo_error) -> Self;

    /// Writes the error for the other side.
    fn cross(&self, error: &mut rumbo_error) -> i32 {
        error.clear();
        error.say(&self.to_string());
        self.code(error)
    }
}

fn reason(e: &rumbo_error, code: i32) -> String {
    let text = text_in(&e.text);
    if text.is_empty() { e.words(code) } else { text }
}

impl Crosses for LocalizeError {
    fn code(&self, e: &mut rumbo_error) -> i32 {
        match self {
            LocalizeError::Prior { prior, needs } => {
                cut_into(&mut e.path, prior);
                cut_into(&mut e.text, needs);
                RUMBO_BAD_PRIOR
            }
            LocalizeError::MissingLayer { layer } => {
                cut_into(&mut e.text, layer);
                RUMBO_MISSING_LAYER
            }
            LocalizeError::NotStarted => RUMBO_NOT_STARTED,
            LocalizeError::NeedsMotion { wish } => {
                cut_into(&mut e.text, wish);
                RUMBO_NEEDS_MOTION
            }
            LocalizeError::Message(_) | LocalizeError::Other(_) => RUMBO_ERROR,
        }
    }

    fn from_code(code: i32, e: &rumbo_error) -> LocalizeError {
        match code {
            RUMBO_BAD_PRIOR => LocalizeError::Prior { prior: prior(e), needs: e.noun() },
            RUMBO_MISSING_LAYER => LocalizeError::MissingLayer { layer: e.noun() },
            RUMBO_NOT_STARTED => LocalizeError::NotStarted,
            RUMBO_NEEDS_MOTION => LocalizeError::NeedsMotion { wish: reason(e, code) },
            _ => LocalizeError::Other(e.words(code)),
        }
    }
}

fn prior(e: &rumbo_error) -> &'static str {
    let prior = text_in(&e.path);
    if prior.is_empty() { "what it was told" } else { intern(&prior) }
}

impl Crosses for SlamError {
    fn code(&self, e: &mut rumbo_error) -> i32 {
        match self {
            SlamError::Prior { prior, needs } => {
                cut_into(&mut e.path, prior);
                cut_into(&mut e.text, needs);
                RUMBO_BAD_PRIOR
            }
            SlamError::CannotRelocate => RUMBO_CANNOT_RELOCATE,
            SlamError::CannotSave => RUMBO_CANNOT_SAVE,
            SlamError::Message(_) | SlamError::Other(_) => RUMBO_ERROR,
        }
    }

    fn from_code(code: i32, e: &rumbo_error) -> SlamError {
        match code {
            RUMBO_BAD_PRIOR => SlamError::Prior { prior: prior(e), needs: e.noun() },
            RUMBO_CANNOT_RELOCATE => SlamError::CannotRelocate,
            RUMBO_CANNOT_SAVE => SlamError::CannotSave,
            _ => SlamError::Other(e.words(code)),
        }
    }
}

impl Crosses for MapError {
    fn code(&self, e: &mut rumbo_error) -> i32 {
        match self {
            MapError::File { path, reason } => {
                cut_into(&mut e.path, path);
                cut_into(&mut e.text, reason);
                RUMBO_MAP_FILE
            }
            MapError::MissingLayer { layer } => {
                cut_into(&mut e.text, layer);
                RUMBO_MISSING_LAYER
            }
            MapError::Grid(_) | MapError::Other(_) => RUMBO_ERROR,
        }
    }

    fn from_code(code: i32, e: &rumbo_error) -> MapError {
        match code {
            RUMBO_MAP_FILE => MapError::File { path: text_in(&e.path), reason: reason(e, code) },
            RUMBO_MISSING_LAYER => MapError::MissingLayer { layer: e.noun() },
            _ => MapError::Other(e.words(code)),
        }
    }
}

impl Crosses for AvoidError {
    fn code(&self, e: &mut rumbo_error) -> i32 {
        match self {
            AvoidError::NoReading { kind, age_s } => {
                cut_into(&mut e.text, kind);
                e.values = [*age_s, 0.0];
                RUMBO_NO_READING
            }
            AvoidError::Message(_) | AvoidError::Other(_) => RUMBO_ERROR,
        }
    }

    fn from_code(code: i32, e: &rumbo_error) -> AvoidError {
        match code {
            RUMBO_NO_READING => AvoidError::NoReading { kind: e.noun(), age_s: e.values[0] },
            _ => AvoidError::Other(e.words(code)),
        }
    }
}

impl Crosses for SensorError {
    fn code(&self, e: &mut rumbo_error) -> i32 {
        match self {
            SensorError::Device { device, reason } => {
                cut_into(&mut e.path, device);
                cut_into(&mut e.text, reason);
                RUMBO_DEVICE
            }
            SensorError::NotVirtual => RUMBO_NOT_VIRTUAL,
            SensorError::World(_)
            | SensorError::WrongAnswer { .. }
            | SensorError::Message(_)
            | SensorError::Other(_) => RUMBO_ERROR,
        }
    }

    fn from_code(code: i32, e: &rumbo_error) -> SensorError {
        match code {
            RUMBO_DEVICE => SensorError::Device { device: text_in(&e.path), reason: reason(e, code) },
            RUMBO_NOT_VIRTUAL => SensorError::NotVirtual,
            _ => SensorError::Other(e.words(code)),
        }
    }
}

impl Crosses for BuildError {
    fn code(&self, e: &mut rumbo_error) -> i32 {
        cut_into(&mut e.path, &self.path);
        cut_into(&mut e.help, self.help.as_deref().unwrap_or_default());
        RUMBO_BAD_CONFIG
    }

    fn from_code(code: i32, e: &rumbo_error) -> BuildError {
        let error = BuildError::at(text_in(&e.path), e.words(code));
        let help = text_in(&e.help);
        if help.is_empty() { error } else { error.help(help) }
    }
}
