//! Potential of many charges over a grid. Bar: 0.15 ns a cell and charge on 500 x 500 cells with 256 charges.
use nalgebra::Point2;
use rumbo_kit::GridSize;
use rumbo_kit::potential::charge_map::{MapFrame, add_potential, add_slowly};
use rumbo_kit::potential::{ChargeForce, ChargeLaw};

fn main() {
    divan::main();
}

const LAW: ChargeLaw =
    ChargeLaw { strength: 8.0, exponent: 2.0, force: ChargeForce::Consistent, range_m: f64::INFINITY };

fn scene(n_charges: u32) -> (MapFrame, Vec<Point2<f64>>) {
    let frame = MapFrame { size: GridSize::new(500, 500), origin: Point2::new(-5.0, 3.0), cell_m: 0.1 };
    // Spread evenly and unlike any row or column.
    let place =
        |k: u32| Point2::new(f64::from(k * 37 % 251) * 0.2 - 5.0, f64::from(k * 91 % 239) * 0.2 + 3.0);
    (frame, (0..n_charges).map(place).collect())
}

#[divan::bench(args = [1, 16, 256], sample_count = 20)]
fn charge_map(bencher: divan::Bencher, n_charges: u32) {
    let (frame, charges) = scene(n_charges);
    let mut sums = vec![0.0; frame.size.n_cells()];
    bencher
        .counter(divan::counter::ItemsCount::new(sums.len() * charges.len()))
        .bench_local(|| add_potential(&frame, &LAW, &charges, &mut sums));
}

#[divan::bench(args = [16], sample_count = 5)]
fn slow_charge_map(bencher: divan::Bencher, n_charges: u32) {
    let (frame, charges) = scene(n_charges);
    let mut sums = vec![0.0; frame.size.n_cells()];
    bencher
        .counter(divan::counter::ItemsCount::new(sums.len() * charges.len()))
        .bench_local(|| add_slowly(&frame, &LAW, &charges, &mut sums));
}
