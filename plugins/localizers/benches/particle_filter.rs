//! The particle filter's weights and whole step. Bars: 1.5 ns a particle-beam by the likelihood field (goal 0.8), 40 ns
//! by the beam model (goal 28), 5 ms a step of 10,000 particles (goal 2.5).
#![allow(clippy::expect_used)]

mod filter_work;

use filter_work::{N_BEAMS, Work};
use rumbo_localizers::particle_filter::measurement::{BeamModel, FieldModel};

fn main() {
    divan::main();
}

#[divan::bench(args = [1000, 10_000])]
fn likelihood_field(bencher: divan::Bencher, n: usize) {
    let mut weights = Work::office().weights(&FieldModel::default(), n);
    bencher.counter(divan::counter::ItemsCount::new(n * N_BEAMS)).bench_local(|| weights.run());
}

#[divan::bench(sample_count = 20)]
fn beam_model(bencher: divan::Bencher) {
    let model = BeamModel { z_max_range_m: 20.0, ..BeamModel::default() };
    let mut weights = Work::office().weights(&model, 1000);
    bencher.counter(divan::counter::ItemsCount::new(1000 * N_BEAMS)).bench_local(|| weights.run());
}

#[divan::bench(args = [60, 181])]
fn whole_step(bencher: divan::Bencher, n_beams: usize) {
    let mut work = Work::office();
    bencher.bench_local(|| work.step(n_beams));
}

#[divan::bench]
fn new_map(bencher: divan::Bencher) {
    let mut work = Work::office();
    bencher.bench_local(|| work.new_map());
}
