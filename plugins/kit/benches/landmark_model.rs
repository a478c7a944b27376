//! Building landmark models of the three office maps. Bars: 5, 20 and 120 s.
#![allow(clippy::expect_used)]

use rumbo_core::map::Grid;
use rumbo_core::stages::GiveUp;
use rumbo_kit::landmark_model::{LandmarkModel, ModelSettings, Progress, Surroundings};
use rumbo_kit::landmarks::LandmarkSettings;
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, load_map};
use std::path::Path;

fn main() {
    divan::main();
}

fn grid(name: &str) -> Grid {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines/worlds");
    let image = load_map(&folder.join(format!("natural_landmark_{name}.yaml")), DEFAULT_MAX_CELLS)
        .expect("the map is shipped");
    let mut grid = Grid::unknown(image.width as u32, image.height as u32, image.resolution_m)
        .expect("the map has cells");
    for (cell, percent) in grid.cells.make_mut().iter_mut().zip(&image.cells) {
        *cell = if *percent > 50 { Grid::CERTAIN } else { -Grid::CERTAIN };
    }
    grid
}

const SETTINGS: ModelSettings = ModelSettings {
    n_rays: 360,
    range_m: 8.0,
    landmarks: LandmarkSettings {
        discontinuity_m: 0.20,
        corner_m: 0.15,
        wall_m: 0.30,
        least_readings: 5,
        wall_fit: rumbo_kit::landmarks::WallFit::Tls,
        spares_grazed_walls: true,
        range_deviation_m: 0.015,
    },
};

#[divan::bench(args = ["5x5", "10x10", "20x20"], sample_count = 3, sample_size = 1)]
fn build(bencher: divan::Bencher, name: &str) {
    let surroundings = Surroundings::new(&grid(name));
    let n_free = (0..surroundings.size().n_cells()).filter(|cell| surroundings.is_free(*cell)).count();
    bencher.counter(divan::counter::ItemsCount::new(n_free)).bench_local(|| {
        LandmarkModel::build(&surroundings, &SETTINGS, &Progress::default(), &GiveUp::default())
            .map(|model| (model.n_bytes(), model.n_landmarks()))
    });
}
