//! The slow twin looks at every cell and every solid for every ray.

use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::sim::solid::{Footprint, Point, Solid, Vector};

fn slow_cast(lattice: &Lattice, ray: &Ray, is_wall: impl Fn(usize, usize) -> bool) -> Option<f64> {
    let solids = lattice.solids.iter().filter_map(|solid| solid.hit(ray));
    let cells = (0..lattice.width * lattice.height).map(|idx| (idx % lattice.width, idx / lattice.width));
    let walls = cells.filter(|&(col, row)| is_wall(col, row)).filter_map(|(col, row)| {
        let center = Point::new(col as f64 + 0.5, row as f64 + 0.5);
        let footprint = Footprint::rectangle(center, Vector::new(1.0, 1.0), 0.0);
        Solid { footprint, z_min: 0.0, z_max: lattice.wall_height, is_glass: false }.hit(ray)
    });
    solids.chain(walls).min_by(f64::total_cmp)
}

/// Nothing reaches out of a lattice of `size` by `size` cells.
fn random_solid(rng: &mut Xoshiro256PlusPlus, size: f64) -> Solid {
    let point = |rng: &mut Xoshiro256PlusPlus| {
        Point::new(rng.random_range(4.0..size - 4.0), rng.random_range(4.0..size - 4.0))
    };
    let footprint = match rng.random_range(0..3) {
        0 => Footprint::Segment { from: point(rng), to: point(rng) },
        1 => Footprint::Disc { center: point(rng), radius: rng.random_range(0.1..3.0) },
        _ => {
            let size = Vector::new(rng.random_range(0.1..5.0), rng.random_range(0.1..5.0));
            Footprint::rectangle(point(rng), size, rng.random_range(-3.0..3.0))
        }
    };
    let z_min = rng.random_range(0.0..3.0);
    Solid { footprint, z_min, z_max: z_min + rng.random_range(0.1..4.0), is_glass: false }
}

/// Level and sloped rays, from inside and outside, on worlds with few and many things.
#[test]
fn the_fast_ray_meets_what_the_slow_twin_meets() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
    let (mut n_hits, mut n_misses) = (0, 0);
    for world in 0..60 {
        let size = rng.random_range(10..60usize);
        let share = [0.0, 0.002, 0.03, 0.2][world % 4];
        let walls: Vec<bool> = (0..size * size).map(|_| rng.random_bool(share)).collect();
        let is_wall = |col: usize, row: usize| walls[row * size + col];
        let n_solids = [0, 3, 25][world % 3];
        let solids = (0..n_solids).map(|_| random_solid(&mut rng, size as f64)).collect();
        let lattice = Lattice::new((size, size), 4.0, solids, is_wall);
        let mut shots = Vec::new();
        for shot in 0..400 {
            let range = -3.0..size as f64 + 3.0;
            let from = Point::new(rng.random_range(range.clone()), rng.random_range(range));
            let angle: f64 = match shot % 5 {
                0 => f64::from(rng.random_range(0..4)) * std::f64::consts::FRAC_PI_2,
                _ => rng.random_range(-3.2..3.2),
            };
            // Exact axis directions, not the cosine's 6e-17.
            let along =
                Vector::new(angle.cos(), angle.sin()).map(|part| if part.abs() < 1e-15 { 0.0 } else { part });
            let slope = if shot % 2 == 0 { 0.0 } else { rng.random_range(-0.5..0.5) };
            let ray = Ray { from, along, z: rng.random_range(0.05..3.9), slope };
            let fast = lattice.cast(&ray, f64::INFINITY).map(|hit| hit.way);
            let slow = slow_cast(&lattice, &ray, is_wall);
            let agree = match (fast, slow) {
                (Some(fast), Some(slow)) => (fast - slow).abs() < 1e-9,
                (None, None) => true,
                _ => false,
            };
            assert!(agree, "world {world} shot {shot}: fast {fast:?}, slow {slow:?}, {ray:?}");
            shots.push((ray, f64::INFINITY));
            if slow.is_some() { n_hits += 1 } else { n_misses += 1 }
        }
        let mut n_done = 0;
        lattice.cast_all(
            shots.len(),
            |number| shots[number],
            |number, ray, reach, hit| {
                assert_eq!(
                    ((*ray, reach), hit),
                    (shots[number], lattice.cast(ray, reach)),
                    "abreast as alone"
                );
                n_done += 1;
            },
        );
        assert_eq!(n_done, shots.len());
    }
    assert!(n_hits > 5_000 && n_misses > 2_000, "{n_hits} hits, {n_misses} misses");
}

#[test]
fn the_edge_of_a_cell_is_met_exactly() {
    let lattice = Lattice::new((20, 20), 4.0, Vec::new(), |col, row| (col, row) == (15, 7));
    let cast = |x: f64, y: f64, dx: f64, dy: f64| {
        let ray = Ray::level(Point::new(x, y), Vector::new(dx, dy), 1.0);
        lattice.cast(&ray, f64::INFINITY).map(|hit| hit.way)
    };
    assert_eq!(cast(0.5, 7.5, 1.0, 0.0), Some(14.5));
    assert_eq!(cast(19.25, 7.125, -1.0, 0.0), Some(3.25));
    assert_eq!(cast(15.5, 0.5, 0.0, 1.0), Some(6.5));
    assert_eq!(cast(15.5, 19.5, 0.0, -1.0), Some(11.5));
    assert_eq!(cast(15.5, 7.5, 0.0, -1.0), Some(0.0));
    assert_eq!(cast(0.5, 8.5, 1.0, 0.0), None);
    // From (12, 4.2) along (0.8, 0.6): the left edge x = 15 is met after 3.75, at y = 6.45, the bottom y = 7 after 4.667.
    assert!((cast(12.0, 4.2, 0.8, 0.6).unwrap() - 2.8 / 0.6).abs() < 1e-12);
}

#[test]
fn nothing_is_seen_beyond_the_reach() {
    let lattice = Lattice::new((20, 20), 4.0, Vec::new(), |col, _| col == 15);
    let ray = Ray::level(Point::new(5.0, 5.5), Vector::new(1.0, 0.0), 1.0);
    assert_eq!(lattice.cast(&ray, 10.0).map(|hit| hit.way), Some(10.0));
    assert_eq!(lattice.cast(&ray, 9.999), None);
}

#[test]
fn a_ray_above_the_walls_passes_and_one_coming_down_lands_on_them() {
    let lattice = Lattice::new((20, 20), 4.0, Vec::new(), |col, _| (10..15).contains(&col));
    let above = Ray::level(Point::new(0.5, 5.5), Vector::new(1.0, 0.0), 4.1);
    assert_eq!(lattice.cast(&above, f64::INFINITY), None);
    let down = Ray { z: 10.0, slope: -0.5, ..above };
    assert!((lattice.cast(&down, f64::INFINITY).unwrap().way - 12.0).abs() < 1e-12);
}
