//! Ends a run whose step does not: outside the step, so that it can change no result.
//!
//! First it asks: it raises `give_up`, which long computations look at. A stage that ignores it cannot be ended, since
//! no thread can end another; then it tells whom the program named ([`on_lost`]), who can end the process.

use super::at_work::AtWork;
use crate::stages::GiveUp;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError, RwLock};
use std::thread::JoinHandle;
use std::time::Duration;

/// How long a stage may take, in wall time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepLimits {
    /// For one step; then it is asked to give up.
    pub step: Duration,
    /// To obey; then the stage is lost.
    pub obey: Duration,
}

impl Default for StepLimits {
    fn default() -> Self {
        StepLimits { step: Duration::from_secs(30), obey: Duration::from_secs(5) }
    }
}

/// A stage that does not come back, and did not give up either.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{who} does not come back: it was asked to give up after {} s and did not obey for {} s more; a stage must return, and \
     a planner must look at `give_up`", limits.step.as_secs_f32(), limits.obey.as_secs_f32()
)]
pub struct Lost {
    /// The stage, its plugin and where that comes from.
    pub who: String,
    /// How long it was waited for.
    pub limits: StepLimits,
}

type Listener = Box<dyn Fn(&Lost) + Send + Sync>;
static LISTENER: RwLock<Option<Listener>> = RwLock::new(None);

/// From now on `listener` is told of every stage that does not come back, on a thread of its own. The thread of the run
/// is lost: the listener saves what is to be saved and ends the process. Where nobody listens, the run waits for ever.
pub fn on_lost(listener: impl Fn(&Lost) + Send + Sync + 'static) {
    *LISTENER.write().unwrap_or_else(PoisonError::into_inner) = Some(Box::new(listener));
}

fn tell(lost: &Lost) {
    let slot = LISTENER.read().unwrap_or_else(PoisonError::into_inner);
    if let Some(listener) = slot.as_ref() {
        listener(lost);
    }
}

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
    /// Watches from now on; raises `abort` where it loses patience.
    pub fn start(abort: GiveUp, at_work: Arc<AtWork>, limits: StepLimits) -> Watchdog {
        let shared = Arc::new(Shared::default());
        let theirs = shared.clone();
        let thread = std::thread::spawn(move || watch(&theirs, &abort, &at_work, limits));
        Watchdog { shared, thread: Some(thread) }
    }

    /// A step begins: what was before it does not count.
    pub fn begin(&self) {
        self.shared.fed.fetch_add(1, Ordering::Relaxed);
    }

    /// A step is done. Returns whether the watchdog had lost patience.
    pub fn feed(&self) -> bool {
        self.shared.fed.fetch_add(1, Ordering::Relaxed);
        self.shared.barked.load(Ordering::Relaxed)
    }
}

fn watch(shared: &Shared, abort: &GiveUp, at_work: &AtWork, limits: StepLimits) {
    let Ok(mut over) = shared.over.lock() else { return };
    while !*over {
        let before = shared.fed.load(Ordering::Relaxed);
        let Ok((guard, timeout)) = shared.wake.wait_timeout_while(over, limits.step, |over| !*over) else {
            return;
        };
        over = guard;
        // Between two steps observers may take their time: one of them may pace the run.
        let is_working = at_work.who().is_some();
        if !timeout.timed_out() || !is_working || shared.fed.load(Ordering::Relaxed) != before {
            continue;
        }
        shared.barked.store(true, Ordering::Relaxed);
        abort.raise();
        let Ok((guard, timeout)) = shared.wake.wait_timeout_while(over, limits.obey, |over| !*over) else {
            return;
        };
        drop(guard);
        if let Some(who) = at_work.who()
            && timeout.timed_out()
            && shared.fed.load(Ordering::Relaxed) == before
        {
            tell(&Lost { who: who.to_owned(), limits });
        }
        return;
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        *self.shared.over.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.shared.wake.notify_all();
        if let Some(thread) = self.thread.take() {
            // A listener that panics has told already.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::at_work::Place;
    use super::*;
    use std::sync::mpsc::channel;

    fn at_work(place: Place) -> Arc<AtWork> {
        let names = ["", "world `w` of here", "", "", "", "planner `p` of there"];
        let at_work = AtWork::named(names.map(str::to_owned).to_vec(), 0);
        at_work.enter(place);
        Arc::new(at_work)
    }

    const SHORT: StepLimits = StepLimits { step: Duration::from_millis(5), obey: Duration::from_millis(5) };

    #[test]
    fn a_step_that_never_ends_by_itself_is_told_to_give_up_and_a_deaf_stage_is_named() {
        let (sender, receiver) = channel();
        on_lost(move |lost| sender.send(lost.to_string()).unwrap());
        let abort = GiveUp::default();
        let watchdog = Watchdog::start(abort.clone(), at_work(Place::Planner), SHORT);
        let told = receiver.recv().unwrap();
        assert!(told.starts_with("planner `p` of there does not come back"), "{told}");
        assert!(abort.is_raised() && watchdog.feed());
    }

    #[test]
    fn nobody_is_asked_to_hurry_between_two_steps() {
        let abort = GiveUp::default();
        let watchdog = Watchdog::start(abort.clone(), at_work(Place::Nobody), SHORT);
        std::thread::sleep(Duration::from_millis(60));
        assert!(!abort.is_raised() && !watchdog.feed());
    }

    #[test]
    fn a_run_that_ends_takes_its_watchdog_along() {
        let watchdog = Watchdog::start(GiveUp::default(), at_work(Place::World), StepLimits::default());
        assert!(!watchdog.feed());
    }
}
