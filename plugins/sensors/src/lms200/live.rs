//! The real device: a thread owns its port, and the sensor takes what has come.

mod laser_scan;
mod worker;

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread::JoinHandle;

use rumbo_core::stages::SensorError;
use rumbo_core::time::Span;
use rumbo_kit::wall_clock::WallClock;

use super::driver::{DeviceScan, Settings};
use crate::live_news::Shared;
pub(super) use laser_scan::Interpretation;

/// A device at a port.
#[derive(Debug)]
pub(super) struct Live {
    address: String,
    /// Since the port was first opened: what only the thread and this sensor know of.
    clock: WallClock,
    shared: Arc<Shared<DeviceScan>>,
    worker: Option<JoinHandle<()>>,
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
            (news.take(), news.complaint(now))
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
