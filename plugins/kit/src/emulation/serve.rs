//! The thread that lets a device live at its outlet.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;

use rumbo_core::time::Time;

use super::{EmulatedDevice, LineFaults, Outlet};

/// The time it is, from whoever may read a clock.
pub type Clock = Arc<dyn Fn() -> Time + Send + Sync>;

/// A device at its outlet, until this is dropped.
#[derive(Debug)]
pub struct Served {
    address: String,
    shall_stop: Arc<AtomicBool>,
    n_overruns: Arc<AtomicU64>,
    worker: Option<JoinHandle<()>>,
}

impl Served {
    /// Lets the device live on a thread of its own.
    pub fn start(
        outlet: Outlet,
        device: Box<dyn EmulatedDevice>,
        faults: LineFaults,
        clock: Clock,
    ) -> std::io::Result<Self> {
        let (address, shall_stop) = (outlet.address(), Arc::new(AtomicBool::new(false)));
        let (theirs, n_overruns) = (Arc::clone(&shall_stop), Arc::new(AtomicU64::new(0)));
        let line = Line { outlet, device, faults, n_overruns: Arc::clone(&n_overruns) };
        let work = move || line.serve(&clock, &theirs);
        let worker = std::thread::Builder::new().name("emulated device".to_owned()).spawn(work)?;
        Ok(Self { address, shall_stop, n_overruns, worker: Some(worker) })
    }

    /// What a host opens.
    pub fn address(&self) -> &str {
        &self.address
    }

    /// How often the host did not take in time what was sent, and lost bytes by it.
    pub fn n_overruns(&self) -> u64 {
        self.n_overruns.load(Ordering::Relaxed)
    }

    /// It lives: its thread has not panicked.
    pub fn is_alive(&self) -> bool {
        self.worker.as_ref().is_some_and(|worker| !worker.is_finished())
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        self.shall_stop.store(true, Ordering::Relaxed);
        if let Some(worker) = self.worker.take() {
            // Should it have panicked, then there is nothing left to stop.
            let _ = worker.join();
        }
    }
}

struct Line {
    outlet: Outlet,
    device: Box<dyn EmulatedDevice>,
    faults: LineFaults,
    n_overruns: Arc<AtomicU64>,
}

impl Line {
    fn serve(mut self, clock: &Clock, shall_stop: &AtomicBool) {
        let (mut buffer, mut bytes) = ([0u8; 1024], Vec::new());
        let mut was_unplugged = false;
        while !shall_stop.load(Ordering::Relaxed) {
            let n_bytes = self.outlet.receive(&mut buffer);
            let (now, baud) = (clock(), self.outlet.baud());
            let is_unplugged = self.faults.is_unplugged(now);
            if is_unplugged && !was_unplugged {
                self.outlet.hang_up();
            }
            was_unplugged = is_unplugged;
            bytes.clear();
            bytes.extend_from_slice(buffer.get(..n_bytes.unwrap_or(0)).unwrap_or_default());
            self.faults.befall(&mut bytes);
            if !is_unplugged && !bytes.is_empty() {
                self.device.receive(now, baud, &bytes);
            }
            bytes.clear();
            self.device.transmit(now, baud, &mut bytes);
            self.faults.befall(&mut bytes);
            // Without a plug, or without a host at the other end, what is sent goes nowhere.
            if !is_unplugged && n_bytes.is_some() && self.outlet.send(&bytes) > 0 {
                self.n_overruns.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

#[cfg(test)]
mod tests;
