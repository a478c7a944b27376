//! Half an hour on patrol: does anything grow or slow down? The specification's bars, and the end of the program with status 1
//! where one is broken: after the first minute memory grows by at most 1 %; the cycle's 99th percentile in the last minute is at
//! most 1.2 times that in the first; no pose is without a number.
//!
//! ```text
//! cargo bench --bench endurance -- [PIPELINE] [--minutes N] [--set KEY=VALUE]...
//! ```
//! The pipeline's waypoints are driven again and again. A cycle is a step that takes in a scan, by processor time of the thread.
//! Memory is told twice: what the run's thread has on the heap, and what the system counts (Linux only). Beside each cycle the same
//! little sum is done: where that takes longer too, it is the machine that slowed down, and the cycle is judged against it.
#![allow(clippy::print_stdout, clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use rumbo_core::engine::{Engine, Metrics, Observer, StepView, Stepped};
use rumbo_core::messages::Data;
use rumbo_core::pipeline::{Loaded, Pipeline};
use rumbo_core::time::{Span, Time};
use rustix::time::{ClockId, clock_gettime};
use std::path::Path;
use std::process::ExitCode;

const PIPELINE: &str = "pipelines/finder_endurance.toml";
const MINUTES: usize = 30;
/// Bounds of the specification.
const MOST_GROWTH: f64 = 0.01;
const MOST_SLOWER: f64 = 1.2;

struct Asked {
    file: String,
    minutes: usize,
    sets: Vec<String>,
}

fn asked() -> Asked {
    let mut asked = Asked { file: PIPELINE.to_owned(), minutes: MINUTES, sets: Vec::new() };
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--minutes" => asked.minutes = args.next().and_then(|n| n.parse().ok()).expect("--minutes N"),
            "--set" => asked.sets.push(args.next().expect("--set KEY=VALUE")),
            file if file.ends_with(".toml") => file.clone_into(&mut asked.file),
            // From `cargo bench`, and what is for others of its benches.
            _ => {}
        }
    }
    asked
}

/// The pipeline with its way driven again and again.
fn patrol(asked: &Asked) -> Pipeline {
    let registry = rumbo::registry().unwrap_or_default();
    let loaded = Loaded::read(Path::new(&asked.file), &asked.sets, &registry);
    assert!(loaded.sound().is_some(), "{}: see `rumbo check`", asked.file);
    let mut pipeline = loaded.pipeline.unwrap();
    // Nobody drives a lap in less than ten seconds.
    let n_laps = 6 * asked.minutes + 1;
    pipeline.mission.waypoints = pipeline.mission.waypoints.repeat(n_laps);
    pipeline.mission.time_limit_s = 60.0 * (asked.minutes + 1) as f64;
    pipeline
}

fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

/// What the system counts as this program's memory, bytes.
fn resident() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    line.trim().trim_end_matches("kB").trim().parse::<f64>().ok().map(|kib| 1024.0 * kib)
}

/// The same work each time, milliseconds.
fn yardstick_ms() -> f64 {
    let began_ms = cpu_ms();
    let sum = (0..20_000u32).fold(0.0, |sum: f64, k| (sum + f64::from(k)).sqrt());
    std::hint::black_box(sum);
    cpu_ms() - began_ms
}

/// Half, 99 of 100 and all of them are at most this. Nothing is left of them.
fn percentiles(times_ms: &mut Vec<f64>) -> [f64; 3] {
    times_ms.sort_unstable_by(f64::total_cmp);
    let last = times_ms.len().saturating_sub(1) as f64;
    let at = [0.5, 0.99, 1.0].map(|share| times_ms.get((last * share) as usize).copied());
    times_ms.clear();
    at.map(Option::unwrap_or_default)
}

/// A run that somebody watches.
struct Watched {
    engine: Engine,
    metrics: Metrics,
    /// Milliseconds of each cycle of this minute; its room is taken once.
    cycles_ms: Vec<f64>,
    yardsticks_ms: Vec<f64>,
    n_not_finite: u64,
}

impl Watched {
    fn new(pipeline: &Pipeline) -> Watched {
        let mut engine = Engine::build(pipeline).expect("a pipeline that can be built");
        engine.keep_no_trajectory();
        let [cycles_ms, yardsticks_ms] = [(); 2].map(|()| Vec::with_capacity(1 << 16));
        Watched { engine, metrics: Metrics::new(), cycles_ms, yardsticks_ms, n_not_finite: 0 }
    }

    /// Drives on until then.
    fn drive_until(&mut self, end: Time) {
        loop {
            let began_ms = cpu_ms();
            let stepped = self.engine.step();
            let took_ms = cpu_ms() - began_ms;
            assert_eq!(stepped, Stepped::Went, "the run is over too early");
            let view = self.engine.view();
            self.metrics.on_step(&view);
            if has_scan(&view) {
                self.cycles_ms.push(took_ms);
                self.yardsticks_ms.push(yardstick_ms());
            }
            self.n_not_finite += u64::from(!is_finite(&view));
            assert!(view.n_goals_left > 0 || view.now == view.started, "the way is over too early");
            if view.now >= end {
                return;
            }
        }
    }
}

fn has_scan(view: &StepView<'_>) -> bool {
    view.observations.iter().any(|seen| matches!(seen.data, Data::LaserScan(_)))
}

fn is_finite(view: &StepView<'_>) -> bool {
    let (place, yaw) = (view.map_from_base.translation, view.map_from_base.rotation.angle());
    [place.x, place.y, yaw].iter().all(|v| v.is_finite())
        && view.estimate.covariance.iter().all(|v| v.is_finite())
}

/// One minute of the world's time.
#[derive(Debug, Clone, Copy)]
struct Minute {
    heap: f64,
    resident: Option<f64>,
    cycle_ms: [f64; 3],
    yardstick_ms: f64,
}

fn run(asked: &Asked) -> (Vec<Minute>, u64) {
    let pipeline = patrol(asked);
    let (mut watched, mut heap, mut minutes) = (None, 0, Vec::with_capacity(asked.minutes));
    let began = allocation_counter::measure(|| watched = Some(Watched::new(&pipeline)));
    let mut watched = watched.unwrap();
    heap += began.bytes_current;
    let started = watched.engine.view().started;
    println!(
        "| minute | heap MB | resident MB | cycle p50 ms | p99 ms | most ms |\n|---|---|---|---|---|---|"
    );
    for minute in 1..=asked.minutes {
        let end = started + Span::from_secs(60.0 * minute as f64);
        heap += allocation_counter::measure(|| watched.drive_until(end)).bytes_current;
        let (heap, resident, cycle_ms) = (heap as f64, resident(), percentiles(&mut watched.cycles_ms));
        let [yardstick_ms, ..] = percentiles(&mut watched.yardsticks_ms);
        let [half, most_of, all] = cycle_ms;
        let resident_mb = resident.map_or("-".to_owned(), |bytes| format!("{:.3}", bytes * 1e-6));
        println!("| {minute} | {:.3} | {resident_mb} | {half:.3} | {most_of:.3} | {all:.3} |", heap * 1e-6);
        minutes.push(Minute { heap, resident, cycle_ms, yardstick_ms });
    }
    (minutes, watched.n_not_finite)
}

/// Says what a bar is about; returns whether it is kept.
fn judge(what: &str, found: f64, most: f64) -> bool {
    let word = if found <= most { "kept" } else { "BROKEN" };
    println!("{what}: {found:.4}, at most {most}: {word}");
    found <= most
}

fn main() -> ExitCode {
    let asked = asked();
    println!("{} {}", asked.file, asked.sets.join(" "));
    let (minutes, n_not_finite) = run(&asked);
    let [first, .., last] = minutes.as_slice() else { panic!("two minutes at least") };
    let most = |of: fn(&Minute) -> f64| minutes.iter().map(of).fold(0.0, f64::max);
    let heap = judge("heap, growth after the first minute", most(|m| m.heap) / first.heap - 1.0, MOST_GROWTH);
    let resident = first.resident.is_none_or(|first| {
        let grown = most(|m| m.resident.unwrap_or_default()) / first - 1.0;
        judge("resident memory, growth after the first minute", grown, MOST_GROWTH)
    });
    let slower = last.cycle_ms[1] / first.cycle_ms[1];
    let machine = (last.yardstick_ms / first.yardstick_ms).max(1.0);
    println!(
        "cycle, 99th percentile of the last minute over the first: {slower:.4}; the machine: {machine:.4}"
    );
    let pace = judge("cycle, the same by the machine of that minute", slower / machine, MOST_SLOWER);
    let finite = judge("poses without a number", n_not_finite as f64, 0.0);
    ExitCode::from(u8::from(!(heap && resident && pace && finite)))
}
