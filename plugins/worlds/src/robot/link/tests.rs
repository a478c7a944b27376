use std::sync::Arc;

use rumbo_core::frames::Twist;
use rumbo_core::registry::Plugin;
use rumbo_core::robot::Robot;
use rumbo_core::stages::{BuildContext, World};
use rumbo_kit::emulation::{EmulatedDevice, LineFaultParams, LineFaults};

use super::*;
use crate::robot::emulated::{EmulatedBase, Scene};
use crate::robot::params::EmulateParams;
use crate::sim::{SimParams, Start};

const STEP: Span = Span(5_000_000);
const FORWARD: Twist = Twist { forward_m_s: 0.2, left_m_s: 0.0, turn_rad_s: 0.0 };

/// Host, line, base and simulated place on one clock.
struct Bench {
    link: Link,
    base: EmulatedBase,
    scene: Arc<Scene>,
    line: LineFaults,
    is_unplugged: bool,
    now: Time,
    events: Vec<String>,
    rolled_m: f64,
}

impl Bench {
    fn new(faults: LineFaultParams) -> Self {
        let sim = SimParams { start: Start { x_m: 1.0, y_m: 2.0, yaw_deg: 90.0 }, ..SimParams::default() };
        let world: Box<dyn World> = sim.build(&BuildContext::bare("world")).unwrap();
        let scene = Arc::new(Scene::new(world));
        let base = EmulatedBase::new(&EmulateParams::default(), &Robot::default(), Arc::clone(&scene));
        Self {
            link: Link::new(Time::ZERO),
            base,
            scene,
            line: LineFaults::new(faults, 3, "line"),
            is_unplugged: false,
            now: Time::ZERO,
            events: Vec::new(),
            rolled_m: 0.0,
        }
    }

    fn step(&mut self) {
        self.now = self.now + STEP;
        self.link.tick(self.now);
        let mut to_base = self.link.take_out();
        self.line.befall(&mut to_base);
        let mut from_base = Vec::new();
        if !self.is_unplugged {
            self.base.receive(self.now, None, &to_base);
        }
        self.base.transmit(self.now, None, &mut from_base);
        self.line.befall(&mut from_base);
        if !self.is_unplugged {
            self.link.receive(self.now, &from_base);
        }
        while let Some(event) = self.link.next_event() {
            self.events.push(event.to_string());
        }
        if let Some(wheels) = self.link.readings().wheels.take() {
            let [left_m, right_m, ..] = wheels.value.rolled_m;
            self.rolled_m = (left_m + right_m) / 2.0;
        }
    }

    /// As an engine that drives 20 times a second.
    fn drive(&mut self, twist: Twist, seconds: f64) {
        let end = self.now + Span::from_secs(seconds);
        while self.now < end {
            if self.now.0 % 50_000_000 == 0 {
                self.link.drive(self.now, twist);
            }
            self.step();
        }
    }

    fn wait(&mut self, seconds: f64) {
        let end = self.now + Span::from_secs(seconds);
        while self.now < end {
            self.step();
        }
    }

    /// From the start, along the way that it looks.
    fn way_m(&self) -> f64 {
        self.scene.at(self.now, |world| world.truth().unwrap().map_from_base.translation.y - 2.0)
    }

    fn speed_m_s(&self) -> f64 {
        self.scene.at(self.now, |world| world.truth().unwrap().twist.forward_m_s)
    }
}

#[test]
fn a_base_is_found_driven_and_left_standing() {
    let mut bench = Bench::new(LineFaultParams::default());
    bench.drive(FORWARD, 0.1);
    assert!(bench.link.is_ready());
    assert_eq!(bench.events, ["the base EMULATED answers"]);
    let base = bench.link.base().unwrap();
    assert_eq!((base.identity.track_m, base.sonars.n_sonars, base.bumpers.n_bumpers), (0.36, 16, 16));
    bench.drive(FORWARD, 5.0);
    // Speeding up at 0.5 m/s² takes 0.4 s and costs 0.04 m.
    assert!((bench.way_m() - 0.96).abs() < 0.02, "{}", bench.way_m());
    assert!((bench.rolled_m - bench.way_m()).abs() < 0.006, "{} at {}", bench.rolled_m, bench.way_m());
    bench.link.leave();
    bench.wait(0.02);
    assert!(bench.link.is_left());
    bench.wait(1.0);
    assert_eq!(bench.speed_m_s(), 0.0);
    assert_eq!(bench.link.tally().n_rejected, 0);
}

/// A command is held for 0.3 s, and the base waits another 0.5 s.
#[test]
fn a_host_that_hangs_does_not_drive_on() {
    let mut bench = Bench::new(LineFaultParams::default());
    bench.drive(FORWARD, 2.0);
    bench.wait(0.25);
    assert!(bench.speed_m_s() > 0.19, "a short pause is bridged");
    bench.wait(0.6);
    assert!(bench.speed_m_s() < 0.19, "{}", bench.speed_m_s());
    bench.wait(0.6);
    assert_eq!(bench.speed_m_s(), 0.0);
    assert!(bench.events.iter().any(|event| event.contains("stopped by itself")), "{:?}", bench.events);
    assert!(bench.link.is_ready(), "the line is fine");
}

#[test]
fn a_pulled_cable_stops_the_base_and_it_is_found_again() {
    let mut bench = Bench::new(LineFaultParams::default());
    for round in 0..3 {
        bench.drive(FORWARD, 2.0);
        assert!(bench.link.is_ready() && bench.speed_m_s() > 0.19, "round {round}");
        bench.is_unplugged = true;
        bench.drive(FORWARD, if round == 1 { 0.7 } else { 3.0 });
        assert!(!bench.link.is_ready());
        let (span, reason) = bench.link.lost_for(bench.now).unwrap();
        assert!(span.as_secs() > 0.1 && reason.contains("nothing for 0.5 s"), "{reason}");
        bench.drive(FORWARD, 1.0);
        assert_eq!(bench.speed_m_s(), 0.0);
        bench.is_unplugged = false;
    }
    bench.drive(FORWARD, 1.0);
    let n_of = |word: &str| bench.events.iter().filter(|event| event.contains(word)).count();
    assert_eq!((n_of("answers"), n_of("is lost")), (4, 3), "{:?}", bench.events);
    // What the base did while nobody listened is in its counts.
    assert!((bench.rolled_m - bench.way_m()).abs() < 0.006, "{} at {}", bench.rolled_m, bench.way_m());
}

#[test]
fn a_base_that_restarts_counts_anew_and_the_sum_goes_on() {
    let mut bench = Bench::new(LineFaultParams::default());
    bench.drive(FORWARD, 3.0);
    let before_m = bench.way_m();
    bench.base.restart(bench.now);
    bench.drive(FORWARD, 4.0);
    assert!(bench.link.is_ready());
    assert!(bench.way_m() > before_m + 0.4, "it drives again");
    // From the last report before the restart to the restart itself nobody counted.
    assert!((bench.rolled_m - bench.way_m()).abs() < 0.06, "{} at {}", bench.rolled_m, bench.way_m());
}

/// A minute of a line on which one byte in a thousand is lost or damaged: every eighth line.
#[test]
fn a_bad_line_costs_lines_and_nothing_else() {
    let faults = LineFaultParams { loss: 5e-4, flips: 5e-4, ..LineFaultParams::default() };
    let mut bench = Bench::new(faults);
    bench.drive(FORWARD, 60.0);
    let tally = bench.link.tally();
    assert!(tally.n_rejected > 100 && tally.n_missed > 100 && tally.n_lines > 4000, "{tally:?}");
    assert!(bench.link.is_ready() && bench.speed_m_s() > 0.19);
    assert!((bench.way_m() - 12.0).abs() < 0.2, "{}", bench.way_m());
    assert!((bench.rolled_m - bench.way_m()).abs() < 0.03, "{} at {}", bench.rolled_m, bench.way_m());
    assert_eq!(bench.events, ["the base EMULATED answers"]);
}

#[test]
fn a_base_of_another_version_is_refused_with_both_versions() {
    let mut link = Link::new(Time::ZERO);
    link.receive(Time(1), &encode(0, &FromBase::No { version: 3 }.to_string()));
    let reason = link.refused().unwrap();
    assert!(reason.contains("version 3") && reason.contains("speaks 1"), "{reason}");
}

#[test]
fn the_emergency_stop_and_a_low_battery_are_told_once() {
    let mut bench = Bench::new(LineFaultParams::default());
    bench.drive(FORWARD, 1.0);
    bench.base.press_emergency(bench.now, true);
    bench.drive(FORWARD, 1.0);
    bench.base.press_emergency(bench.now, false);
    bench.drive(FORWARD, 1.0);
    assert_eq!(bench.events.len(), 3, "{:?}", bench.events);
    assert!(bench.events[1].contains("is pressed") && bench.events[2].contains("is released"));
    let status = BaseStatus { battery_mv: 11_100, is_battery_low: true, ..*bench.link.status().unwrap() };
    for _ in 0..2 {
        let line = encode(0, &FromBase::State(status).to_string());
        bench.link.receive(bench.now, &line);
    }
    assert_eq!(bench.link.next_event().unwrap().to_string(), "the battery of the base is low: 11.1 V");
    assert_eq!(bench.link.next_event(), None);
}
