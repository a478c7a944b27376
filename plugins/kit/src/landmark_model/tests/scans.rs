//! Scans on maps.

use super::*;
use rumbo_core::map::CellClass;

/// The range by small steps, not-a-number at what nobody knows, infinite beyond reach.
fn by_steps(grid: &Grid, [x, y]: [f64; 2], [along_x, along_y]: [f64; 2], reach_m: f64) -> f64 {
    const STEP: f64 = 1e-3;
    for k in 0..(reach_m / grid.resolution_m() / STEP) as usize {
        let distance = k as f64 * STEP;
        let [col, row] = [x + distance * along_x, y + distance * along_y].map(f64::floor);
        if col < 0.0 || row < 0.0 || col >= f64::from(grid.width()) || row >= f64::from(grid.height()) {
            return f64::INFINITY;
        }
        match grid.class_of(grid.cells[row as usize * grid.width() as usize + col as usize]) {
            CellClass::Free => {}
            CellClass::Occupied => return distance * grid.resolution_m(),
            CellClass::Unknown => return f64::NAN,
        }
    }
    f64::INFINITY
}

#[test]
fn rays_end_where_small_steps_end_and_know_what_stopped_them() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let grid = random_map(60, 50, 20);
    let surroundings = Surroundings::new(&grid);
    let mut ranges = Vec::new();
    let mut n = [0; 3];
    for _ in 0..40 {
        let cell = rng.random_range(0..3000);
        if !surroundings.is_free(cell) {
            continue;
        }
        let (col, row) = surroundings.size().col_row(cell);
        let origin = [col as f64 + rng.random::<f64>(), row as f64 + rng.random::<f64>()];
        let heading: f64 = rng.random_range(-3.0..3.0);
        let directions: Vec<[f64; 2]> =
            (0..50).map(|k| f64::from(k) / 8.0).map(|a| [a.cos(), a.sin()]).collect();
        surroundings.scan(origin, heading, &directions, 3.0, &mut ranges);
        let mut n_wrong = 0;
        for (range, [x, y]) in ranges.iter().zip(&directions) {
            let along = [heading.cos() * x - heading.sin() * y, heading.sin() * x + heading.cos() * y];
            let expected = by_steps(&grid, origin, along, 3.0);
            n[usize::from(expected.is_nan()) + 2 * usize::from(expected.is_infinite())] += 1;
            let is_same = range.is_nan() && expected.is_nan() || *range == expected;
            n_wrong += i32::from(!(is_same || (range - expected).abs() < 2e-4));
        }
        // A small step may cut the corner of a cell.
        assert!(n_wrong <= 1, "{origin:?} {heading}");
    }
    assert!(n.iter().all(|n| *n > 50), "{n:?}");
}

#[test]
fn rays_through_corners_of_cells_meet_the_wall_and_not_what_lies_behind() {
    // A diagonal wall: rays at 45 degrees from the middle of a cell go through corners only.
    let mut grid = Grid::unknown(20, 20, 0.1).unwrap();
    let cells = grid.cells.make_mut();
    cells.fill(-Grid::CERTAIN);
    (0..20).for_each(|k| cells[k * 20 + (19 - k)] = Grid::CERTAIN);
    let surroundings = Surroundings::new(&grid);
    let mut ranges = Vec::new();
    for k in 1..18 {
        let origin = [f64::from(k) / 2.0 + 0.5, f64::from(k) / 2.0 + 0.5];
        let along = std::f64::consts::FRAC_1_SQRT_2;
        surroundings.scan(origin, 0.0, &[[along, along]], 5.0, &mut ranges);
        assert!(ranges[0].is_finite(), "{origin:?}: {ranges:?}");
    }
    for odd in [f64::NAN, f64::INFINITY, 1e300] {
        surroundings.scan([odd, 0.0], 0.0, &[[1.0, 0.0]], 5.0, &mut ranges);
        surroundings.scan([0.5, 0.5], odd, &[[1.0, 0.0]], 5.0, &mut ranges);
        assert!(!ranges[0].is_finite() || ranges[0] >= 0.0);
    }
}

#[test]
fn a_square_room_shows_four_walls_from_everywhere_and_unknown_ones_are_no_walls() {
    let mut grid = Grid::unknown(44, 44, 0.1).unwrap();
    let cells = grid.cells.make_mut();
    for row in 0..44 {
        for col in 0..44 {
            let is_inside = (1..43).contains(&col) && (1..43).contains(&row);
            cells[row * 44 + col] = if is_inside { -Grid::CERTAIN } else { Grid::CERTAIN };
        }
    }
    let settings = ModelSettings { n_rays: 360, range_m: 8.0, ..SETTINGS };
    let mut tracer = Tracer::new(settings);
    for (col, row) in [(10, 10), (21, 30), (5, 40)] {
        let surroundings = Surroundings::new(&grid);
        let mut walls: Vec<Look> = tracer.looks_of(&surroundings, row * 44 + col).collect();
        walls.sort_by(|a, b| a.distance_m.total_cmp(&b.distance_m));
        assert!(walls.iter().all(|look| look.kind == LookKind::Wall) && walls.len() == 4, "{walls:?}");
        let mut expected = [col, 43 - col - 1, row, 43 - row - 1].map(|n| 0.1 * n as f64 - 0.05);
        expected[1] += 0.1;
        expected[3] += 0.1;
        expected.sort_by(f64::total_cmp);
        for (look, expected) in walls.iter().zip(expected) {
            assert!((look.distance_m - expected).abs() < 1e-6, "{look:?} {expected}");
            assert!((look.extent_m - 4.2).abs() < 0.3, "{look:?}");
        }
        // The right wall was never seen.
        let mut hidden = grid.clone();
        (0..44).for_each(|row| hidden.cells.make_mut()[row * 44 + 43] = 0.0);
        assert_eq!(tracer.looks_of(&Surroundings::new(&hidden), row * 44 + col).count(), 3);
    }
}
