//! The mean of the last three fixes: Valverde Moreno (2015), section 4.2.2.
//!
//! The newest fix alone until there are three. Nothing moves it on between fixes, so that it lags behind a robot that
//! drives: at 1.2 m/s and a fix a second by 1.2 m. Differs from the source in what follows an outage: fixes of before it
//! are forgotten, and the variance grows with the way that the robot may have gone meanwhile.

use nalgebra::Vector2;
use rumbo_core::time::{Span, Time};

/// So many fixes make a mean.
pub const N_FIXES: usize = 3;

/// Where the robot is on average.
#[derive(Debug, Clone, PartialEq)]
pub struct Mean3 {
    /// Of the base, oldest first, with variances.
    fixes: Vec<(Vector2<f64>, f64)>,
    newest: Option<Time>,
    /// Before the first fix: what somebody named, with its variance.
    start: Option<(Vector2<f64>, f64)>,
    max_speed_m_s: f64,
    outage: Span,
}

impl Mean3 {
    /// For a robot that is at most so fast; fixes that are older than `outage` when a new one comes are forgotten.
    pub fn new(start: Option<(Vector2<f64>, f64)>, max_speed_m_s: f64, outage: Span) -> Mean3 {
        Mean3 { fixes: Vec::with_capacity(N_FIXES + 1), newest: None, start, max_speed_m_s, outage }
    }

    /// A fix of the base at a time, and its variance along each axis.
    pub fn take_fix(&mut self, stamp: Time, base_m: Vector2<f64>, variance_m2: f64) {
        if self.newest.is_some_and(|newest| stamp - newest > self.outage) {
            self.fixes.clear();
        }
        self.fixes.push((base_m, variance_m2));
        if self.fixes.len() > N_FIXES {
            self.fixes.remove(0);
        }
        self.newest = Some(self.newest.map_or(stamp, |newest| newest.max(stamp)));
    }

    /// Position and variance along each axis at a time.
    pub fn position(&self, now: Time) -> Option<(Vector2<f64>, f64)> {
        let (position_m, variance_m2) = match self.fixes.as_slice() {
            [] => self.start?,
            all @ [_, _, _] => {
                let n = N_FIXES as f64;
                let sum = all.iter().fold((Vector2::zeros(), 0.0), |sum, fix| (sum.0 + fix.0, sum.1 + fix.1));
                (sum.0 / n, sum.1 / (n * n))
            }
            [.., newest] => *newest,
        };
        // From a start that somebody named on, nothing says when that was: the robot stood there until now.
        let age_s = self.newest.map_or(0.0, |newest| (now - newest).as_secs().max(0.0));
        Some((position_m, variance_m2 + (self.max_speed_m_s * age_s).powi(2)))
    }
}
