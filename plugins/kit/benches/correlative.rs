//! Branch and bound over a map of 400 x 400 cells of 5 cm: around a guess (+-2 m, +-20 degrees) and knowing nothing
//! (everywhere, all around), with 180 points. And the table that both need.
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_kit::GridSize;
use rumbo_kit::correlative::{CorrelativeSearch, FitTable, SearchWindow, turn_step_rad};
use rumbo_kit::generated_world::GeneratedWorld;
use std::f64::consts::PI;

const RESOLUTION_M: f64 = 0.05;
const N_CELLS: usize = 400;

fn main() {
    divan::main();
}

fn table(world: &GeneratedWorld) -> FitTable {
    FitTable::around_marks(world.size, RESOLUTION_M, &world.occupied, 0.08, 8)
}

/// Where beams from a free place end.
fn scan(world: &GeneratedWorld, grid_from_base: &Pose2) -> Vec<Point2> {
    let is_free = |point: Point2| {
        let cell = point / RESOLUTION_M;
        let GridSize { width, .. } = world.size;
        let inside = cell.x >= 0.0 && cell.y >= 0.0 && cell.x < width as f64 && cell.y < width as f64;
        inside && world.occupied[world.size.index(cell.x as usize, cell.y as usize)] == 0
    };
    (0..180)
        .filter_map(|beam| {
            let bearing = f64::from(beam) * PI / 180.0;
            let along = |k: i32| Point2::new(bearing.cos(), bearing.sin()) * (f64::from(k) * 0.01);
            (1..2000).map(along).find(|point| !is_free(grid_from_base * point))
        })
        .collect()
}

#[divan::bench]
fn table_of_map(bencher: divan::Bencher) {
    let world = GeneratedWorld::indoor(N_CELLS, 5);
    bencher.bench_local(|| table(&world));
}

#[divan::bench(args = [(2.0, 20.0), (10.0, 180.0)])]
fn search(bencher: divan::Bencher, (reach_m, reach_deg): (f64, f64)) {
    let world = GeneratedWorld::indoor(N_CELLS, 5);
    let table = table(&world);
    let truth = pose2(6.0, 8.0, 0.4);
    let points = scan(&world, &truth);
    let middle = if reach_deg < 180.0 { pose2(7.1, 7.2, 0.6) } else { pose2(10.0, 10.0, 0.0) };
    let window = SearchWindow {
        grid_from_base: middle,
        reach_m,
        reach_rad: f64::to_radians(reach_deg),
        step_rad: turn_step_rad(&points, RESOLUTION_M),
        least_score: 0.5,
        most_nodes: usize::MAX,
    };
    let mut search = CorrelativeSearch::default();
    bencher.bench_local(|| search.best(&table, &points, &window, None));
}
