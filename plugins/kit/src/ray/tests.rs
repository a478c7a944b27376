use super::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn unit(angle_rad: f64) -> [f64; 2] {
    [angle_rad.cos(), angle_rad.sin()]
}

fn random_grid(rng: &mut Xoshiro256PlusPlus, size: GridSize, density: f64) -> Vec<u8> {
    (0..size.n_cells()).map(|_| u8::from(rng.random_bool(density))).collect()
}

/// Nearest entry into any occupied cell as a closed box, by the slab test.
fn nearest_box(size: GridSize, occupied: &[u8], ray: &Ray, max_range: f64) -> f64 {
    let mut nearest = max_range;
    for index in (0..size.n_cells()).filter(|&i| occupied[i] != 0) {
        let (col, row) = size.col_row(index);
        let mut span = (0.0_f64, f64::INFINITY);
        for (origin, direction, low) in [(ray.x, ray.dir_x, col as f64), (ray.y, ray.dir_y, row as f64)] {
            if direction == 0.0 {
                if origin < low || origin > low + 1.0 {
                    span.1 = -1.0;
                }
            } else {
                let (a, b) = ((low - origin) / direction, (low + 1.0 - origin) / direction);
                span = (span.0.max(a.min(b)), span.1.min(a.max(b)));
            }
        }
        if span.0 <= span.1 {
            nearest = nearest.min(span.0);
        }
    }
    nearest
}

#[test]
fn skipping_equals_walking_to_the_bit_and_the_boxes_to_1e_9() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for round in 0..60 {
        let size = GridSize::new(1 + (rng.next_u32() % 40) as usize, 1 + (rng.next_u32() % 40) as usize);
        let density = [0.0, 0.01, 0.1, 0.6][round % 4];
        let occupied = random_grid(&mut rng, size, density);
        let grid = RayGrid::new(size, &occupied);
        for _ in 0..300 {
            let x = rng.random_range(-10.0..size.width as f64 + 10.0);
            let y = rng.random_range(-10.0..size.height as f64 + 10.0);
            let ray = Ray::at_angle(x, y, rng.random_range(-7.0..7.0));
            let max_range = rng.random_range(0.0..70.0);
            let fast = grid.cast(&ray, max_range);
            assert_eq!(
                fast.to_bits(),
                grid.cast_cell_by_cell(&ray, max_range).to_bits(),
                "{ray:?} in {size:?}"
            );
            let slow = nearest_box(size, &occupied, &ray, max_range);
            assert!((fast - slow).abs() < 1e-9, "{ray:?} in {size:?}: {fast} instead of {slow}");
        }
    }
}

#[test]
fn lattice_origins_and_exact_diagonals_walk_the_same_cells_with_and_without_skips() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let directions = [
        (1.0, 0.0),
        (-1.0, 0.0),
        (0.0, 1.0),
        (0.0, -1.0),
        (half, half),
        (-half, half),
        (half, -half),
        (-half, -half),
        (0.6, 0.8),
        (-0.8, 0.6),
    ];
    for _ in 0..100 {
        let size = GridSize::new(24, 17);
        let grid = RayGrid::new(size, &random_grid(&mut rng, size, 0.03));
        for (dir_x, dir_y) in directions {
            let x = f64::from(rng.random_range(-4..56)) * 0.5;
            let y = f64::from(rng.random_range(-4..40)) * 0.5;
            let ray = Ray { x, y, dir_x, dir_y };
            assert_eq!(grid.cast(&ray, 60.0), grid.cast_cell_by_cell(&ray, 60.0), "{ray:?}");
        }
    }
}

#[test]
fn axis_parallel_rays_stop_at_the_edge() {
    let size = GridSize::new(10, 10);
    let mut occupied = vec![0; 100];
    occupied[size.index(7, 2)] = 1;
    let grid = RayGrid::new(size, &occupied);
    let cast = |x, y, dir_x, dir_y| grid.cast(&Ray { x, y, dir_x, dir_y }, 50.0);
    assert_eq!(cast(1.5, 2.5, 1.0, 0.0), 5.5);
    assert_eq!(cast(9.5, 2.5, -1.0, 0.0), 1.5);
    assert_eq!(cast(7.25, 0.5, 0.0, 1.0), 1.5);
    assert_eq!(cast(7.25, 9.0, 0.0, -1.0), 6.0);
    assert_eq!(cast(-3.0, 2.5, 1.0, 0.0), 10.0, "from outside");
    assert_eq!(cast(-3.0, 2.5, -1.0, 0.0), 50.0, "away from the map");
    assert_eq!(cast(7.5, 2.5, 0.0, 1.0), 0.0, "inside an obstacle");
    assert_eq!(cast(1.5, 2.0, 1.0, 0.0), 5.5, "along the lower edge, which belongs to the cell");
    assert_eq!(cast(1.5, 3.0, 1.0, 0.0), 50.0, "along the upper edge, which does not");
    assert_eq!(grid.cast(&Ray { x: 1.5, y: 2.5, dir_x: 1.0, dir_y: 0.0 }, 5.0), 5.0, "beyond the range");
}

#[test]
fn a_ray_never_slips_through_a_corner_where_two_obstacles_touch() {
    let size = GridSize::new(4, 4);
    let mut occupied = vec![0; 16];
    occupied[size.index(1, 2)] = 1;
    occupied[size.index(2, 1)] = 1;
    let grid = RayGrid::new(size, &occupied);
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for (x, y, sign) in [(1.0, 1.0, 1.0), (3.0, 3.0, -1.0)] {
        let distance = grid.cast(&Ray { x, y, dir_x: sign * half, dir_y: sign * half }, 9.0);
        assert!((distance - 2.0_f64.sqrt()).abs() < 1e-12, "{distance}");
    }
}

#[test]
fn what_is_not_finite_meets_nothing() {
    let grid = RayGrid::new(GridSize::new(2, 2), &[1; 4]);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert_eq!(grid.cast(&Ray { x: bad, y: 0.5, dir_x: 1.0, dir_y: 0.0 }, 7.0), 7.0);
        assert_eq!(grid.cast(&Ray { x: 0.5, y: 0.5, dir_x: bad, dir_y: 0.0 }, 7.0), 7.0);
    }
    let empty = RayGrid::new(GridSize::new(0, 0), &[]);
    assert_eq!(empty.cast(&Ray { x: 0.0, y: 0.0, dir_x: 1.0, dir_y: 0.0 }, 7.0), 7.0);
}

#[test]
fn a_fan_is_its_rays_to_the_bit() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for round in 0..60 {
        let size = GridSize::new(1 + rng.next_u32() as usize % 90, 1 + rng.next_u32() as usize % 90);
        let occupied = random_grid(&mut rng, size, [0.002, 0.02, 0.2][round % 3]);
        let grid = RayGrid::new(size, &occupied);
        let n_rays = [0, 1, 15, 16, 17, 361][rng.next_u32() as usize % 6];
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let exact = [[1.0, 0.0], [0.0, -1.0], [half, half], [-half, half], [0.6, -0.8]];
        let direction = |i: usize| match exact.get(i % 40) {
            Some(exact) => *exact,
            None => unit(i as f64 * 0.1),
        };
        let directions: Vec<[f64; 2]> = (0..n_rays).map(direction).collect();
        // On the lattice, between, and outside.
        let origin = [f64::from(rng.random_range(-6..120)) * 0.5, rng.random_range(-5.0..70.0_f64)];
        let heading = [0.0, 0.0, rng.random_range(-4.0..4.0)][round % 3];
        let max_range = rng.random_range(0.0..120.0);
        let mut distances = vec![0.0; n_rays];
        grid.cast_fan(origin, heading, &directions, max_range, &mut distances);
        for (direction, distance) in directions.iter().zip(&distances) {
            let ray = Ray::turned(origin, heading.sin_cos(), *direction);
            assert_eq!(distance.to_bits(), grid.cast_cell_by_cell(&ray, max_range).to_bits(), "{ray:?}");
        }
    }
}

#[test]
fn a_fan_without_an_origin_meets_nothing() {
    let grid = RayGrid::new(GridSize::new(2, 2), &[1; 4]);
    let mut distances = [0.0; 20];
    grid.cast_fan([f64::NAN, 1.0], 0.0, &[[1.0, 0.0]; 20], 7.0, &mut distances);
    assert_eq!(distances, [7.0; 20]);
}
