//! The filter against the definition, cell by cell and landmark by landmark.

use super::super::band::{Band, entry};
use super::super::order::CellOrder;
use super::super::regions::RegionIndex;
use super::*;
use crate::GridSize;

/// The definition: the share of a cell's landmarks that look like an observed one.
fn brute_force(cells: &[Vec<Look>], observed: &[Look], within: &Similarity) -> Vec<CellScore> {
    let score = |(cell, looks): (usize, &Vec<Look>)| {
        let is_alike = |look: &&Look| observed.iter().any(|seen| within.holds(seen, &look.rounded()));
        let n_alike = looks.iter().filter(is_alike).count() as u16;
        CellScore { cell, n_alike, n_landmarks: looks.len() as u16 }
    };
    let scores: Vec<CellScore> =
        cells.iter().enumerate().map(score).filter(|score| score.n_landmarks >= 2).collect();
    let share = |score: &CellScore| f64::from(score.n_alike) / f64::from(score.n_landmarks);
    let best = scores.iter().map(share).fold(0.0, f64::max);
    scores.into_iter().filter(|score| share(score) > 0.5 * best + 1e-12).collect()
}

#[test]
fn the_index_finds_what_a_look_at_every_cell_finds() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut filter = Filter::default();
    let mut n_passed = 0;
    for seed in 0..4 {
        let grid = random_map(64 - 9 * seed as u32, 40, 10 + seed);
        let (model, surroundings) = (model_of(&grid), Surroundings::new(&grid));
        let mut tracer = Tracer::new(SETTINGS);
        let mut looks_of = |cell: usize| match surroundings.is_free(cell) {
            true => tracer.looks_of(&surroundings, cell).collect(),
            false => Vec::new(),
        };
        let cells: Vec<Vec<Look>> = (0..surroundings.size().n_cells()).map(&mut looks_of).collect();
        for _ in 0..30 {
            let mut observed = cells[rng.random_range(0..cells.len())].clone();
            for look in &mut observed {
                look.distance_m += rng.random_range(-0.1..0.1);
                look.extent_m += rng.random_range(-0.2..0.2);
            }
            let within = Similarity {
                distance_m: rng.random_range(0.01..0.15),
                extent_m: rng.random_range(0.02..0.3),
            };
            let expected = brute_force(&cells, &observed, &within);
            n_passed += expected.len();
            assert_eq!(filter.pass(&model, &observed, &within), expected, "map {seed}");
        }
    }
    assert!(n_passed > 1000, "{n_passed}");
}

fn look(row: &toml::Value) -> Look {
    let kind = match row[0].as_str().unwrap() {
        "wall" => LookKind::Wall,
        "disc_i" => LookKind::HidesLeft,
        "disc_d" => LookKind::HidesRight,
        other => panic!("{other}"),
    };
    let [distance_m, extent_m] = [1, 3].map(|idx| row[idx].as_float().unwrap());
    Look { kind, distance_m, extent_m }
}

/// A model of cells in a row that see these.
fn model_of_looks(cells: &[Vec<Look>]) -> LandmarkModel {
    let size = GridSize::new(cells.len(), 1);
    let order = CellOrder::new(size);
    let mut n_landmarks = vec![0; order.n_places()];
    let mut entries = Vec::new();
    for (cell, looks) in cells.iter().enumerate() {
        n_landmarks[order.place_of(cell)] = looks.len() as u8;
        entries.extend(looks.iter().map(|look| entry(*look, order.place_of(cell) as u32)));
    }
    assert!(n_landmarks.len() <= band_places(n_landmarks.len()));
    let regions = RegionIndex::default();
    LandmarkModel { size, order, n_landmarks, bands: vec![Band::of(entries)], regions }
}

#[test]
fn cells_of_the_printed_example_stay_only_strictly_above_half_of_the_best() {
    let file: toml::Table =
        toml::from_str(include_str!("../../../tests/data/natural_landmark/table7_1_relaxation.toml"))
            .unwrap();
    let looks = |rows: &toml::Value| rows.as_array().unwrap().iter().map(look).collect::<Vec<Look>>();
    let (geometry, expected) = (&file["geometry"], &file["initial_filter"]);
    let observed = looks(&geometry["observed"]);
    let cells = [looks(&geometry["model"]), looks(&expected["cell_b"]), looks(&expected["cell_c"])];
    let within = Similarity {
        distance_m: geometry["attribute_tolerance_d"].as_float().unwrap(),
        extent_m: geometry["attribute_tolerance_p"].as_float().unwrap(),
    };
    let printed = expected["cells"].as_array().unwrap();
    let mut filter = Filter::default();
    let passed = filter.pass(&model_of_looks(&cells), &observed, &within);
    let kept: Vec<usize> = (0..3).filter(|cell| printed[*cell]["kept"].as_bool() == Some(true)).collect();
    assert_eq!(passed.iter().map(|score| score.cell).collect::<Vec<usize>>(), kept);
    // Each cell for itself: it is the best then, and its counts are told.
    for (cell, printed) in cells.iter().zip(printed) {
        let model = model_of_looks(std::slice::from_ref(cell));
        let score = filter.pass(&model, &observed, &within)[0];
        let counts = [score.n_alike, score.n_landmarks].map(i64::from);
        assert_eq!(counts, ["matched", "landmarks"].map(|key| printed[key].as_integer().unwrap()));
    }
    // One more landmark that fits, and the third cell has 4 of 7: strictly more than half.
    let mut better = cells.clone();
    better[2].push(observed[0]);
    let passed = filter.pass(&model_of_looks(&better), &observed, &within);
    assert_eq!(passed.iter().map(|score| score.cell).collect::<Vec<usize>>(), [0, 2]);
}

#[test]
fn nothing_observed_and_what_is_no_number_pass_nothing() {
    let model = model_of(&random_map(40, 40, 3));
    let within = Similarity { distance_m: 0.1, extent_m: 0.1 };
    let mut filter = Filter::default();
    assert!(filter.pass(&model, &[], &within).is_empty());
    for (distance_m, extent_m) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::INFINITY, 1.0), (-9.0, 1.0)] {
        let odd = Look { kind: LookKind::Wall, distance_m, extent_m };
        filter.pass(&model, &[odd], &within);
    }
}
