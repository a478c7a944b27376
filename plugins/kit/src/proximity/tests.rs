use super::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::SQRT_2;

/// Plain relaxation of the whole map until nothing changes.
fn fixed_point(size: GridSize, kinds: &[CellKind], diagonal_step: f64) -> Vec<f64> {
    let start = |k: &CellKind| if *k == CellKind::Obstacle { 0.0 } else { f64::INFINITY };
    let mut distances: Vec<f64> = kinds.iter().map(start).collect();
    loop {
        let mut any = false;
        for cell in (0..size.n_cells()).filter(|&c| kinds[c] == CellKind::Free) {
            for (dx, dy) in NEIGHBORS_8 {
                let step = if dx * dy != 0 { diagonal_step } else { 1.0 };
                let Some(next) = size.neighbor(cell, dx, dy) else { continue };
                if distances[next] + step < distances[cell] - 1e-12 {
                    distances[cell] = distances[next] + step;
                    any = true;
                }
            }
        }
        if !any {
            return distances;
        }
    }
}

fn random_kinds(rng: &mut Xoshiro256PlusPlus, size: GridSize, obstacles: f64, closed: f64) -> Vec<CellKind> {
    let kind = |_| match rng.random_range(0.0..1.0_f64) {
        v if v < obstacles => CellKind::Obstacle,
        v if v < obstacles + closed => CellKind::Closed,
        _ => CellKind::Free,
    };
    (0..size.n_cells()).map(kind).collect()
}

#[test]
fn the_map_is_the_fixed_point_of_plain_relaxation() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(31);
    for round in 0..120 {
        let size = GridSize::new(1 + rng.next_u32() as usize % 40, 1 + rng.next_u32() as usize % 40);
        let kinds = random_kinds(&mut rng, size, [0.0, 0.01, 0.1][round % 3], [0.0, 0.3][round % 2]);
        let step = [SQRT_2, 1.4, 1.0, 2.0][round % 4];
        let map = ProximityMap::new(size, &kinds, step);
        for (found, expected) in map.distances().iter().zip(fixed_point(size, &kinds, step)) {
            assert!(*found == expected || (found - expected).abs() < 1e-9, "{found} instead of {expected}");
        }
    }
}

#[test]
fn adding_obstacles_equals_a_new_map_to_the_bit() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(32);
    for round in 0..120 {
        let size = GridSize::new(1 + rng.next_u32() as usize % 60, 1 + rng.next_u32() as usize % 60);
        let mut kinds = random_kinds(&mut rng, size, [0.0, 0.005, 0.05][round % 3], [0.0, 0.2][round % 2]);
        let mut map = ProximityMap::new(size, &kinds, SQRT_2);
        for _ in 0..3 {
            let added: Vec<usize> = (0..4).map(|_| rng.random_range(0..size.n_cells())).collect();
            map.add_obstacles(&added);
            added.iter().for_each(|&cell| kinds[cell] = CellKind::Obstacle);
            assert_eq!(map, ProximityMap::new(size, &kinds, SQRT_2), "round {round}");
        }
    }
}

#[test]
fn a_map_without_obstacles_or_cells_is_infinite_or_empty() {
    assert_eq!(
        ProximityMap::new(GridSize::new(2, 1), &[CellKind::Free; 2], 1.4).distances(),
        [f64::INFINITY; 2]
    );
    assert!(ProximityMap::new(GridSize::new(0, 0), &[], 1.4).distances().is_empty());
}
