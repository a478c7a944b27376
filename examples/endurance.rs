//! Half an hour of the search robot around the rubble loop: 40 scans and 200 inertial readings a second through the whole
//! pipeline, steered by what the robot believes.
//!
//! `cargo run --release --example endurance [-- MINUTES]` fails unless the robot drives to the end without contact, no number
//! that is none comes out, no more memory is used than 1 % beyond that of the first minute, the 99th percentile of the last
//! minute's cycles is at most 1.2 times that of the first minute, and one core is enough. A cycle is a step of the engine with
//! a scan in it: simulation, leveling, odometer, match, map, steering; times are processor time.
#![allow(clippy::print_stdout)]

use rumbo_core::engine::{EndReason, Engine, EventKind, Observer, StepView};
use rumbo_core::messages::{Check, Data};
use rumbo_core::pipeline::Loaded;
use rumbo_core::time::Time;
use rustix::time::{ClockId, clock_gettime};
use std::error::Error;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

const PIPELINE: &str = "pipelines/finder_patrol.toml";
const LASER_HZ: f64 = 40.0;
const IMU_HZ: f64 = 200.0;
/// Corners of the lane, from where the robot starts and back to it, meters.
const LANE_M: [[f64; 2]; 12] = [
    [5.2, -4.6],
    [6.5, -4.1],
    [7.0, -2.8],
    [7.0, 2.8],
    [6.5, 4.1],
    [5.2, 4.6],
    [-5.2, 4.6],
    [-6.5, 4.1],
    [-7.0, 2.8],
    [-7.0, -2.8],
    [-6.5, -4.1],
    [-5.2, -4.6],
];
/// At 1.38 m/s the robot cannot do more than this many laps a minute.
const MOST_LAPS_A_MINUTE: usize = 2;
const MOST_GROWTH: f64 = 1.01;
const MOST_SLOWER: f64 = 1.2;

/// One minute of the world's time.
#[derive(Debug, Default)]
struct Minute {
    p50_ms: f64,
    p99_ms: f64,
    most_ms: f64,
    resident_kib: usize,
}

#[derive(Debug)]
struct Watcher {
    minutes: Vec<Minute>,
    /// Cycles of the minute that lasts.
    cycles_ms: Vec<f64>,
    last_ms: f64,
    worst_m: f64,
    n_contacts: u32,
    n_bad: u64,
    n_failures: u64,
    end: Time,
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let minutes: usize = std::env::args().nth(1).map_or(Ok(30), |text| text.parse())?;
    let seconds = minutes as f64 * 60.0;
    let corners: Vec<String> =
        LANE_M.iter().map(|[x, y]| format!("{{ x_m = {x:.1}, y_m = {y:.1} }}")).collect();
    let laps = vec![corners.join(", "); minutes * MOST_LAPS_A_MINUTE];
    let sets = [
        format!("sensor.laser.rate_hz={LASER_HZ:.1}"),
        format!("sensor.imu.rate_hz={IMU_HZ:.1}"),
        "odometer.plugin=nav_filter".to_owned(),
        format!("mission.time_limit_s={seconds:.1}"),
        format!("mission.waypoints=[{}]", laps.join(", ")),
    ];
    let loaded = Loaded::read(Path::new(PIPELINE), &sets, &rumbo::registry()?);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    let mut engine = Engine::build(pipeline)?;
    let mut watcher = Watcher::new();
    let begin_ms = cpu_ms();
    let end = engine.run(&mut [&mut watcher], &AtomicBool::new(false));
    let cores = (cpu_ms() - begin_ms) * 1e-3 / watcher.end.as_secs();
    Ok(if watcher.is_good(end.reason, cores) { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

impl Watcher {
    fn new() -> Watcher {
        Watcher {
            minutes: Vec::with_capacity(64),
            cycles_ms: Vec::with_capacity(8192),
            last_ms: cpu_ms(),
            worst_m: 0.0,
            n_contacts: 0,
            n_bad: 0,
            n_failures: 0,
            end: Time::ZERO,
        }
    }

    fn end_minute(&mut self) {
        self.cycles_ms.sort_by(f64::total_cmp);
        let share = |share: f64| {
            let idx = (self.cycles_ms.len() as f64 * share) as usize;
            self.cycles_ms.get(idx).or(self.cycles_ms.last()).copied().unwrap_or(f64::NAN)
        };
        let (p50_ms, p99_ms, most_ms) = (share(0.5), share(0.99), share(1.0));
        let minute = Minute { p50_ms, p99_ms, most_ms, resident_kib: resident_kib() };
        println!(
            "{:>3} min: cycles of {p50_ms:.2} ms, 99 % below {p99_ms:.2} ms, all below {most_ms:.2} ms; {} KiB; at most {:.3} m off",
            self.minutes.len() + 1,
            minute.resident_kib,
            self.worst_m
        );
        self.cycles_ms.clear();
        self.minutes.push(minute);
    }

    fn is_good(&self, reason: EndReason, cores: f64) -> bool {
        let (Some(first), Some(last)) = (self.minutes.first(), self.minutes.last()) else {
            println!("ended with {reason:?} before the first minute was over");
            return false;
        };
        let most_kib = self.minutes.iter().map(|minute| minute.resident_kib).max().unwrap_or_default();
        let growth = most_kib as f64 / first.resident_kib as f64;
        let slower = last.p99_ms / first.p99_ms;
        println!(
            "ended with {reason:?} after {} s, {} contacts, {} numbers that are none, {} failures of stages",
            self.end.as_secs(),
            self.n_contacts,
            self.n_bad,
            self.n_failures
        );
        println!(
            "memory {growth:.4} of the first minute's, cycles {slower:.3} of the first minute's, {cores:.3} cores"
        );
        let has_driven = reason == EndReason::TimeLimit && self.n_contacts == 0;
        let is_sound = self.n_bad == 0 && self.n_failures == 0;
        has_driven && is_sound && growth <= MOST_GROWTH && slower <= MOST_SLOWER && cores <= 1.0
    }
}

impl Observer for Watcher {
    fn on_step(&mut self, view: &StepView<'_>) {
        let now_ms = cpu_ms();
        if view.observations.iter().any(|seen| matches!(seen.data, Data::LaserScan(_))) {
            self.cycles_ms.push(now_ms - self.last_ms);
        }
        self.end = view.now;
        self.n_bad += u64::from(view.estimate.check().is_err());
        self.n_failures +=
            view.events.iter().filter(|event| matches!(event.kind, EventKind::StageFailed { .. })).count()
                as u64;
        if let Some(truth) = view.truth {
            let way = view.map_from_base.translation.vector - truth.map_from_base.translation.vector.xy();
            self.worst_m = self.worst_m.max(way.norm());
            self.n_contacts = truth.contact_episodes.unwrap_or_default();
        }
        if view.now.as_secs() >= 60.0 * (self.minutes.len() + 1) as f64 {
            self.end_minute();
        }
        self.last_ms = cpu_ms();
    }
}

/// Processor time of this process.
fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

/// Memory of this process, KiB; 0 where the system does not tell.
fn resident_kib() -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmRSS"));
    line.and_then(|line| line.split_whitespace().nth(1)).and_then(|kib| kib.parse().ok()).unwrap_or_default()
}
