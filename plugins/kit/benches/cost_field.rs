//! Cost-to-goal fields on the generated maps. Bar: 20 ns per reached cell, goals 10 (2000²) and 12 (4000²).
use rumbo_kit::cost_field::{CostField, StepRule, Until};
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::generated_world::{GeneratedWorld, entry_costs, query_cells};

fn main() {
    divan::main();
}

fn world(map: &str) -> (GeneratedWorld, Vec<u8>) {
    let world = match map {
        "indoor 2000" => GeneratedWorld::indoor(2000, 2042),
        "open 2000" => GeneratedWorld::open_ground(2000, 2007),
        "indoor 4000" => GeneratedWorld::indoor(4000, 4042),
        _ => GeneratedWorld::open_ground(4000, 4007),
    };
    let costs = world.inflated(&squared_distance_field(world.size, &world.occupied));
    (world, costs)
}

const MAPS: [&str; 4] = ["indoor 2000", "open 2000", "indoor 4000", "open 4000"];

#[divan::bench(args = MAPS, sample_count = 10)]
fn whole_field(bencher: divan::Bencher, map: &str) {
    let (world, costs) = world(map);
    let (_, goal) = query_cells(world.size, &costs);
    let mut field = CostField::new();
    field.set_entry_costs(
        world.size,
        &entry_costs(&costs),
        StepRule { corner_cutting: true, ..StepRule::default() },
    );
    field.grow(goal, Until::Everywhere, || false).ok();
    let n_reached = field.to_vec().iter().filter(|c| c.is_finite()).count();
    bencher
        .counter(divan::counter::ItemsCount::new(n_reached))
        .bench_local(|| field.grow(goal, Until::Everywhere, || false));
}

#[divan::bench(args = MAPS, sample_count = 10)]
fn query(bencher: divan::Bencher, map: &str) {
    let (world, costs) = world(map);
    let (start, goal) = query_cells(world.size, &costs);
    let mut field = CostField::new();
    field.set_entry_costs(world.size, &entry_costs(&costs), StepRule::default());
    bencher.bench_local(|| field.grow(goal, Until::Query(start), || false));
}

#[divan::bench(args = MAPS, sample_count = 10)]
fn set_entry_costs(bencher: divan::Bencher, map: &str) {
    let (world, costs) = world(map);
    let entries = entry_costs(&costs);
    let mut field = CostField::new();
    bencher
        .counter(divan::counter::ItemsCount::new(world.size.n_cells()))
        .bench_local(|| field.set_entry_costs(world.size, &entries, StepRule::default()));
}
