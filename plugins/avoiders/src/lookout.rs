//! What an avoider does first: checks its input, and takes in what was seen since the last time.

use crate::near_points::{NearPoints, NearTuning};
use rumbo_core::frames::{Pose2, flatten, is_finite2};
use rumbo_core::messages::{Check, MessageFault};
use rumbo_core::stages::{AvoidError, AvoidInput};
use rumbo_core::time::Time;

/// Everything near, kept up to date.
#[derive(Debug)]
pub struct Lookout {
    /// What is near.
    pub near: NearPoints,
}

impl Lookout {
    /// The robot's velocity explains where it was at most this long ago, seconds.
    const OLDEST_S: f64 = 1.0;

    /// Nothing seen yet.
    pub fn new(tuning: NearTuning) -> Lookout {
        Lookout { near: NearPoints::new(tuning) }
    }

    /// Takes in what was seen; the base in the odometer's frame.
    pub fn look(&mut self, now: Time, input: &AvoidInput<'_>) -> Result<Pose2, AvoidError> {
        if !is_finite2(&input.map_from_base) {
            let found = format!("{}", input.map_from_base);
            let (message, field, expected) = ("avoid_input", "map_from_base", "finite numbers");
            return Err(MessageFault { message, field, found, expected }.into());
        }
        input.twist.check()?;
        let odom_from_base = flatten(&input.estimate.map_from_odom).inverse() * input.map_from_base;
        for observation in input.seen.iter() {
            let age_s = (now - observation.stamp).as_secs().clamp(0.0, Self::OLDEST_S);
            self.near.see(observation, &(odom_from_base * input.twist.integrate(-age_s)));
        }
        self.near.settle(now, &odom_from_base);
        Ok(odom_from_base)
    }
}
