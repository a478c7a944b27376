//! The base's side of the line, on a clock that is given.

use std::f64::consts::TAU;
use std::sync::Arc;

use rumbo_core::frames::{Pose3, Twist};
use rumbo_core::messages::Command;
use rumbo_core::robot::{Drive, Robot};
use rumbo_core::stages::{Answer, Probe, WheelMotion, World};
use rumbo_core::time::{Span, Time};
use rumbo_kit::emulation::EmulatedDevice;

use super::Scene;
use crate::robot::params::EmulateParams;
use crate::robot::protocol::{
    BaseIdentity, BaseStatus, BumperGeometry, Decoder, Frame, FromBase, SonarGeometry, SonarReading, ToBase,
    VERSION, WheelReport, encode,
};

/// Without a command for so long the base stops.
const WATCHDOG: Span = Span(500_000_000);
/// Without any line for so long the session is over.
const SESSION: Span = Span(2_000_000_000);
/// Sonars sit so high, meters.
const SONAR_HEIGHT_M: f64 = 0.2;
const SONAR_MIN_M: f64 = 0.15;
const SONAR_MAX_M: f64 = 6.5;
/// A lead battery of 12 V, full.
const BATTERY_MV: u32 = 12_600;

/// What a base sends by itself, and how often.
#[derive(Debug, Clone, Copy)]
enum Report {
    Wheels,
    Touch,
    Ranges,
    State,
}

const REPORTS: [(Report, Span); 4] = [
    (Report::Wheels, Span(20_000_000)),
    (Report::Touch, Span(50_000_000)),
    (Report::Ranges, Span(100_000_000)),
    (Report::State, Span(200_000_000)),
];

/// A base.
pub struct EmulatedBase {
    scene: Arc<Scene>,
    identity: BaseIdentity,
    sonars: SonarGeometry,
    bearings_rad: Vec<f64>,
    bumpers: BumperGeometry,
    decoder: Decoder,
    out: Vec<u8>,
    number: u16,
    /// When the host was heard last; none outside of a session.
    heard_at: Option<Time>,
    commanded_at: Time,
    last_command: u16,
    is_watchdog: bool,
    is_emergency: bool,
    started_at: Time,
    /// When each report is due.
    due: [Time; REPORTS.len()],
    /// What the wheels had rolled when the base was started.
    counted_from: WheelMotion,
}

impl EmulatedBase {
    /// The base of this robot, just switched on.
    pub fn new(params: &EmulateParams, robot: &Robot, scene: Arc<Scene>) -> Self {
        let step_rad = |n: u32| if n == 0 { 0.0 } else { TAU / f64::from(n) };
        let track_m = match robot.drive {
            Drive::Differential { track_m } | Drive::Tricycle { track_m, .. } => track_m,
            _ => 0.0,
        };
        let sonars = SonarGeometry {
            n_sonars: params.sonars,
            first_bearing_rad: 0.0,
            bearing_step_rad: step_rad(params.sonars),
            cone_rad: params.sonar_cone_deg.to_radians(),
            ring_radius_m: robot.hull().inner_radius_m(),
            min_range_m: SONAR_MIN_M,
            max_range_m: SONAR_MAX_M,
        };
        let bumpers = BumperGeometry {
            n_bumpers: params.bumpers,
            first_bearing_rad: 0.0,
            bearing_step_rad: step_rad(params.bumpers),
        };
        let identity = BaseIdentity {
            version: VERSION,
            boot: 1,
            drive: robot.drive.kind(),
            track_m,
            watchdog_s: WATCHDOG.as_secs(),
            name: "EMULATED".to_owned(),
        };
        Self {
            scene,
            identity,
            sonars,
            bearings_rad: (0..params.sonars).map(|k| step_rad(params.sonars) * f64::from(k)).collect(),
            bumpers,
            decoder: Decoder::default(),
            out: Vec::new(),
            number: 0,
            heard_at: None,
            commanded_at: Time::ZERO,
            last_command: 0,
            is_watchdog: false,
            is_emergency: false,
            started_at: Time::ZERO,
            due: [Time::ZERO; REPORTS.len()],
            counted_from: WheelMotion::default(),
        }
    }

    /// Somebody presses the emergency stop, or lets it go.
    pub fn press_emergency(&mut self, now: Time, is_pressed: bool) {
        self.is_emergency = is_pressed;
        self.drive(now, Twist::ZERO);
    }

    /// Power fails and comes back: wheels are counted from zero.
    pub fn restart(&mut self, now: Time) {
        self.drive(now, Twist::ZERO);
        self.counted_from = self.scene.at(now, wheels_of);
        self.identity.boot = self.identity.boot.wrapping_add(1);
        (self.heard_at, self.started_at) = (None, now);
        (self.decoder, self.number, self.is_watchdog) = (Decoder::default(), 0, false);
        self.out.clear();
    }

    fn drive(&mut self, now: Time, twist: Twist) {
        let twist = if self.is_emergency { Twist::ZERO } else { twist };
        // A line carries no number that is not finite, and that is all a simulation refuses.
        let _ = self.scene.at(now, |world| world.drive(&Command { stamp: now, twist }));
    }

    fn say(&mut self, line: &FromBase) {
        self.out.extend(encode(self.number, &line.to_string()));
        self.number = self.number.wrapping_add(1);
    }

    fn obey(&mut self, now: Time, number: u16, line: ToBase) {
        match line {
            ToBase::Hello { version: VERSION } => {
                if self.heard_at.is_none() {
                    (self.due, self.commanded_at) = ([now; REPORTS.len()], now);
                }
                self.heard_at = Some(now);
                let (identity, sonars, bumpers) = (self.identity.clone(), self.sonars, self.bumpers);
                for answer in [FromBase::Base(identity), FromBase::Sonars(sonars), FromBase::Bumpers(bumpers)]
                {
                    self.say(&answer);
                }
            }
            ToBase::Hello { .. } => self.say(&FromBase::No { version: VERSION }),
            // Whoever did not say hello is not obeyed.
            _ if self.heard_at.is_none() => {}
            ToBase::Drive(twist) => {
                (self.heard_at, self.commanded_at, self.last_command) = (Some(now), now, number);
                self.is_watchdog = false;
                self.drive(now, twist);
            }
            ToBase::Bye => {
                self.drive(now, Twist::ZERO);
                self.heard_at = None;
                self.say(&FromBase::Bye);
            }
        }
    }

    fn watch(&mut self, now: Time) {
        let Some(heard_at) = self.heard_at else { return };
        if now - self.commanded_at > WATCHDOG && !self.is_watchdog {
            self.is_watchdog = true;
            self.drive(now, Twist::ZERO);
        }
        if now - heard_at > SESSION {
            self.heard_at = None;
        }
    }

    fn report(&mut self, now: Time, report: Report) {
        let at_ms = ((now - self.started_at).0 / 1_000_000) as u32;
        let line = match report {
            Report::Wheels => {
                let wheels = since(&self.counted_from, self.scene.at(now, wheels_of));
                FromBase::Wheels(WheelReport { at_ms, wheels })
            }
            Report::Touch => FromBase::Touch { at_ms, pressed: self.pressed(now) },
            Report::Ranges => FromBase::Ranges { at_ms, readings: self.heard_by_sonars(now) },
            Report::State => FromBase::State(BaseStatus {
                at_ms,
                battery_mv: BATTERY_MV,
                is_battery_low: false,
                is_emergency: self.is_emergency,
                is_watchdog: self.is_watchdog,
                last_command: self.last_command,
            }),
        };
        self.say(&line);
    }

    fn pressed(&self, now: Time) -> u64 {
        let n_bumpers = self.bumpers.n_bumpers;
        if n_bumpers == 0 {
            return 0;
        }
        let bumper = |bearing_rad: &f64| {
            (bearing_rad.rem_euclid(TAU) / TAU * f64::from(n_bumpers)).round() as u32 % n_bumpers
        };
        self.scene.at(now, |world| match world.probe(&Probe::Contacts) {
            Ok(Answer::Contacts(bearings)) => {
                bearings.iter().fold(0, |bits, bearing| bits | 1 << bumper(bearing))
            }
            _ => 0,
        })
    }

    fn heard_by_sonars(&self, now: Time) -> Vec<SonarReading> {
        let mount = Pose3::translation(0.0, 0.0, SONAR_HEIGHT_M);
        let probe = Probe::Cones {
            base_from_sensor: &mount,
            bearings_rad: &self.bearings_rad,
            cone_rad: self.sonars.cone_rad,
            ring_radius_m: self.sonars.ring_radius_m,
            max_range_m: SONAR_MAX_M,
        };
        let reading = |range_m: &f32| match f64::from(*range_m) {
            range_m if !range_m.is_finite() => SonarReading::Nothing,
            range_m if range_m < SONAR_MIN_M => SonarReading::Lost,
            range_m => SonarReading::Echo((range_m * 1000.0).round() as u32),
        };
        self.scene.at(now, |world| match world.probe(&probe) {
            Ok(Answer::Ranges(ranges_m)) => ranges_m.iter().map(reading).collect(),
            _ => vec![SonarReading::Lost; self.bearings_rad.len()],
        })
    }
}

fn wheels_of(world: &mut dyn World) -> WheelMotion {
    match world.probe(&Probe::Wheels) {
        Ok(Answer::Wheels(wheels)) => wheels,
        _ => WheelMotion::default(),
    }
}

fn since(start: &WheelMotion, mut wheels: WheelMotion) -> WheelMotion {
    for (rolled_m, start_m) in wheels.rolled_m.iter_mut().zip(start.rolled_m) {
        *rolled_m -= start_m;
    }
    wheels.turned_rad -= start.turned_rad;
    wheels
}

impl EmulatedDevice for EmulatedBase {
    fn receive(&mut self, now: Time, _: Option<u32>, bytes: &[u8]) {
        for byte in bytes {
            let Some(Frame { number, text }) = self.decoder.push(*byte) else { continue };
            if let Ok(line) = ToBase::parse(&text) {
                self.obey(now, number, line);
            }
        }
    }

    fn transmit(&mut self, now: Time, _: Option<u32>, out: &mut Vec<u8>) {
        self.watch(now);
        for (idx, (report, period)) in REPORTS.into_iter().enumerate() {
            let Some(due) = self.due.get_mut(idx).filter(|due| **due <= now && self.heard_at.is_some())
            else {
                continue;
            };
            // What was missed is not made up for.
            *due = (*due + period).max(now);
            self.report(now, report);
        }
        out.append(&mut self.out);
    }
}

#[cfg(test)]
mod tests;
