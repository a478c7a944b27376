//! Global localization in the office of 480 x 580 cells and the smaller ones. Bars: 2, 5 and 10 ms for the filter, 5 ms for
//! relaxation, least squares and refinement.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod relocalization_work;

use relocalization_work::{Laser, Office};
use rumbo_core::rng::stream;
use rumbo_kit::landmark_model::CellScore;
use rumbo_kit::landmarks::{Extractor, Landmark};
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;
use rumbo_localizers::landmark_relaxation::locator::Locator;
use rumbo_localizers::landmark_relaxation::matching::{Knowledge, Matcher};
use rumbo_localizers::landmark_relaxation::panorama::Panorama;
use rumbo_localizers::landmark_relaxation::sighting::Sighting;

fn main() {
    divan::main();
}

const N_PLACES: u64 = 20;

/// A map, and what is seen from some of its places.
struct Work {
    params: LandmarkRelaxationParams,
    known: Knowledge,
    seen: Vec<Vec<Sighting>>,
    observed: Vec<Vec<Landmark>>,
}

impl Work {
    fn of(name: &str) -> Work {
        let params = LandmarkRelaxationParams::default();
        let office = Office::named(name);
        let known = office.knowledge(&params);
        let look = |seed: u64| {
            let mut rng = stream(seed, "relocalization");
            let pose = office.pose(&mut rng);
            Laser::lms200().look_around(&office, &pose, &[], 0.0, &mut rng)
        };
        let seen: Vec<Vec<Sighting>> = (0..N_PLACES).map(look).collect();
        let mut extractor = Extractor::new(params.model().landmarks);
        let observed =
            seen.iter().map(|seen| Panorama::of(seen, 360).landmarks(&mut extractor, 8.0)).collect();
        Work { params, known, seen, observed }
    }

    fn matcher(&self) -> Matcher {
        Matcher::new(self.params.locator().matching)
    }
}

#[divan::bench(args = ["5x5", "10x10", "20x20"], sample_count = 20, sample_size = 1)]
fn filter(bencher: divan::Bencher, name: &str) {
    let work = Work::of(name);
    let mut matcher = work.matcher();
    let count = divan::counter::ItemsCount::new(N_PLACES);
    bencher.counter(count).bench_local(|| {
        work.observed.iter().map(|observed| matcher.cells(&work.known, observed).len()).sum::<usize>()
    });
}

#[divan::bench(args = ["5x5", "10x10", "20x20"], sample_count = 20, sample_size = 1)]
fn second_phase(bencher: divan::Bencher, name: &str) {
    let work = Work::of(name);
    let mut matcher = work.matcher();
    let cells: Vec<Vec<CellScore>> =
        work.observed.iter().map(|observed| matcher.cells(&work.known, observed)).collect();
    let count = divan::counter::ItemsCount::new(N_PLACES);
    bencher.counter(count).bench_local(|| {
        let places = work.observed.iter().zip(&cells);
        places.map(|(observed, cells)| matcher.places(&work.known, cells, observed).len()).sum::<usize>()
    });
}

#[divan::bench(args = ["5x5", "10x10", "20x20"], sample_count = 20, sample_size = 1)]
fn whole(bencher: divan::Bencher, name: &str) {
    let work = Work::of(name);
    let mut locator = Locator::new(work.params.locator(), stream(1, "noise"));
    let count = divan::counter::ItemsCount::new(N_PLACES);
    bencher.counter(count).bench_local(|| {
        work.seen.iter().map(|seen| locator.locate(&work.known, seen, None)).collect::<Vec<_>>()
    });
}
