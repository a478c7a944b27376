//! Maps of which the filter looks at parts only.

use super::super::regions::RegionIndex;
use super::*;
use crate::landmark_model::CellScore;

/// Rooms far from each other, of which nobody knows what lies between them; with boxes, each in its own way.
fn rooms() -> Grid {
    let (width, height) = (1100_u32, 512);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
    let mut grid = Grid::unknown(width, height, 0.1).unwrap();
    let cells = grid.cells.make_mut();
    let mut fill = |[left, lower, wide, high]: [u32; 4], value: f32| {
        for row in lower..lower + high {
            cells[(row * width + left) as usize..][..wide as usize].fill(value);
        }
    };
    for [left, lower] in [[10, 20], [400, 30], [900, 60], [60, 250], [500, 300], [950, 420]] {
        fill([left - 1, lower - 1, 52, 42], Grid::CERTAIN);
        fill([left, lower, 50, 40], -Grid::CERTAIN);
        for _ in 0..7 {
            let [wide, high] = [0; 2].map(|_| rng.random_range(2..9));
            let [x, y] = [rng.random_range(0..50 - wide), rng.random_range(0..40 - high)];
            fill([left + x, lower + y, wide, high], Grid::CERTAIN);
        }
    }
    grid
}

#[test]
fn of_a_large_map_few_parts_are_looked_at_and_there_all_cells_that_the_definition_names_are_found() {
    let grid = rooms();
    let (model, surroundings) = (model_of(&grid), Surroundings::new(&grid));
    assert!(!model.regions.is_empty() && model.bands.len() == 9);
    // The same model without the index looks at everything: the definition, by the test of small maps.
    let whole = LandmarkModel { regions: RegionIndex::default(), ..model.clone() };
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(13);
    let (mut tracer, mut filter) = (Tracer::new(SETTINGS), Filter::default());
    let within = Similarity { distance_m: 0.075, extent_m: 0.15 };
    let n_cells = model.size().n_cells();
    let (mut n_tried, mut n_parts) = (0, 0);
    while n_tried < 40 {
        let cell = rng.random_range(0..n_cells);
        if model.n_landmarks_of(cell) < 8 {
            continue;
        }
        n_tried += 1;
        let mut observed: Vec<Look> = tracer.looks_of(&surroundings, cell).collect();
        for look in &mut observed {
            look.distance_m += rng.random_range(-0.05..0.05);
            look.extent_m += rng.random_range(-0.1..0.1);
        }
        let all = filter.pass(&whole, &observed, &within).to_vec();
        assert_eq!(filter.n_parts(), [9, 9]);
        let passed = filter.pass(&model, &observed, &within);
        let is_same = |score: &CellScore| all.contains(score);
        assert!(passed.iter().all(is_same) && passed.iter().any(|score| score.cell == cell));
        n_parts += filter.n_parts()[0];
    }
    // Every part has one of the rooms, and every room lies in two or three of them.
    assert!(3 * n_parts < 2 * 9 * n_tried, "{n_parts} parts of {} for {n_tried} places", 9 * n_tried);
}

#[test]
fn models_of_large_maps_are_the_same_from_parts_and_from_files() {
    let grid = rooms();
    let (model, surroundings) = (model_of(&grid), Surroundings::new(&grid));
    let mut builder = ModelBuilder::new(&surroundings);
    while !builder.is_done() {
        builder.go_on(&surroundings, &SETTINGS, 100_001, &Progress::default(), &GiveUp::default());
    }
    assert!(builder.finish().unwrap() == model);
    let path = std::env::temp_dir().join(format!("rumbo-large-{}.landmark_model", std::process::id()));
    let print = fingerprint(&grid, &SETTINGS);
    save_model(&path, &model, &print).unwrap();
    let read = load_model(&path, &print).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert!(read == model);
}
