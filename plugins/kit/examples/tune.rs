#![allow(clippy::print_stdout, missing_docs)]
use rumbo_kit::GridSize;
use rumbo_kit::cost_field::*;
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::generated_world::*;
fn cpu() -> f64 {
    let s = std::fs::read_to_string("/proc/self/schedstat").unwrap();
    s.split(' ').next().unwrap().parse::<f64>().unwrap() * 1e-9
}
fn main() {
    for (n, indoor, seed) in [(2000usize, true, 2042u64), (2000, false, 2007), (4000, true, 4042)] {
        let world =
            if indoor { GeneratedWorld::indoor(n, seed) } else { GeneratedWorld::open_ground(n, seed) };
        let costs = world.inflated(&squared_distance_field(world.size, &world.occupied));
        let (start, goal) = query_cells(world.size, &costs);
        let entries = entry_costs(&costs);
        let mut field = CostField::new();
        for cutting in [true, false] {
            field.set_entry_costs(
                world.size,
                &entries,
                StepRule { corner_cutting: cutting, ..StepRule::default() },
            );
            let mut best = f64::MAX;
            let mut bq = f64::MAX;
            let mut nt = 0;
            let mut nq = 0;
            for _ in 0..7 {
                let t = cpu();
                field.grow(goal, Until::Query(start), || false).unwrap();
                nq = field.n_settled_tiles();
                bq = bq.min((cpu() - t));
                let t = cpu();
                field.grow(goal, Until::Everywhere, || false).unwrap();
                nt = field.n_settled_tiles();
                best = best.min((cpu() - t));
            }
            let reached = field.to_vec().iter().filter(|c| c.is_finite()).count();
            let tiles = n.div_ceil(32).pow(2);
            println!(
                "{n} indoor {indoor} cutting {cutting}: {:.2} ms {:.2} ns/cell, {:.2} solves/tile {:.0} ns/solve; query {:.2} ms {nq} tiles",
                best * 1e3,
                best * 1e9 / reached as f64,
                nt as f64 / tiles as f64,
                best * 1e9 / nt as f64,
                bq * 1e3
            );
        }
        let _ = GridSize::new(1, 1);
    }
}
