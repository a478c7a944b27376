#![allow(clippy::print_stdout, missing_docs, clippy::unwrap_used)]
use rumbo_kit::generated_world::*;
use rumbo_kit::ray::*;
fn main() {
    let world = GeneratedWorld::indoor(1000, 4242);
    let grid = RayGrid::new(world.size, &world.occupied);
    let free = (0..world.size.n_cells()).step_by(9973).filter(|&i| world.occupied[i] == 0);
    let origins: Vec<(f64, f64)> =
        free.map(|i| world.size.col_row(i)).map(|(c, r)| (c as f64 + 0.37, r as f64 + 0.61)).collect();
    let dirs: Vec<[f64; 2]> = (0..361)
        .map(|i| {
            let a = i as f64 * std::f64::consts::TAU / 361.0;
            [a.cos(), a.sin()]
        })
        .collect();
    let mut out = vec![0.0; 361];
    let n: usize = 200;
    let mut sum = 0.0;
    for _ in 0..n {
        for &(x, y) in &origins {
            grid.cast_fan([x, y], 0.3, &dirs, 400.0, &mut out);
            sum += out[7];
        }
    }
    println!("rays {} sum {sum} mean {}", n * origins.len() * 361, out.iter().sum::<f64>() / 361.0);
}
