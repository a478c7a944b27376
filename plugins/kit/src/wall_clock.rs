//! The clock of the wall, for what is real: devices, and worlds that run by themselves.

use std::time::{Duration, Instant};

use rumbo_core::time::Time;

/// Time since it was made.
#[derive(Debug, Clone, Copy)]
pub struct WallClock {
    began: Instant,
}

impl WallClock {
    /// Begins now.
    pub fn start() -> Self {
        Self { began: Instant::now() }
    }

    /// Time since then.
    pub fn now(self) -> Time {
        Time(i64::try_from(self.began.elapsed().as_nanos()).unwrap_or(i64::MAX))
    }

    /// Waits until it is so late; a time that is over is not waited for.
    pub fn sleep_until(self, to: Time) {
        let left_ns = (to - self.now()).0;
        if left_ns > 0 {
            std::thread::sleep(Duration::from_nanos(left_ns.unsigned_abs()));
        }
    }
}
