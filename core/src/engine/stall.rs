//! The stall monitor: a robot that should be on its way and makes none.
//!
//! Valverde Moreno (2015), section 4.3, leaves local minima to whoever places the waypoints; this says when one holds the
//! robot. Progress is what the map *and* the odometer agree on: an estimate that jumps about does not make a robot that
//! stands look as if it drove, and neither do wheels that spin.

use super::closest::Closest;
use super::events::{Event, EventKind};
use super::navigator::{Navigator, Outcome};
use super::order::State;
use super::step::Engine;
use crate::frames::{Point2, Pose2, flatten};
use crate::pipeline::Mission;
use crate::robot::Robot;
use crate::time::{Span, Time};

/// Where the robot was when it last made way.
#[derive(Debug, Clone, Copy)]
struct Anchor {
    in_map: Point2,
    in_odom: Option<Point2>,
    since: Time,
}

/// Watches whether the robot makes way.
#[derive(Debug)]
pub struct StallMonitor {
    /// What is nearest to the hull.
    pub closest: Closest,
    after: Span,
    within_m: f64,
    anchor: Option<Anchor>,
    n_stalls: u32,
}

impl StallMonitor {
    /// So many times in one place are enough.
    const MOST_STALLS: u32 = 5;

    /// What the mission wants; nothing where it does not ask for one.
    pub fn of(mission: &Mission, robot: &Robot) -> Option<StallMonitor> {
        let after = Span::from_secs(mission.stuck_after_s?);
        let (closest, within_m) = (Closest::new(robot), mission.stuck_within_m);
        Some(StallMonitor { closest, after, within_m, anchor: None, n_stalls: 0 })
    }

    /// The robot has nothing to do: what comes next begins anew.
    pub fn rest(&mut self) {
        (self.anchor, self.n_stalls) = (None, 0);
    }

    /// It has nowhere to go for the moment: this time does not count.
    pub fn wait(&mut self, now: Time) {
        if let Some(anchor) = &mut self.anchor {
            anchor.since = now;
        }
    }

    /// The robot is on its way and here. Without odometry the map alone counts. Returns how often it has been stuck in this
    /// place, whenever it is stuck once more.
    pub fn watch(&mut self, now: Time, in_map: Point2, in_odom: Option<Point2>) -> Option<u32> {
        let here = Anchor { in_map, in_odom, since: now };
        let Some(anchor) = &mut self.anchor else {
            self.anchor = Some(here);
            return None;
        };
        let within_m = self.within_m;
        let rolled = in_odom.zip(anchor.in_odom).is_none_or(|(here, then)| (here - then).norm() >= within_m);
        if rolled && (in_map - anchor.in_map).norm() >= within_m {
            (*anchor, self.n_stalls) = (here, 0);
            return None;
        }
        if now - anchor.since < self.after {
            return None;
        }
        anchor.since = now;
        self.n_stalls += 1;
        Some(self.n_stalls)
    }
}

impl Navigator {
    /// The robot made no way. With a planner a new path is asked for; without one, or after many times, the mission ends.
    pub fn stalled(&mut self, now: Time, n_stalls: u32, can_replan: bool, events: &mut Vec<Event>) {
        let (after_s, within_m) =
            (self.mission().stuck_after_s.unwrap_or_default(), self.mission().stuck_within_m);
        let first = format!("less than {within_m:.2} m of progress in {after_s} s");
        if !can_replan {
            let reason = format!("{first}, and there is no planner to ask for another way");
            return self.end(now, Outcome::Stuck(reason), events);
        }
        if n_stalls > StallMonitor::MOST_STALLS {
            let reason = format!("{first}, {n_stalls} times in one place");
            return self.end(now, Outcome::Stuck(reason), events);
        }
        self.replan(now, events);
    }
}

impl Engine {
    /// Looks whether the robot makes way, where the mission asks for it.
    pub(super) fn watch_for_stalls(&mut self) {
        let Some(monitor) = &mut self.stall else { return };
        for observation in self.ring.newest_unreplaced(self.n_new) {
            monitor.closest.see(observation, &self.track.at(observation.stamp));
        }
        // What a recording did is no fault of this mission.
        if self.navigator.state != State::Navigating || self.not_actuated {
            return monitor.rest();
        }
        if self.navigator.path.is_none() {
            return monitor.wait(self.now);
        }
        let odom_from_base = self.track.now_at(self.now);
        let map_from_odom = flatten(&self.localization.estimate.map_from_odom);
        let place = |pose: &Pose2| Point2::from(pose.translation.vector);
        let position = place(&(map_from_odom * odom_from_base));
        let in_odom = self.track.stamp().map(|_| place(&odom_from_base));
        let Some(n_stalls) = monitor.watch(self.now, position, in_odom) else { return };
        let closest = monitor.closest.now(self.now, &odom_from_base);
        let closest = closest.map(|(in_odom, off_m)| (map_from_odom * in_odom, off_m));
        self.events.push(Event { stamp: self.now, kind: EventKind::Stuck { position, closest } });
        let can_replan = self.planning.main.is_some();
        self.navigator.stalled(self.now, n_stalls, can_replan, &mut self.events);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Five seconds, 0.2 m.
    fn monitor() -> StallMonitor {
        let mission = Mission { stuck_after_s: Some(5.0), ..Mission::default() };
        StallMonitor::of(&mission, &Robot::default()).unwrap()
    }

    /// Seconds at which it says so, asked ten times a second for so many seconds.
    fn stalls(
        monitor: &mut StallMonitor,
        seconds: f64,
        place: impl Fn(f64) -> (f64, Option<f64>),
    ) -> Vec<f64> {
        let point = |x: f64| Point2::new(x, 0.0);
        let steps = (0..=(seconds * 10.0) as i32).map(|k| f64::from(k) / 10.0);
        let mut found = Vec::new();
        for t in steps {
            let (map, odom) = place(t);
            if monitor.watch(Time::from_secs(t), point(map), odom.map(point)).is_some() {
                found.push(t);
            }
        }
        found
    }

    #[test]
    fn a_robot_is_stuck_when_it_stays_within_the_radius_for_so_long() {
        let dithers = |t: f64| (0.15 * (3.0 * t).sin(), Some(0.15 * (3.0 * t).sin()));
        assert_eq!(stalls(&mut monitor(), 14.0, dithers), [5.0, 10.0]);
        let creeps = |t: f64| (0.041 * t, Some(0.041 * t));
        assert_eq!(stalls(&mut monitor(), 30.0, creeps), [0.0; 0], "0.205 m in 5 s");
        let slower = |t: f64| (0.03 * t, Some(0.03 * t));
        assert_eq!(stalls(&mut monitor(), 6.0, slower), [5.0], "0.15 m in 5 s");
        // Deadlocked from the eighth second on: told five seconds after the last 0.2 m, which took less than 0.6 s.
        let stops = |t: f64| (0.5 * t.min(8.0), Some(0.5 * t.min(8.0)));
        let told = stalls(&mut monitor(), 16.0, stops);
        assert!(told.len() == 1 && told[0] > 12.4 && told[0] <= 13.0, "{told:?}");
    }

    #[test]
    fn map_and_odometer_must_agree_on_progress() {
        let jumps = |t: f64| (if (10.0 * t).round() % 2.0 < 1.0 { 0.9 } else { 0.0 }, Some(0.0));
        assert_eq!(stalls(&mut monitor(), 9.0, jumps), [5.0], "an estimate that jumps about");
        let spins = |t: f64| (0.0, Some(t));
        assert_eq!(stalls(&mut monitor(), 9.0, spins), [5.0], "wheels that spin");
        let without = |t: f64| (t, None);
        assert_eq!(stalls(&mut monitor(), 9.0, without), [0.0; 0], "no odometer has no say");
    }

    #[test]
    fn progress_and_rest_begin_the_count_anew_and_waiting_does_not_count() {
        let (mut monitor, here) = (monitor(), Point2::origin());
        let at = Time::from_secs;
        assert_eq!(monitor.watch(at(0.0), here, None), None);
        assert_eq!(monitor.watch(at(5.0), here, None), Some(1));
        monitor.wait(at(9.0));
        assert_eq!(monitor.watch(at(13.0), here, None), None);
        assert_eq!(monitor.watch(at(14.0), here, None), Some(2));
        assert_eq!(monitor.watch(at(15.0), Point2::new(0.3, 0.0), None), None);
        assert_eq!(monitor.watch(at(20.0), Point2::new(0.3, 0.0), None), Some(1));
        monitor.rest();
        assert_eq!(monitor.watch(at(30.0), Point2::new(0.3, 0.0), None), None);
        assert_eq!(monitor.watch(at(35.0), Point2::new(0.3, 0.0), None), Some(1));
    }

    #[test]
    fn who_does_not_ask_for_a_monitor_has_none() {
        assert!(StallMonitor::of(&Mission::default(), &Robot::default()).is_none());
    }
}
