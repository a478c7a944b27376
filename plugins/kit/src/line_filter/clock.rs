//! Real clocks: readings come with their stamps, not exactly periodic, and some come late.

use super::schedule::Schedule;
use rumbo_core::time::{Span, Time};

/// Who measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    /// The wheels.
    Wheels,
    /// The steered wheel.
    Steering,
    /// A laser.
    Laser,
}

/// How to go on to a reading.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Steps {
    /// Steps.
    pub n: u32,
    /// Of so many seconds each.
    pub seconds: f64,
}

impl Steps {
    /// The time of all steps, seconds.
    pub fn all_s(&self) -> f64 {
        f64::from(self.n) * self.seconds
    }
}

/// What to do with a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Instant {
    /// Go on to it, then take it in.
    Ahead(Steps),
    /// It is older than the state by no more than may be: take it in as it is.
    Slightly,
    /// It is too old: drop it.
    Late,
    /// Its sensor is not due: leave it out.
    NotDue,
}

/// The time of the state.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    /// Periods that the readings are thinned to, nanoseconds, and the schedule of them; none takes all readings in.
    schedule: Option<(Schedule, [i64; 3])>,
    /// Readings that are older than the state by more than this are dropped.
    late: Span,
    now: Option<Time>,
    start: Time,
    /// The last period of each sensor from which a reading was taken in.
    taken: [Option<i64>; 3],
}

/// Share of a period by which a reading may be early and still belong to it.
const EARLY: f64 = 0.02;

impl Clock {
    /// A clock that takes in every reading, unless it is late by more than `late`.
    pub fn new(late: Span) -> Clock {
        Clock { schedule: None, late, now: None, start: Time::ZERO, taken: [None; 3] }
    }

    /// A clock for sensors with these periods (wheels, steering, laser): one reading a period each, predictions in steps
    /// of the base period.
    pub fn scheduled(late: Span, schedule: Schedule, periods_ns: [i64; 3]) -> Clock {
        Clock { schedule: Some((schedule, periods_ns)), ..Clock::new(late) }
    }

    /// The time of the state; none before the first reading.
    pub fn now(&self) -> Option<Time> {
        self.now
    }

    /// The first reading.
    pub fn start(&self) -> Time {
        self.start
    }

    /// Goes on from a state of this time.
    pub fn resume(&mut self, start: Time, now: Option<Time>) {
        (self.start, self.now, self.taken) = (start, now, [None; 3]);
        if let (Some((_, periods_ns)), Some(now)) = (&self.schedule, now) {
            self.taken = periods_ns.map(|period| Some(period_of((now - start).0, period)));
        }
    }

    /// What to do with a reading of this stamp. The clock goes on to it.
    pub fn admit(&mut self, source: Source, stamp: Time) -> Instant {
        let now = *self.now.get_or_insert_with(|| {
            self.start = stamp;
            stamp
        });
        let ahead_ns = (stamp - now).0;
        if ahead_ns < 0 && -ahead_ns > self.late.0 {
            return Instant::Late;
        }
        if let Some((_, periods_ns)) = &self.schedule {
            let which = match source {
                Source::Wheels => 0,
                Source::Steering => 1,
                Source::Laser => 2,
            };
            let period = period_of((stamp - self.start).0, periods_ns[which]);
            if self.taken[which].is_some_and(|taken| period <= taken) {
                return Instant::NotDue;
            }
            self.taken[which] = Some(period);
        }
        if ahead_ns <= 0 {
            return Instant::Slightly;
        }
        self.now = Some(stamp);
        let step_ns = self.schedule.as_ref().and_then(|(schedule, _)| schedule.step_ns()).unwrap_or(ahead_ns);
        // A stamp that is a hair beside its step is not worth a step of its own.
        let n_steps = (ahead_ns as f64 / step_ns as f64 - EARLY).ceil().max(1.0);
        Instant::Ahead(Steps { n: n_steps as u32, seconds: (stamp - now).as_secs() / n_steps })
    }
}

/// In which period since the start a reading is.
fn period_of(since_ns: i64, period_ns: i64) -> i64 {
    let early_ns = (period_ns as f64 * EARLY) as i64;
    (since_ns + early_ns).div_euclid(period_ns)
}
