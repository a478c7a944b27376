//! The real device: a thread owns its port, and the sensor takes what has come.

mod laser_scan;
mod worker;

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use rumbo_core::stages::SensorError;
use rumbo_core::time::{Span, Time};
use rumbo_kit::wall_clock::WallClock;

use super::driver::{DeviceScan, Settings};
pub(super) use laser_scan::Interpretation;

/// Scans that wait for the sensor to be polled; the oldest go first. More than the device gives in three seconds.
const MOST_WAITING: usize = 256;

/// After so long without scans the sensor does not only say so once, but fails each time that it is asked: the run ends,
/// if nobody mends it. Finding a device that was unplugged takes less.
const PATIENCE: Span = Span(10_000_000_000);

/// A device at a port.
#[derive(Debug)]
pub(super) struct Live {
    address: String,
    /// Since the port was first opened: what only the thread and this sensor know of.
    clock: WallClock,
    shared: Arc<Shared>,
    worker: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Shared {
    shall_stop: AtomicBool,
    news: Mutex<News>,
}

#[derive(Debug, Default)]
struct News {
    scans: VecDeque<DeviceScan>,
    /// Why no scans come; nothing while they do.
    trouble: Option<Trouble>,
}

#[derive(Debug, Clone)]
struct Trouble {
    since: Time,
    reason: String,
    is_told: bool,
}

impl News {
    /// Why no scans come.
    fn note(&mut self, now: Time, reason: String) {
        match &mut self.trouble {
            Some(trouble) if trouble.reason == reason => {}
            Some(trouble) => (trouble.reason, trouble.is_told) = (reason, false),
            None => self.trouble = Some(Trouble { since: now, reason, is_told: false }),
        }
    }

    /// What the sensor has to say about it now.
    fn complaint(&mut self, now: Time) -> Option<String> {
        let trouble = self.trouble.as_mut()?;
        let is_due = !std::mem::replace(&mut trouble.is_told, true) || now - trouble.since > PATIENCE;
        is_due.then(|| trouble.reason.clone())
    }
}

impl Shared {
    fn news(&self) -> MutexGuard<'_, News> {
        // Nothing is left half done in there when somebody panics.
        self.news.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Live {
    /// Starts the thread, which opens the port as often as needed. Addresses are those of `port` in the pipeline.
    pub fn start(address: &str, settings: Settings) -> Self {
        let (shared, clock) = (Arc::new(Shared::default()), WallClock::start());
        let (theirs, there) = (shared.clone(), address.to_owned());
        let worker = std::thread::spawn(move || worker::work(&there, &settings, clock, &theirs));
        Self { address: address.to_owned(), clock, shared, worker: Some(worker) }
    }

    /// Gives all scans that have come to `take`, oldest first, each with how long ago it was measured.
    pub fn drain(&self, mut take: impl FnMut(&DeviceScan, Span)) -> Result<(), SensorError> {
        let now = self.clock.now();
        let (scans, complaint) = {
            let mut news = self.shared.news();
            (std::mem::take(&mut news.scans), news.complaint(now))
        };
        scans.iter().for_each(|scan| take(scan, now - scan.measured_at));
        match complaint {
            Some(reason) if scans.is_empty() => {
                Err(SensorError::Device { device: self.address.clone(), reason })
            }
            _ => Ok(()),
        }
    }
}

impl Drop for Live {
    fn drop(&mut self) {
        self.shared.shall_stop.store(true, Ordering::Relaxed);
        if let Some(worker) = self.worker.take() {
            // Should it have panicked, then there is nothing left to stop.
            let _ = worker.join();
        }
    }
}

#[cfg(test)]
mod tests;
