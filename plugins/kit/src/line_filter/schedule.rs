//! Sensors of several rates on one clock (section 2.6 of the source): the base period is the greatest common divisor.

/// Below this the filter does not run at the base period, but from one measurement to the next, nanoseconds.
const SHORTEST_BASE_NS: i64 = 1_000_000;

/// When which sensor is due.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Schedule {
    periods_ns: Vec<i64>,
    base_ns: i64,
}

/// A period that is none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a period of {found_ns} ns, expected at least one nanosecond")]
pub struct ScheduleFault {
    /// The period.
    pub found_ns: i64,
}

impl Schedule {
    /// The schedule of sensors with these periods.
    ///
    /// # Errors
    /// There is no sensor, or a period is not positive.
    pub fn new(periods_ns: &[i64]) -> Result<Schedule, ScheduleFault> {
        if let Some(found_ns) = periods_ns.iter().copied().find(|period| *period <= 0) {
            return Err(ScheduleFault { found_ns });
        }
        let base_ns = periods_ns.iter().copied().fold(0, common_divisor);
        if base_ns == 0 {
            return Err(ScheduleFault { found_ns: 0 });
        }
        Ok(Schedule { periods_ns: periods_ns.to_vec(), base_ns })
    }

    /// The base period, nanoseconds (T).
    pub fn base_ns(&self) -> i64 {
        self.base_ns
    }

    /// Longest prediction at once, nanoseconds; none where the base period is too short to step by.
    pub fn step_ns(&self) -> Option<i64> {
        (self.base_ns >= SHORTEST_BASE_NS).then_some(self.base_ns)
    }

    /// The first moment after this one at which the filter runs.
    pub fn next_ns(&self, after_ns: i64) -> i64 {
        let next = |period: i64| (after_ns.div_euclid(period) + 1) * period;
        match self.step_ns() {
            Some(step) => next(step),
            None => self.periods_ns.iter().map(|period| next(*period)).min().unwrap_or(after_ns),
        }
    }

    /// This sensor is due at this moment (k mod r_s = 0).
    pub fn is_due(&self, sensor: usize, at_ns: i64) -> bool {
        self.periods_ns.get(sensor).is_some_and(|period| at_ns.rem_euclid(*period) == 0)
    }
}

/// Euclid.
fn common_divisor(mut a: i64, mut b: i64) -> i64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}
