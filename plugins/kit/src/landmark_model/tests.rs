mod files;
mod filters;
mod large_maps;
mod scans;

use super::build::band_places;
use super::*;
use crate::landmarks::LandmarkSettings;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::map::Grid;
use rumbo_core::stages::GiveUp;

const SETTINGS: ModelSettings = ModelSettings {
    n_rays: 180,
    range_m: 4.0,
    landmarks: LandmarkSettings {
        discontinuity_m: 0.20,
        corner_m: 0.15,
        wall_m: 0.30,
        least_readings: 5,
        wall_fit: crate::landmarks::WallFit::Tls,
        spares_grazed_walls: true,
        range_deviation_m: 0.015,
    },
};

/// Boxes here and there, and some that nobody looked into.
fn random_map(width: u32, height: u32, seed: u64) -> Grid {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut grid = Grid::unknown(width, height, 0.1).unwrap();
    let cells = grid.cells.make_mut();
    cells.fill(-Grid::CERTAIN);
    for k in 0..width * height / 150 {
        let [col, row] = [width, height].map(|n| rng.random_range(0..n));
        let [wide, high] = [0; 2].map(|_| rng.random_range(1..9));
        for row in row..(row + high).min(height) {
            for col in col..(col + wide).min(width) {
                cells[(row * width + col) as usize] = if k % 5 == 4 { 0.0 } else { Grid::CERTAIN };
            }
        }
    }
    grid
}

fn model_of(grid: &Grid) -> LandmarkModel {
    let surroundings = Surroundings::new(grid);
    LandmarkModel::build(&surroundings, &SETTINGS, &Progress::default(), &GiveUp::default()).unwrap()
}

#[test]
fn any_number_of_threads_and_parts_give_the_same_model() {
    let grid = random_map(70, 45, 1);
    let model = model_of(&grid);
    assert!(model.n_landmarks() > 10_000, "{}", model.n_landmarks());
    for n_threads in [1, 2, 5] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        assert!(pool.install(|| model_of(&grid)) == model, "{n_threads} threads");
    }
    let surroundings = Surroundings::new(&grid);
    for n_places in [1000, 1024, 4097] {
        let (mut builder, progress) = (ModelBuilder::new(&surroundings), Progress::default());
        let mut n_parts = 0;
        while !builder.is_done() {
            assert!(progress.share() < 1.0);
            builder.go_on(&surroundings, &SETTINGS, n_places, &progress, &GiveUp::default());
            n_parts += 1;
        }
        assert_eq!(n_parts, model.n_landmarks.len().div_ceil(n_places));
        assert_eq!(progress.share(), 1.0);
        assert!(builder.finish().unwrap() == model, "parts of {n_places}");
    }
}

#[test]
fn what_was_asked_to_give_up_gives_no_model() {
    let surroundings = Surroundings::new(&random_map(70, 45, 1));
    let give_up = GiveUp::default();
    give_up.raise();
    assert!(LandmarkModel::build(&surroundings, &SETTINGS, &Progress::default(), &give_up).is_none());
}

#[test]
fn cells_have_as_many_landmarks_as_are_traced_from_them_and_others_none() {
    let grid = random_map(50, 40, 2);
    let (model, surroundings) = (model_of(&grid), Surroundings::new(&grid));
    let mut tracer = Tracer::new(SETTINGS);
    let (mut n_cells, mut n_landmarks) = (0, 0);
    for cell in 0..2000 {
        let is_free = grid.class_of(grid.cells[cell]) == rumbo_core::map::CellClass::Free;
        assert_eq!(surroundings.is_free(cell), is_free);
        let n = if is_free { tracer.looks_of(&surroundings, cell).count() } else { 0 };
        assert_eq!(model.n_landmarks_of(cell), n);
        n_cells += usize::from(n > 0);
        n_landmarks += n;
    }
    assert_eq!((model.n_cells(), model.n_landmarks()), (n_cells, n_landmarks));
    assert!(!surroundings.is_free(2000) && model.n_landmarks_of(usize::MAX / 4) == 0);
}

#[test]
fn maps_without_anything_to_see_have_empty_models() {
    for (width, height, value) in
        [(1, 1, -Grid::CERTAIN), (1, 1, 0.0), (1, 1, Grid::CERTAIN), (40, 3, 0.0), (30, 30, -Grid::CERTAIN)]
    {
        let mut grid = Grid::unknown(width, height, 0.05).unwrap();
        grid.cells.make_mut().fill(value);
        let model = model_of(&grid);
        assert_eq!((model.n_cells(), model.n_landmarks()), (0, 0));
        assert_eq!(model.size().n_cells(), (width * height) as usize);
        let anything = Look { kind: LookKind::Wall, distance_m: 1.0, extent_m: 1.0 };
        let within = Similarity { distance_m: 1.0, extent_m: 1.0 };
        assert!(Filter::default().pass(&model, &[anything], &within).is_empty());
    }
}

#[test]
fn memory_is_little_more_than_two_bytes_a_landmark() {
    // Straight walls, as in offices: what neighbors see differs little.
    let mut grid = Grid::unknown(200, 200, 0.05).unwrap();
    let cells = grid.cells.make_mut();
    cells.fill(-Grid::CERTAIN);
    for k in 0..200 {
        for idx in [k, 199 * 200 + k, k * 200, k * 200 + 199, 80 * 200 + k / 2] {
            cells[idx] = Grid::CERTAIN;
        }
        if k > 120 {
            cells[k * 200 + 100] = Grid::CERTAIN;
        }
    }
    let model = model_of(&grid);
    let bytes_each = model.n_bytes() as f64 / model.n_landmarks() as f64;
    assert!(bytes_each < 2.8, "{bytes_each} bytes for each of {} landmarks", model.n_landmarks());
}
