mod making;
mod panoramas;
mod refining;
mod table_7_1;

use rumbo_core::map::{Grid, GridHeader};
use rumbo_core::stages::GiveUp;
use rumbo_kit::GridSize;
use rumbo_kit::landmark_model::{LandmarkModel, Progress, Surroundings};

use super::matching::Knowledge;
use super::params::LandmarkRelaxationParams;

const CELL_M: f64 = 0.05;

/// A room of 5 m by 4 m with a box in a corner of it and a niche.
fn room(origin: [f64; 3]) -> Grid {
    let size = GridSize::new(102, 82);
    let mut cells = vec![-Grid::CERTAIN; size.n_cells()];
    let mut fill = |cols: std::ops::Range<usize>, rows: std::ops::Range<usize>| {
        for row in rows {
            for col in cols.clone() {
                cells[size.index(col, row)] = Grid::CERTAIN;
            }
        }
    };
    fill(0..102, 0..1);
    fill(0..102, 81..82);
    fill(0..1, 0..82);
    fill(101..102, 0..82);
    fill(70..86, 55..65);
    fill(1..13, 60..81);
    let header = GridHeader {
        width: 102,
        height: 82,
        resolution_m: CELL_M,
        origin,
        occupied_above: Grid::OCCUPIED_ABOVE,
        free_below: Grid::FREE_BELOW,
    };
    Grid::new(header, cells.into()).unwrap()
}

fn knowledge(grid: &Grid) -> Knowledge {
    let surroundings = Surroundings::new(grid);
    let settings = LandmarkRelaxationParams::default().model();
    let model =
        LandmarkModel::build(&surroundings, &settings, &Progress::default(), &GiveUp::default()).unwrap();
    Knowledge { grid: grid.clone(), surroundings, model }
}
