//! The last step before the world, which no plugin passes.
//!
//! Finite numbers only; speeds and accelerations that the robot can do; a stop when data is old, a stage failed, or an
//! obstacle is inside the stopping distance. Every intervention is an event, said once when it begins.

use super::events::{Event, EventKind, Intervention};
use super::stop_zone::StopZone;
use crate::frames::{Pose2, Twist};
use crate::messages::{Observation, SensorId};
use crate::robot::Robot;
use crate::time::{Span, Time};
use std::sync::Arc;

/// A source whose age the guard watches.
#[derive(Debug)]
struct Watched {
    sensor: SensorId,
    newest: Option<Time>,
}

/// Limits every command.
#[derive(Debug)]
pub struct Guard {
    robot: Arc<Robot>,
    zone: StopZone,
    watched: Vec<Watched>,
    stale_after: Span,
    period: Span,
    started: Option<Time>,
    last: Twist,
    last_stamp: Option<Time>,
    ongoing: [bool; Intervention::ALL.len()],
}

/// What the guard needs to know beside the command.
#[derive(Debug, Clone, Copy)]
pub struct Situation {
    /// The time it is.
    pub now: Time,
    /// The odometer.
    pub odom_from_base: Pose2,
    /// A stage failed in this step.
    pub stage_failed: bool,
    /// This step began more than a control period too late.
    pub deadline_missed: bool,
}

impl Guard {
    /// Rounding of a limit is no intervention.
    const TOLERANCE: f64 = 1e-6;

    /// A guard for this robot that is asked every `period`; the sensors in `watched` must stay fresh.
    pub fn new(robot: Arc<Robot>, period: Span, watched: &[SensorId]) -> Guard {
        Guard {
            zone: StopZone::new(&robot),
            watched: watched.iter().map(|sensor| Watched { sensor: *sensor, newest: None }).collect(),
            stale_after: Span::from_secs(robot.guard.stale_after_s),
            period,
            robot,
            started: None,
            last: Twist::ZERO,
            last_stamp: None,
            ongoing: [false; Intervention::ALL.len()],
        }
    }

    /// Takes in what a sensor saw; `odom_from_base` is where the base was then.
    pub fn see(&mut self, observation: &Observation, odom_from_base: &Pose2) {
        if let Some(watched) =
            self.watched.iter_mut().find(|w| w.sensor == observation.sensor && observation.valid)
        {
            watched.newest = watched.newest.max(Some(observation.stamp));
        }
        if observation.valid {
            self.zone.see(observation, odom_from_base);
        }
    }

    /// The command that may go to the wheels.
    pub fn limit(&mut self, wanted: Twist, situation: &Situation, events: &mut Vec<Event>) -> Twist {
        let now = situation.now;
        self.started.get_or_insert(now);
        let mut found = [false; Intervention::ALL.len()];
        let mut note = |intervention: Intervention| found[intervention as usize] = true;
        let mut twist = wanted;
        if !twist.is_finite() {
            note(Intervention::NotFinite);
            twist = Twist::ZERO;
        }
        if situation.stage_failed {
            note(Intervention::StageFailed);
            twist = Twist::ZERO;
        }
        if situation.deadline_missed {
            note(Intervention::Deadline);
            twist = Twist::ZERO;
        }
        if twist != Twist::ZERO && self.is_stale(now) {
            note(Intervention::Stale);
            twist = Twist::ZERO;
        }
        let feasible = self.robot.drive.feasible(twist);
        if differs(feasible, twist) {
            note(Intervention::Infeasible);
        }
        let slow = self.slow_enough(feasible);
        if differs(slow, feasible) {
            note(Intervention::TooFast);
        }
        let smooth = self.smooth(slow, now);
        let safe = if self.robot.guard.stop_zone {
            self.zone.limit(smooth, &self.robot, &situation.odom_from_base)
        } else {
            smooth
        };
        if differs(safe, smooth) {
            note(Intervention::StopZone);
        }
        (self.last, self.last_stamp) = (safe, Some(now));
        self.report(now, found, events);
        safe
    }

    fn report(&mut self, now: Time, found: [bool; Intervention::ALL.len()], events: &mut Vec<Event>) {
        for (intervention, begins) in Intervention::ALL.into_iter().zip(found) {
            let ongoing = &mut self.ongoing[intervention as usize];
            if begins && !*ongoing {
                events.push(Event { stamp: now, kind: EventKind::Guard(intervention) });
            }
            *ongoing = begins;
        }
    }

    fn is_stale(&self, now: Time) -> bool {
        self.watched.iter().any(|w| now - w.newest.or(self.started).unwrap_or(now) > self.stale_after)
    }

    /// The whole twist scaled down, so that the curvature stays.
    fn slow_enough(&self, twist: Twist) -> Twist {
        let by_speed = self.robot.max_speed_m_s / twist.speed_m_s().max(1e-12);
        let by_turn = self.robot.max_turn_rad_s() / twist.turn_rad_s.abs().max(1e-12);
        let factor = by_speed.min(by_turn);
        if factor < 1.0 - Self::TOLERANCE { twist.scaled(factor) } else { twist }
    }

    /// As much of the change as the accelerations allow; braking may use the brakes.
    fn smooth(&self, wanted: Twist, now: Time) -> Twist {
        let seconds = self.last_stamp.map_or(self.period, |last| now - last).as_secs().max(0.0);
        if wanted == Twist::ZERO {
            return self.braked(seconds);
        }
        let slows = wanted.speed_m_s() < self.last.speed_m_s();
        let brakes_m_s2 = self.robot.braking_m_s2.max(self.robot.max_accel_m_s2);
        let accel_m_s2 = if slows { brakes_m_s2 } else { self.robot.max_accel_m_s2 };
        let (forward, left) =
            (wanted.forward_m_s - self.last.forward_m_s, wanted.left_m_s - self.last.left_m_s);
        let turn_change = (wanted.turn_rad_s - self.last.turn_rad_s).abs();
        let by_speed = accel_m_s2 * seconds / forward.hypot(left).max(1e-12);
        let by_turn = self.robot.max_turn_accel_rad_s2() * seconds / turn_change.max(1e-12);
        let part = by_speed.min(by_turn);
        if part >= 1.0 {
            return wanted;
        }
        Twist {
            forward_m_s: self.last.forward_m_s + forward * part,
            left_m_s: self.last.left_m_s + left * part,
            turn_rad_s: self.last.turn_rad_s + (wanted.turn_rad_s - self.last.turn_rad_s) * part,
        }
    }

    /// A stop, as hard as the brakes are: a slow turn must not delay it.
    fn braked(&self, seconds: f64) -> Twist {
        let brakes_m_s2 = self.robot.braking_m_s2.max(self.robot.max_accel_m_s2);
        let left = |speed: f64, slowing: f64| (1.0 - slowing * seconds / speed.abs().max(1e-12)).max(0.0);
        let straight = left(self.last.speed_m_s(), brakes_m_s2);
        let turn = left(self.last.turn_rad_s, self.robot.max_turn_accel_rad_s2());
        Twist {
            forward_m_s: self.last.forward_m_s * straight,
            left_m_s: self.last.left_m_s * straight,
            turn_rad_s: self.last.turn_rad_s * turn,
        }
    }
}

fn differs(a: Twist, b: Twist) -> bool {
    let far = |x: f64, y: f64| (x - y).abs() > Guard::TOLERANCE;
    far(a.forward_m_s, b.forward_m_s) || far(a.left_m_s, b.left_m_s) || far(a.turn_rad_s, b.turn_rad_s)
}

#[cfg(test)]
mod tests;
