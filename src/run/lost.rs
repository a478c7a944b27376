//! When a stage does not come back: what was recorded is kept, and the process ends, since its thread cannot.

use crate::exit::Exit;
use crate::recording::RunRecording;
use crate::terminal::Terminal;
use rumbo_core::engine::{EndReason, Lost, Observer, RunEnd, StepView, on_lost};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A recording that another thread can close.
#[derive(Clone, Default)]
pub struct Kept(Arc<Mutex<Option<RunRecording>>>);

impl Kept {
    /// Keeps this one, if there is one.
    pub fn new(recording: Option<RunRecording>) -> Kept {
        Kept(Arc::new(Mutex::new(recording)))
    }

    /// Hands it out.
    pub fn take(&self) -> Option<RunRecording> {
        self.lock().take()
    }

    fn lock(&self) -> MutexGuard<'_, Option<RunRecording>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Observer for Kept {
    fn on_step(&mut self, view: &StepView<'_>) {
        if let Some(recording) = self.lock().as_mut() {
            recording.on_step(view);
        }
    }
}

/// From now on a stage that does not come back ends this process; a recording is closed before.
pub fn end_when_lost(kept: Kept, terminal: Terminal) {
    on_lost(move |lost| {
        if let Some(recording) = kept.take() {
            let end = end_of(lost);
            match recording.cut_off(&end) {
                Ok(_) => terminal.say("the recording has everything up to the step that does not end"),
                Err(error) => terminal.error(&format!("the recording is incomplete: {error}")),
            }
        }
        terminal.error(&lost.to_string());
        std::process::exit(Exit::NoSuccess.code().into());
    });
}

fn end_of(lost: &Lost) -> RunEnd {
    RunEnd { reason: EndReason::Stalled, detail: Some(lost.to_string()) }
}
