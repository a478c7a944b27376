//! When an avoider is asked, and what it told the wheels last.

use crate::wheels::Wheels;
use rumbo_core::frames::Twist;
use rumbo_core::robot::Robot;
use rumbo_core::stages::Steering;
use rumbo_core::time::Time;

/// The last call.
#[derive(Debug, Clone, Copy, Default)]
pub struct Pulse {
    last: Twist,
    called: Option<Time>,
    period_s: f64,
}

impl Pulse {
    /// The first call, and one after a long silence, count as this long, seconds.
    const USUAL_S: f64 = 0.05;
    /// A longer time between two calls is a silence, in which the robot came to a stop, seconds.
    const SILENCE_S: f64 = 1.0;

    /// The avoider is asked.
    pub fn beat(&mut self, now: Time) {
        let period_s =
            self.called.map(|called| (now - called).as_secs()).filter(|s| *s > 0.0 && *s < Self::SILENCE_S);
        if period_s.is_none() {
            self.last = Twist::ZERO;
        }
        self.period_s = period_s.unwrap_or(Self::USUAL_S);
        self.called = Some(now);
    }

    /// The wheels as they were told last.
    pub fn wheels<'a>(&self, robot: &'a Robot) -> Wheels<'a> {
        Wheels { robot, last: self.last, period_s: self.period_s }
    }

    /// The avoider answers.
    pub fn answer(&mut self, steering: Steering, robot: &Robot) -> Steering {
        // Told to stand, the wheels roll on until the brakes have done it.
        self.last = match steering {
            Steering::Drive(twist) if twist != Twist::ZERO => twist,
            _ => self.wheels(robot).braked(),
        };
        steering
    }
}
