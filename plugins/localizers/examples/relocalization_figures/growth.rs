//! How work grows with the map: offices of 250 x 250 to 2000 x 2000 cells, all rooms different.

use super::relocalization_work::{Laser, Office};
use rumbo_core::frames::Pose2;
use rumbo_core::rng::stream;
use rumbo_kit::landmark_model::CellScore;
use rumbo_kit::landmarks::{Extractor, Landmark};
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;
use rumbo_localizers::landmark_relaxation::locator::{Locator, Verdict};
use rumbo_localizers::landmark_relaxation::matching::{Knowledge, Matcher};
use rumbo_localizers::landmark_relaxation::panorama::Panorama;
use rumbo_localizers::landmark_relaxation::sighting::Sighting;
use rustix::time::{ClockId, clock_gettime};

/// Places on each map.
const N_PLACES: u64 = 30;
/// Rounds over all places, of which the fastest counts.
const N_ROUNDS: usize = 9;

/// Maps of these edges, or of all four.
pub fn run(edges: &[String]) {
    let edges: Vec<usize> = edges.iter().map(|word| word.parse().expect("an edge in cells")).collect();
    let edges = if edges.is_empty() { vec![250, 500, 1000, 2000] } else { edges };
    let mut last: Option<(usize, f64)> = None;
    for edge in edges {
        let (n_cells, filter_ms) = measure(edge);
        if let Some((fewer, before_ms)) = last {
            let power = (filter_ms / before_ms).ln() / (n_cells as f64 / fewer as f64).ln();
            println!("     filter time grows with the number of cells to the power of {power:.2}");
        }
        last = Some((n_cells, filter_ms));
    }
}

/// Cells of the model, and milliseconds of the filter.
fn measure(edge: usize) -> (usize, f64) {
    let params = LandmarkRelaxationParams::default();
    let office = Office::generated(edge, edge as u64);
    let begun_s = processor_s(ClockId::ProcessCPUTime);
    let known = office.knowledge(&params);
    let building_s = processor_s(ClockId::ProcessCPUTime) - begun_s;
    let looks: Vec<(Pose2, Vec<Sighting>)> = (0..N_PLACES).map(|seed| look(&office, seed)).collect();
    let mut extractor = Extractor::new(params.model().landmarks);
    let observed: Vec<Vec<Landmark>> =
        looks.iter().map(|(_, seen)| Panorama::of(seen, 360).landmarks(&mut extractor, 8.0)).collect();
    let mut matcher = Matcher::new(params.locator().matching);
    let mut cells: Vec<Vec<CellScore>> = Vec::new();
    let filter_ms = fastest_ms(|| {
        cells = observed.iter().map(|observed| matcher.cells(&known, observed)).collect();
    });
    let parts = observed.iter().map(|observed| {
        matcher.cells(&known, observed);
        matcher.n_parts()
    });
    let [n_parts, of_parts] = parts.fold([0; 2], |[n, of], [parts, all]| [n + parts, of + all]);
    let second_ms = fastest_ms(|| {
        let places = observed.iter().zip(&cells);
        places.for_each(|(observed, cells)| drop(matcher.places(&known, cells, observed)));
    });
    let model = &known.model;
    let n_passed = cells.iter().map(Vec::len).sum::<usize>() as f64 / N_PLACES as f64;
    let [n_found, n_wrong] = verdicts(&params, &known, &looks);
    println!(
        "{edge} x {edge}: {} cells see {:.1} landmarks each; model {:.2} MB ({:.1} bytes a cell), built in {building_s:.1} s of a processor; \
         filter {filter_ms:.3} ms, looks at {:.1} of {} parts, {n_passed:.1} cells pass; second phase {second_ms:.3} ms; {n_found} of {N_PLACES} found, \
         {n_wrong} wrong",
        model.n_cells(),
        model.n_landmarks() as f64 / model.n_cells() as f64,
        model.n_bytes() as f64 / 1e6,
        model.n_bytes() as f64 / model.n_cells() as f64,
        n_parts as f64 / N_PLACES as f64,
        of_parts / N_PLACES as usize,
    );
    (model.n_cells(), filter_ms)
}

fn look(office: &Office, seed: u64) -> (Pose2, Vec<Sighting>) {
    let mut rng = stream(seed, "growth");
    let pose = office.pose(&mut rng);
    (pose, Laser::lms200().look_around(office, &pose, &[], 0.01, &mut rng))
}

/// Time that processors worked, which other programs on the machine change little, seconds.
fn processor_s(clock: ClockId) -> f64 {
    let time = clock_gettime(clock);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// For one place, on average, in the fastest round.
fn fastest_ms(mut round: impl FnMut()) -> f64 {
    let mut fastest_s = f64::INFINITY;
    for _ in 0..N_ROUNDS {
        let begun_s = processor_s(ClockId::ThreadCPUTime);
        round();
        fastest_s = fastest_s.min(processor_s(ClockId::ThreadCPUTime) - begun_s);
    }
    fastest_s * 1e3 / N_PLACES as f64
}

/// Places that are found within 0.10 m, and wrong ones.
fn verdicts(
    params: &LandmarkRelaxationParams,
    known: &Knowledge,
    looks: &[(Pose2, Vec<Sighting>)],
) -> [usize; 2] {
    let mut locator = Locator::new(params.locator(), stream(1, "noise"));
    let mut counts = [0; 2];
    for (pose, seen) in looks {
        if let Verdict::Found(place) = locator.locate(known, seen, None) {
            let off_m = (place.map_from_base.translation.vector - pose.translation.vector).norm();
            counts[usize::from(off_m > 0.10)] += 1;
        }
    }
    counts
}
