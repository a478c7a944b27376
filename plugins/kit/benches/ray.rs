//! Rays on the generated 1000 x 1000 map. Bar: 40 ns a ray, goal 27.
use rumbo_kit::generated_world::GeneratedWorld;
use rumbo_kit::ray::{Ray, RayGrid};

fn main() {
    divan::main();
}

/// Origins in free space, spread over the map by a fixed stride.
fn origins(world: &GeneratedWorld) -> Vec<(f64, f64)> {
    let free = (0..world.size.n_cells()).step_by(9973).filter(|&i| world.occupied[i] == 0);
    free.map(|i| world.size.col_row(i)).map(|(col, row)| (col as f64 + 0.37, row as f64 + 0.61)).collect()
}

const RANGE_CELLS: f64 = 400.0;
const N_BEAMS: usize = 361;

fn angles() -> Vec<f64> {
    (0..N_BEAMS).map(|i| i as f64 * std::f64::consts::TAU / N_BEAMS as f64).collect()
}

#[divan::bench]
fn single_rays(bencher: divan::Bencher) {
    let world = GeneratedWorld::indoor(1000, 4242);
    let grid = RayGrid::new(world.size, &world.occupied);
    let origins = origins(&world);
    let rays: Vec<Ray> = origins
        .iter()
        .flat_map(|&(x, y)| angles().into_iter().map(move |a| Ray::at_angle(x, y, a)))
        .collect();
    bencher
        .counter(divan::counter::ItemsCount::new(rays.len()))
        .bench_local(|| rays.iter().map(|ray| grid.cast(ray, RANGE_CELLS)).sum::<f64>());
}

#[divan::bench]
fn fans_of_361(bencher: divan::Bencher) {
    let world = GeneratedWorld::indoor(1000, 4242);
    let grid = RayGrid::new(world.size, &world.occupied);
    let origins = origins(&world);
    let directions: Vec<[f64; 2]> = angles().iter().map(|a| [a.cos(), a.sin()]).collect();
    let mut distances = vec![0.0; N_BEAMS];
    bencher.counter(divan::counter::ItemsCount::new(origins.len() * N_BEAMS)).bench_local(|| {
        for &(x, y) in &origins {
            grid.cast_fan([x, y], 0.3, &directions, RANGE_CELLS, &mut distances);
        }
        distances[0]
    });
}

#[divan::bench]
fn prepare_1000x1000(bencher: divan::Bencher) {
    let world = GeneratedWorld::indoor(1000, 4242);
    bencher
        .counter(divan::counter::ItemsCount::new(world.size.n_cells()))
        .bench_local(|| RayGrid::new(world.size, &world.occupied));
}
