use super::*;
use crate::map_file::UNKNOWN;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A map from a picture: `#` occupied, `.` free, everything else unknown; the first line is the top.
fn drawn(lines: &[&str], resolution_m: f64, origin: [f64; 3]) -> MapImage {
    let cell = |letter| match letter {
        '#' => 100,
        '.' => 0,
        _ => UNKNOWN,
    };
    MapImage {
        width: lines[0].len(),
        height: lines.len(),
        resolution_m,
        origin,
        cells: lines.iter().rev().flat_map(|line| line.chars().map(cell)).collect(),
    }
}

const ROOM: [&str; 5] = ["########", "#......#", "#......#", "#......#", "########"];

#[test]
fn a_map_beside_itself_is_perfect() {
    let room = drawn(&ROOM, 0.1, [1.0, -2.0, 0.4]);
    let found = compare_maps(&room, &room, 0.0).unwrap();
    assert_eq!((found.precision, found.recall, found.f1), (1.0, 1.0, 1.0));
    assert_eq!((found.coverage, found.agreement), (1.0, Some(1.0)));
    assert_eq!(found.map_to_reference, WallDistance { mean_m: 0.0, p95_m: 0.0, max_m: 0.0 });
    assert_eq!((found.n_occupied, found.n_occupied_reference), (22, 22));
}

#[test]
fn walls_displaced_missed_and_made_up_are_counted_by_hand() {
    let reference = drawn(&["#.......#", "#.......#"], 1.0, [0.0; 3]);
    let map = drawn(&["#..#.... ", "#.......#"], 1.0, [0.0; 3]);
    let found = compare_maps(&map, &reference, 1.0).unwrap();
    // Three of four occupied cells of the map are right, the made-up one is three cells off.
    assert_eq!((found.precision, found.recall), (0.75, 1.0));
    assert!((found.f1 - 6.0 / 7.0).abs() < 1e-12);
    assert_eq!(found.map_to_reference, WallDistance { mean_m: 0.75, p95_m: 3.0, max_m: 3.0 });
    assert_eq!(found.reference_to_map, WallDistance { mean_m: 0.25, p95_m: 1.0, max_m: 1.0 });
    assert_eq!((found.coverage, found.agreement), (17.0 / 18.0, Some(16.0 / 17.0)));
    let strict = compare_maps(&map, &reference, 0.99).unwrap();
    assert_eq!((strict.precision, strict.recall), (0.75, 0.75));
}

#[test]
fn a_shifted_wall_is_as_far_as_it_is_shifted_also_outside_the_other_map() {
    let wall = |x_m: f64| drawn(&["#", "#", "#"], 0.5, [x_m, 0.0, 0.0]);
    for shift_m in [0.5, 1.0, -20.0] {
        let found = compare_maps(&wall(3.0 + shift_m), &wall(3.0), 0.75).unwrap();
        for way in [found.map_to_reference, found.reference_to_map] {
            assert!((way.mean_m - shift_m.abs()).abs() < 1e-9, "{way:?}");
        }
        let is_near = shift_m.abs() < 0.75;
        assert_eq!(found.f1, f64::from(u8::from(is_near)));
        assert_eq!((found.coverage, found.agreement), (0.0, None));
    }
}

/// The same plan at another resolution and seen from another corner.
#[test]
fn resolution_and_origin_of_the_same_plan_do_not_matter() {
    let coarse = drawn(&ROOM, 0.2, [1.0, 2.0, 0.0]);
    let mut cells = vec![UNKNOWN; 20 * 14];
    for row in 0..10 {
        for col in 0..16 {
            cells[(row + 2) * 20 + col + 3] = coarse.occupancy(col / 2, row / 2);
        }
    }
    let fine = MapImage { width: 20, height: 14, resolution_m: 0.1, origin: [0.7, 1.8, 0.0], cells };
    let found = compare_maps(&fine, &coarse, 0.15).unwrap();
    assert_eq!((found.precision, found.recall, found.agreement), (1.0, 1.0, Some(1.0)));
    assert_eq!(found.coverage, 1.0);
    // The whole plan turned by a quarter about the origin of the frame, both told by yaw and by its cells.
    let turned = MapImage { origin: [-2.0, 1.0, std::f64::consts::FRAC_PI_2], ..coarse.clone() };
    let mut cells = vec![UNKNOWN; 40];
    for row in 0..8 {
        for col in 0..5 {
            cells[row * 5 + col] = coarse.occupancy(row, 4 - col);
        }
    }
    let upright = MapImage { width: 5, height: 8, origin: [-3.0, 1.0, 0.0], cells, ..coarse };
    let found = compare_maps(&upright, &turned, 0.0).unwrap();
    assert_eq!((found.precision, found.recall, found.coverage, found.agreement), (1.0, 1.0, 1.0, Some(1.0)));
}

#[test]
fn distances_are_those_of_brute_force_between_cells() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(21);
    for _ in 0..60 {
        let mut random = |origin| {
            let (width, height) = (rng.random_range(1..15), rng.random_range(1..15));
            let mut cells: Vec<i8> =
                (0..width * height).map(|_| if rng.random_range(0..8) == 0 { 100 } else { 0 }).collect();
            cells[0] = 100;
            MapImage { width, height, resolution_m: 0.25, origin, cells }
        };
        // Whole cells apart, so that centers lie on centers.
        let (map, reference) = (random([0.0; 3]), random([1.25, -0.75, 0.0]));
        let found = compare_maps(&map, &reference, 0.5).unwrap();
        let (walls, true_walls) = (Sheet::of(&map).walls(), Sheet::of(&reference).walls());
        let nearest =
            |from: &Point2| true_walls.iter().map(|to| (to - from).norm()).min_by(f64::total_cmp).unwrap();
        let all: Vec<f64> = walls.iter().map(nearest).collect();
        let mean_m = all.iter().sum::<f64>() / all.len() as f64;
        assert!((found.map_to_reference.mean_m - mean_m).abs() < 1e-9);
        let n_within = all.iter().filter(|distance| **distance <= 0.5 + 1e-9).count();
        assert_eq!(found.precision, n_within as f64 / all.len() as f64);
    }
}

#[test]
fn maps_that_cannot_be_compared_say_why() {
    let room = drawn(&ROOM, 0.1, [0.0; 3]);
    let empty = drawn(&["..", ".."], 0.1, [0.0; 3]);
    assert_eq!(compare_maps(&empty, &room, 0.1), Err(MapComparisonError::NoWalls { which: "the map" }));
    assert_eq!(compare_maps(&room, &empty, 0.1), Err(MapComparisonError::NoWalls { which: "the reference" }));
    for x_m in [1e5, -1e18] {
        let far = drawn(&ROOM, 0.1, [x_m, 0.0, 0.0]);
        let error = compare_maps(&room, &far, 0.1).unwrap_err();
        assert!(matches!(error, MapComparisonError::TooFarApart { .. }), "{error}");
    }
}
