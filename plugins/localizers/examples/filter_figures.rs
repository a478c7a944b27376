//! Processor time of the particle filter on the generated map: weights of both models, and the whole step.
//!
//! `cargo run --release -p rumbo-localizers --example filter_figures`. Processor time, unlike the wall clock of the
//! benches, does not count what other programs take.
#![allow(clippy::print_stdout, clippy::expect_used, clippy::panic)]

#[path = "../benches/filter_work/mod.rs"]
mod filter_work;

use filter_work::Work;
use rumbo_localizers::particle_filter::measurement::{BeamModel, FieldModel};
use rustix::time::{ClockId, clock_gettime};

fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

fn report(what: &str, n_items: usize, item: &str, mut run: impl FnMut()) {
    const RUNS: usize = 31;
    run();
    let mut times_ms: Vec<f64> = (0..RUNS)
        .map(|_| {
            let begin = cpu_ms();
            run();
            cpu_ms() - begin
        })
        .collect();
    times_ms.sort_by(f64::total_cmp);
    let (least, median) = (times_ms[0], times_ms[RUNS / 2]);
    let per_item = |ms: f64| ms * 1e6 / n_items as f64;
    println!(
        "{what:44} median {median:8.3} ms  least {least:8.3} ms  {:8.2} / {:.2} ns per {item}",
        per_item(median),
        per_item(least)
    );
}

fn main() {
    let mut work = Work::office();
    for n in [1000, 10_000] {
        let pairs = n * filter_work::N_BEAMS;
        let mut field = work.weights(&FieldModel::default(), n);
        report(&format!("likelihood field, {n} x 181"), pairs, "particle-beam", || field.run());
    }
    let mut beam = work.weights(&BeamModel { z_max_range_m: 20.0, ..BeamModel::default() }, 10_000);
    report("beam model, 10000 x 181", 10_000 * filter_work::N_BEAMS, "particle-beam", || beam.run());
    report("whole step, 10000 particles, 181 beams", 1, "step", || work.step(181));
    report("whole step, 10000 particles, 60 beams", 1, "step", || work.step(60));
    report("new map of 1000 x 1000 cells", 1_000_000, "cell", || work.new_map());
}
