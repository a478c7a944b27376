//! Ends a run whose step does not: outside the step, so that it can change no result.

use crate::stages::GiveUp;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};
use std::thread::JoinHandle;
use std::time::Duration;

#[derive(Default)]
struct Shared {
    fed: AtomicU64,
    barked: AtomicBool,
    over: Mutex<bool>,
    wake: Condvar,
}

/// Waits beside the run for a step that takes too long.
pub(super) struct Watchdog {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Watchdog {
    /// Wall time that one step may take.
    pub const PATIENCE: Duration = Duration::from_secs(30);

    /// Watches from now on; raises `abort` where it loses patience.
    pub fn start(abort: GiveUp) -> Watchdog {
        Watchdog::with_patience(abort, Self::PATIENCE)
    }

    fn with_patience(abort: GiveUp, patience: Duration) -> Watchdog {
        let shared = Arc::new(Shared::default());
        let theirs = shared.clone();
        let thread = std::thread::spawn(move || watch(&theirs, &abort, patience));
        Watchdog { shared, thread: Some(thread) }
    }

    /// A step is done. Returns whether the watchdog had lost patience.
    pub fn feed(&self) -> bool {
        self.shared.fed.fetch_add(1, Ordering::Relaxed);
        self.shared.barked.load(Ordering::Relaxed)
    }
}

fn watch(shared: &Shared, abort: &GiveUp, patience: Duration) {
    let Ok(mut over) = shared.over.lock() else { return };
    while !*over {
        let before = shared.fed.load(Ordering::Relaxed);
        let Ok((guard, timeout)) = shared.wake.wait_timeout_while(over, patience, |over| !*over) else {
            return;
        };
        over = guard;
        if timeout.timed_out() && shared.fed.load(Ordering::Relaxed) == before {
            shared.barked.store(true, Ordering::Relaxed);
            return abort.raise();
        }
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        if let Ok(mut over) = self.shared.over.lock() {
            *over = true;
        }
        self.shared.wake.notify_all();
        if let Some(thread) = self.thread.take() {
            // The watching thread runs no code that can panic.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_never_ends_by_itself_is_told_to_give_up() {
        let abort = GiveUp::default();
        let watchdog = Watchdog::with_patience(abort.clone(), Duration::from_millis(5));
        while !abort.is_raised() {
            std::thread::yield_now();
        }
        assert!(watchdog.feed());
    }

    #[test]
    fn a_run_that_ends_takes_its_watchdog_along() {
        let watchdog = Watchdog::start(GiveUp::default());
        assert!(!watchdog.feed());
    }
}
