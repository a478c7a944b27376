//! Holds a simulation back to a multiple of real time.

use rumbo_core::engine::{Observer, StepView};
use rumbo_core::time::Time;
use std::time::{Duration, Instant};

/// Sleeps after each step until the wall clock has caught up.
pub struct Pace {
    speed: f64,
    start: Option<(Instant, Time)>,
}

impl Pace {
    /// `speed` times real time.
    pub fn new(speed: f64) -> Pace {
        Pace { speed, start: None }
    }
}

impl Observer for Pace {
    fn on_step(&mut self, view: &StepView<'_>) {
        let (clock, first) = *self.start.get_or_insert((Instant::now(), view.now));
        let due_s = (view.now - first).as_secs() / self.speed;
        let due = Duration::try_from_secs_f64(due_s).unwrap_or(Duration::ZERO);
        std::thread::sleep(due.saturating_sub(clock.elapsed()));
    }
}
