//! The thread that owns the port to the base.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use rumbo_core::time::{Span, Time};
use rumbo_kit::port::{Port, keep_open};
use rumbo_kit::wall_clock::WallClock;

use super::link::Link;

/// Between attempts to open a port.
const REOPEN: Duration = Duration::from_millis(500);
/// The base gets this long to say that it has stopped.
const MOST_FAREWELL: Span = Span(500_000_000);

/// A connection with its thread, until this is dropped.
#[derive(Debug)]
pub(super) struct Connection {
    shared: Arc<Shared>,
    clock: WallClock,
    worker: Option<JoinHandle<()>>,
}

#[derive(Debug)]
struct Shared {
    link: Mutex<Link>,
    shall_stop: AtomicBool,
}

impl Shared {
    fn link(&self) -> MutexGuard<'_, Link> {
        // Nothing is left half done in there when somebody panics.
        self.link.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Connection {
    /// Starts the thread, which opens the port as often as needed.
    pub fn start(address: &str, baud: u32) -> Self {
        let clock = WallClock::start();
        let link = Mutex::new(Link::new(clock.now()));
        let shared = Arc::new(Shared { link, shall_stop: AtomicBool::new(false) });
        let (theirs, there) = (Arc::clone(&shared), address.to_owned());
        let worker = std::thread::spawn(move || work(&there, baud, clock, &theirs));
        Self { shared, clock, worker: Some(worker) }
    }

    /// The connection as it is now, and the time on its clock.
    pub fn now(&self) -> (MutexGuard<'_, Link>, Time) {
        let link = self.shared.link();
        (link, self.clock.now())
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.shared.shall_stop.store(true, Ordering::Relaxed);
        if let Some(worker) = self.worker.take() {
            // Should it have panicked, then there is nothing left to stop: the base does so by itself.
            let _ = worker.join();
        }
    }
}

fn work(address: &str, baud: u32, clock: WallClock, shared: &Shared) {
    let trouble = |reason| shared.link().without_port(clock.now(), reason);
    keep_open(address, baud, REOPEN, &shared.shall_stop, |port| serve(port, clock, shared), trouble);
}

/// Until it shall stop or the port is gone.
fn serve(mut port: Port, clock: WallClock, shared: &Shared) -> std::io::Result<()> {
    let (mut buffer, mut farewell_ends_at) = ([0u8; 1024], None);
    loop {
        let out = {
            let (mut link, now) = (shared.link(), clock.now());
            if farewell_ends_at.is_none() && shared.shall_stop.load(Ordering::Relaxed) {
                link.leave();
                farewell_ends_at = Some(now + MOST_FAREWELL);
            }
            link.tick(now);
            let out = link.take_out();
            if out.is_empty() && (link.is_left() || farewell_ends_at.is_some_and(|end| now >= end)) {
                return Ok(());
            }
            out
        };
        port.send(&out)?;
        let n_bytes = port.receive(&mut buffer)?;
        let mut link = shared.link();
        link.receive(clock.now(), buffer.get(..n_bytes).unwrap_or_default());
    }
}
