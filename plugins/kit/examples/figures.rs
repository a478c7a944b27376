//! The figures of `docs/benchmarks.md`: processor time of each kernel on the generated maps, median and least of
//! several runs.
//!
//! `cargo run --release -p rumbo-kit --example figures [kernel...]`; kernels are `field`, `query`, `distance`,
//! `proximity` and `ray`. Processor time, unlike the wall clock of the benches, does not count what other programs
//! take.
#![allow(clippy::print_stdout)]

use rumbo_kit::cost_field::{CostField, StepRule, Until};
use rumbo_kit::distance_field::{squared_distance_field, squared_distance_field_into};
use rumbo_kit::generated_world::{GeneratedWorld, entry_costs, query_cells};
use rumbo_kit::proximity::{CellKind, ProximityMap};
use rumbo_kit::ray::{Ray, RayGrid};
use rustix::time::{ClockId, clock_gettime};
use std::hint::black_box;

fn cpu_ms() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 * 1e3 + now.tv_nsec as f64 * 1e-6
}

fn report(what: &str, map: &str, n_items: usize, item: &str, mut run: impl FnMut()) {
    const RUNS: usize = 9;
    run();
    let mut times_ms: Vec<f64> = (0..RUNS)
        .map(|_| {
            let begin = cpu_ms();
            run();
            cpu_ms() - begin
        })
        .collect();
    times_ms.sort_by(f64::total_cmp);
    let (least, median) = (times_ms[0], times_ms[RUNS / 2]);
    let per_item = |ms: f64| ms * 1e6 / n_items as f64;
    println!(
        "{what:34} {map:12} median {median:9.2} ms  least {least:9.2} ms   {:7.2} / {:.2} ns per {item}",
        per_item(median),
        per_item(least)
    );
}

struct Bench {
    name: &'static str,
    world: GeneratedWorld,
    costs: Vec<u8>,
}

fn benches() -> Vec<Bench> {
    let bench = |name, world: GeneratedWorld| {
        let costs = world.inflated(&squared_distance_field(world.size, &world.occupied));
        Bench { name, world, costs }
    };
    vec![
        bench("indoor 2000", GeneratedWorld::indoor(2000, 2042)),
        bench("open 2000", GeneratedWorld::open_ground(2000, 2007)),
        bench("indoor 4000", GeneratedWorld::indoor(4000, 4042)),
    ]
}

fn cost_fields(bench: &Bench) {
    let (_, goal) = query_cells(bench.world.size, &bench.costs);
    let entries = entry_costs(&bench.costs);
    let mut field = CostField::new();
    for corner_cutting in [true, false] {
        let rule = StepRule { corner_cutting, ..StepRule::default() };
        field.set_entry_costs(bench.world.size, &entries, rule);
        field.grow(goal, Until::Everywhere, || false).ok();
        let n_reached = field.to_vec().iter().filter(|cost| cost.is_finite()).count();
        let what = if corner_cutting { "whole field, corners cut" } else { "whole field, no corners cut" };
        report(what, bench.name, n_reached, "reached cell", || {
            field.grow(goal, Until::Everywhere, || false).ok();
        });
    }
    report("set entry costs", bench.name, bench.world.size.n_cells(), "cell", || {
        field.set_entry_costs(bench.world.size, &entries, StepRule::default());
    });
}

fn queries(bench: &Bench) {
    let (start, goal) = query_cells(bench.world.size, &bench.costs);
    let mut field = CostField::new();
    field.set_entry_costs(bench.world.size, &entry_costs(&bench.costs), StepRule::default());
    report("A* query, path included", bench.name, 1, "query", || {
        field.grow(goal, Until::Query(start), || false).ok();
        black_box(field.cheapest_path(start));
    });
}

fn distances(bench: &Bench) {
    let GeneratedWorld { size, occupied } = &bench.world;
    let mut field = vec![0; size.n_cells()];
    report("exact Euclidean distance field", bench.name, size.n_cells(), "cell", || {
        squared_distance_field_into(*size, occupied, &mut field);
    });
}

fn proximities(bench: &Bench) {
    let size = bench.world.size;
    let kind = |&cell: &u8| if cell == 0 { CellKind::Free } else { CellKind::Obstacle };
    let kinds: Vec<CellKind> = bench.world.occupied.iter().map(kind).collect();
    let step = std::f64::consts::SQRT_2;
    let mut map = ProximityMap::new(size, &kinds, step);
    report("proximity map", bench.name, size.n_cells(), "cell", || map.recompute(size, &kinds, step));
    let (start, _) = query_cells(size, &bench.costs);
    let whole = map.clone();
    let mut n_added = 0;
    report("one more obstacle", bench.name, 1, "obstacle", || {
        map.add_obstacles(&[start + 7 * n_added]);
        n_added += 1;
    });
    black_box(whole);
}

fn rays() {
    let world = GeneratedWorld::indoor(1000, 4242);
    let grid = RayGrid::new(world.size, &world.occupied);
    let is_free = |cell: &usize| world.occupied[*cell] == 0;
    let middle = |cell: usize| {
        let (col, row) = world.size.col_row(cell);
        [col as f64 + 0.37, row as f64 + 0.61]
    };
    let origins: Vec<[f64; 2]> = (0..world.size.n_cells()).step_by(997).filter(is_free).map(middle).collect();
    let angle = |i: usize| i as f64 * std::f64::consts::TAU / 361.0;
    let directions: Vec<[f64; 2]> = (0..361).map(|i| [angle(i).cos(), angle(i).sin()]).collect();
    let mut distances = vec![0.0; directions.len()];
    let n_rays = origins.len() * directions.len();
    report("rays, fans of 361", "indoor 1000", n_rays, "ray", || {
        for &origin in &origins {
            grid.cast_fan(origin, 0.3, &directions, 400.0, &mut distances);
        }
    });
    let in_direction = |[x, y]: [f64; 2], [dir_x, dir_y]: [f64; 2]| Ray { x, y, dir_x, dir_y };
    report("rays one by one", "indoor 1000", n_rays, "ray", || {
        for &origin in &origins {
            let sum: f64 = directions.iter().map(|d| grid.cast(&in_direction(origin, *d), 400.0)).sum();
            black_box(sum);
        }
    });
    report("rays cell by cell", "indoor 1000", n_rays, "ray", || {
        for &origin in &origins {
            let ray = |d: &[f64; 2]| grid.cast_cell_by_cell(&in_direction(origin, *d), 400.0);
            black_box(directions.iter().map(ray).sum::<f64>());
        }
    });
    report("prepare a map for rays", "indoor 1000", world.size.n_cells(), "cell", || {
        black_box(RayGrid::new(world.size, &world.occupied));
    });
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|w| w == name);
    if is_wanted("ray") {
        rays();
    }
    type Part = (&'static str, fn(&Bench));
    let parts: [Part; 4] =
        [("field", cost_fields), ("query", queries), ("distance", distances), ("proximity", proximities)];
    for bench in benches() {
        parts.iter().filter(|(name, _)| is_wanted(name)).for_each(|(_, part)| part(&bench));
    }
}
