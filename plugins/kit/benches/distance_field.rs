//! Exact Euclidean distance field on the generated maps. Bar: 16 ns a cell, goal 5.
use rumbo_kit::distance_field::squared_distance_field_into;
use rumbo_kit::generated_world::GeneratedWorld;

fn main() {
    divan::main();
}

#[divan::bench(args = ["indoor 2000", "open 2000", "indoor 4000"])]
fn distance_field(bencher: divan::Bencher, map: &str) {
    let world = match map {
        "indoor 2000" => GeneratedWorld::indoor(2000, 2042),
        "open 2000" => GeneratedWorld::open_ground(2000, 2007),
        _ => GeneratedWorld::indoor(4000, 4042),
    };
    let mut field = vec![0; world.size.n_cells()];
    bencher
        .counter(divan::counter::ItemsCount::new(world.size.n_cells()))
        .bench_local(|| squared_distance_field_into(world.size, &world.occupied, &mut field));
}
