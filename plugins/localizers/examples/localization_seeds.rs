//! Statistics of the particle filter in the rubble loop: found from anywhere, followed, found again when carried away.
//!
//! `cargo run --release -p rumbo-localizers --example localization_seeds [seeds [params]]`
#![allow(clippy::print_stdout, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../tests/loop_world/mod.rs"]
mod loop_world;

use loop_world::{GlobalRun, LoopWorld, global_run, tracking_rms_m};
use rumbo_localizers::particle_filter::ParticleFilterParams;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let n: u64 = arguments.next().map_or(100, |word| word.parse().expect("a number of seeds"));
    let text = arguments.next().unwrap_or_default();
    let params: ParticleFilterParams = toml::from_str(&text).expect("parameters of the particle filter");
    let world = LoopWorld::load();
    let runs: Vec<GlobalRun> = (1..=n).map(|seed| global_run(&world, &params, seed)).collect();
    let count = |is: fn(&GlobalRun) -> bool| runs.iter().filter(|run| is(run)).count();
    println!(
        "within 0.3 m after 10 updates and for the rest: {} of {n}",
        count(|run| run.worst_after_ten_m <= 0.3)
    );
    println!(
        "recovered within 15 updates: {} of {n}",
        count(|run| run.recovered_after.is_some_and(|n| n <= 15))
    );
    quantiles("updates to recover", runs.iter().map(|run| run.recovered_after.map_or(99.0, |n| n as f64)));
    quantiles("rms after 10 updates, m", runs.iter().map(|run| run.rms_m));
    quantiles("usual particles after convergence", runs.iter().map(|run| run.usual_particles as f64));
    quantiles("rms from a known pose, m", (1..=n).map(|seed| tracking_rms_m(&world, &params, seed)));
}

fn quantiles(what: &str, values: impl Iterator<Item = f64>) {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
    println!("{what}: median {:.3}, 95 % {:.3}, most {:.3}", at(0.5), at(0.95), at(1.0));
}
