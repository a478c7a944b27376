//! A real device that talks by itself in lines of text: a thread owns its port, and the sensor takes what has come.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::{Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use rumbo_core::stages::SensorError;
use rumbo_core::time::{Span, Time};
use rumbo_kit::port::{Port, keep_open};
use rumbo_kit::wall_clock::WallClock;

use crate::live_news::Shared;

/// Between attempts to open a port.
const REOPEN: Duration = Duration::from_secs(1);
/// A device that talks by itself is not silent for so long.
const LONGEST_SILENCE: Span = Span(3_000_000_000);

/// Makes readings of bytes.
pub(crate) trait TextDecoder: Send + 'static {
    /// What a line of the device says.
    type Reading: Send + 'static;
    /// What became of all lines.
    type Tally: Copy + Default + Send + 'static;

    /// Takes bytes in, however they are cut.
    fn push(&mut self, bytes: &[u8]);
    /// The line is lost.
    fn break_off(&mut self);
    /// The next reading.
    fn next(&mut self) -> Option<Self::Reading>;
    /// All lines so far.
    fn tally(&self) -> Self::Tally;
    /// Of bytes that come without readings: what they are instead.
    fn instead(&self) -> String;
}

/// A device at a port.
pub(crate) struct TextDevice<D: TextDecoder> {
    address: String,
    /// Since the port was first opened: what only the thread and this sensor know of.
    clock: WallClock,
    shared: Arc<Shared<(Time, D::Reading)>>,
    tally: Arc<Mutex<D::Tally>>,
    worker: Option<JoinHandle<()>>,
}

impl<D: TextDecoder> std::fmt::Debug for TextDevice<D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("TextDevice").field("address", &self.address).finish_non_exhaustive()
    }
}

impl<D: TextDecoder> TextDevice<D> {
    /// Starts the thread, which opens the port as often as needed. Addresses are those of `port` in the pipeline.
    pub fn start(address: &str, baud: u32, mut decoder: D) -> Self {
        let (shared, clock) = (Arc::new(Shared::default()), WallClock::start());
        let tally = Arc::new(Mutex::new(D::Tally::default()));
        let (theirs, their_tally, there) = (Arc::clone(&shared), Arc::clone(&tally), address.to_owned());
        let worker = std::thread::spawn(move || {
            let mut line = Line { decoder: &mut decoder, clock, shared: &theirs, tally: &their_tally };
            let serve = |port| line.serve(port);
            let trouble = |reason| theirs.news().note(clock.now(), reason);
            keep_open(&there, baud, REOPEN, &theirs.shall_stop, serve, trouble);
        });
        Self { address: address.to_owned(), clock, shared, tally, worker: Some(worker) }
    }

    /// Gives all readings that have come to `take`, oldest first, each with how long ago it came.
    pub fn drain(&self, mut take: impl FnMut(D::Reading, Span)) -> Result<(), SensorError> {
        let now = self.clock.now();
        let (readings, complaint) = {
            let mut news = self.shared.news();
            (news.take(), news.complaint(now))
        };
        let is_silent = readings.is_empty();
        readings.into_iter().for_each(|(came_at, reading)| take(reading, now - came_at));
        match complaint {
            Some(reason) if is_silent => Err(SensorError::Device { device: self.address.clone(), reason }),
            _ => Ok(()),
        }
    }

    /// All lines so far.
    pub fn tally(&self) -> D::Tally {
        *self.tally.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<D: TextDecoder> Drop for TextDevice<D> {
    fn drop(&mut self) {
        self.shared.shall_stop.store(true, Ordering::Relaxed);
        if let Some(worker) = self.worker.take() {
            // Should it have panicked, then there is nothing left to stop.
            let _ = worker.join();
        }
    }
}

/// The thread's side.
struct Line<'a, D: TextDecoder> {
    decoder: &'a mut D,
    clock: WallClock,
    shared: &'a Shared<(Time, D::Reading)>,
    tally: &'a Mutex<D::Tally>,
}

impl<D: TextDecoder> Line<'_, D> {
    /// Until it shall stop or the port is gone.
    fn serve(&mut self, mut port: Port) -> std::io::Result<()> {
        let mut buffer = [0u8; 1024];
        let (mut last_reading, mut has_bytes) = (self.clock.now(), false);
        while !self.shared.shall_stop.load(Ordering::Relaxed) {
            let received = port.receive(&mut buffer);
            let now = self.clock.now();
            match &received {
                Ok(n_bytes) => self.decoder.push(buffer.get(..*n_bytes).unwrap_or_default()),
                Err(_) => self.decoder.break_off(),
            }
            let has_readings = self.deliver(now);
            let n_bytes = received?;
            has_bytes |= n_bytes > 0;
            if has_readings {
                (last_reading, has_bytes) = (now, false);
            } else if now - last_reading > LONGEST_SILENCE {
                self.shared.news().note(now, self.complaint(has_bytes));
            }
        }
        Ok(())
    }

    fn deliver(&mut self, now: Time) -> bool {
        let mut has_readings = false;
        while let Some(reading) = self.decoder.next() {
            has_readings = true;
            self.shared.news().deliver((now, reading));
        }
        *self.tally.lock().unwrap_or_else(PoisonError::into_inner) = self.decoder.tally();
        has_readings
    }

    fn complaint(&self, has_bytes: bool) -> String {
        if has_bytes {
            let instead = self.decoder.instead();
            format!("something else talks there: {instead}; is this the device, and `baud` its speed?")
        } else {
            "nothing comes; is the device switched on?".to_owned()
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
