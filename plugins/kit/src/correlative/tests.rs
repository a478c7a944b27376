//! Against brute force: every pose of the window, every point.

use super::search::cell_of;
use super::*;
use crate::GridSize;
use crate::generated_world::GeneratedWorld;
use rumbo_core::frames::{Point2, Pose2, pose2, wrap_angle};
use std::f64::consts::PI;

const RESOLUTION_M: f64 = 0.05;

/// Numbers that look like chance, between 0 and 1.
fn scattered(k: usize, by: f64) -> f64 {
    (k as f64 * by).fract()
}

fn world() -> (GridSize, Vec<u8>) {
    let world = GeneratedWorld::indoor(300, 5);
    (world.size, world.occupied)
}

/// Ends of beams all around, from the walls of the world.
fn scan(size: GridSize, occupied: &[u8], grid_from_base: &Pose2, n_beams: usize) -> Vec<Point2> {
    let at = |point: Point2| {
        let cell = point / RESOLUTION_M;
        let inside =
            cell.x >= 0.0 && cell.y >= 0.0 && cell.x < size.width as f64 && cell.y < size.height as f64;
        inside.then(|| occupied[size.index(cell.x as usize, cell.y as usize)] != 0)
    };
    let beams = (0..n_beams).map(|beam| beam as f64 * 2.0 * PI / n_beams as f64);
    beams
        .filter_map(|bearing| {
            let along = |k: i32| Point2::new(bearing.cos(), bearing.sin()) * (f64::from(k) * 0.01);
            (1..900).map(along).find(|point| at(grid_from_base * point) != Some(false))
        })
        .collect()
}

fn free_pose(size: GridSize, occupied: &[u8], seed: usize) -> Pose2 {
    (0..)
        .map(|k| {
            let at = |by| (0.1 + 0.8 * scattered(k * 17 + seed * 131, by)) * size.width as f64;
            [at(0.618), at(0.7549)]
        })
        .find(|[x, y]| {
            let around =
                |d: i32, e: i32| occupied[size.index((*x as i32 + d) as usize, (*y as i32 + e) as usize)];
            (-4..=4).all(|d| (-4..=4).all(|e| around(d, e) == 0))
        })
        .map(|[x, y]| pose2(x * RESOLUTION_M, y * RESOLUTION_M, seed as f64))
        .unwrap()
}

/// The mean value at a pose whose translation is offset by whole cells from the window's middle.
fn score(table: &FitTable, points: &[Point2], window: &SearchWindow, cells: [i32; 2], turn: f64) -> f64 {
    let turned = window.pose([0, 0], turn, RESOLUTION_M);
    let total: u32 = points
        .iter()
        .map(|point| {
            let [x, y] = cell_of(&turned, point, RESOLUTION_M);
            u32::from(table.value(x + cells[0], y + cells[1]))
        })
        .sum();
    f64::from(total) / (255.0 * points.len() as f64)
}

fn brute_force(table: &FitTable, points: &[Point2], window: &SearchWindow, apart: Option<&Apart>) -> f64 {
    let reach = window.reach_cells(RESOLUTION_M);
    let mut best: f64 = -1.0;
    for turn in window.turns_rad() {
        for y in -reach..=reach {
            for x in -reach..=reach {
                let pose = window.pose([x, y], turn, RESOLUTION_M);
                if !apart.is_some_and(|apart| apart.excludes(&pose)) {
                    best = best.max(score(table, points, window, [x, y], turn));
                }
            }
        }
    }
    best
}

fn window(grid_from_base: Pose2, reach_m: f64, reach_rad: f64) -> SearchWindow {
    SearchWindow {
        grid_from_base,
        reach_m,
        reach_rad,
        step_rad: 0.02,
        least_score: 0.0,
        most_nodes: usize::MAX,
    }
}

#[test]
fn the_best_pose_is_that_of_brute_force_with_any_number_of_levels() {
    let (size, occupied) = world();
    let mut search = CorrelativeSearch::default();
    for seed in 0..6 {
        let truth = free_pose(size, &occupied, seed);
        let points = scan(size, &occupied, &truth, 40 + 7 * seed);
        let off = |by| scattered(seed + 1, by) - 0.5;
        let guess = pose2(
            truth.translation.x + off(0.618),
            truth.translation.y + off(0.7549),
            truth.rotation.angle() + 0.3 * off(0.5698),
        );
        let window = window(guess, 0.55, 0.2);
        for n_levels in [1, 3, 8] {
            let table = FitTable::around_marks(size, RESOLUTION_M, &occupied, 0.08, n_levels);
            let found = search.best(&table, &points, &window, None).unwrap().unwrap();
            let expected = brute_force(&table, &points, &window, None);
            assert!(
                (found.score - expected).abs() < 1e-12,
                "{seed}, {n_levels}: {} for {expected}",
                found.score
            );
            let off_m = (found.grid_from_base.translation.vector - truth.translation.vector).norm();
            let off_rad = wrap_angle(found.grid_from_base.rotation.angle() - truth.rotation.angle());
            assert!(off_m < 0.12 && off_rad.abs() < 0.03, "{seed}: {off_m} m, {off_rad} rad");
        }
    }
}

#[test]
fn the_best_pose_elsewhere_is_that_of_brute_force_too() {
    let (size, occupied) = world();
    let table = FitTable::around_marks(size, RESOLUTION_M, &occupied, 0.08, 6);
    let truth = free_pose(size, &occupied, 3);
    let points = scan(size, &occupied, &truth, 60);
    let window = window(truth, 0.6, 0.15);
    let mut search = CorrelativeSearch::default();
    let best = search.best(&table, &points, &window, None).unwrap().unwrap();
    let apart = Apart { grid_from_base: best.grid_from_base, distance_m: 0.3, turn_rad: 0.1 };
    let elsewhere = search.best(&table, &points, &window, Some(&apart)).unwrap().unwrap();
    assert!(!apart.excludes(&elsewhere.grid_from_base) && elsewhere.score < best.score);
    assert!((elsewhere.score - brute_force(&table, &points, &window, Some(&apart))).abs() < 1e-12);
}

#[test]
fn a_robot_that_knows_nothing_is_found_in_the_whole_map() {
    let (size, occupied) = world();
    let table = FitTable::around_marks(size, RESOLUTION_M, &occupied, 0.08, 8);
    let middle = size.width as f64 * RESOLUTION_M / 2.0;
    let mut search = CorrelativeSearch::default();
    for seed in 0..5 {
        let truth = free_pose(size, &occupied, seed);
        let points = scan(size, &occupied, &truth, 180);
        let everywhere = SearchWindow { least_score: 0.5, ..window(pose2(middle, middle, 0.0), middle, 4.0) };
        let found = search.best(&table, &points, &everywhere, None).unwrap().unwrap();
        let off_m = (found.grid_from_base.translation.vector - truth.translation.vector).norm();
        let off_rad = wrap_angle(found.grid_from_base.rotation.angle() - truth.rotation.angle());
        assert!(
            off_m < 0.1 && off_rad.abs() < 0.03,
            "{seed}: {off_m} m, {off_rad} rad, score {}",
            found.score
        );
    }
}

#[test]
fn squares_hold_the_best_of_their_cells() {
    let (width, height) = (13, 9);
    let values: Vec<u8> = (0..width * height).map(|k| (k * 89 % 251) as u8).collect();
    let table = FitTable::new(GridSize::new(width, height), 0.1, &values, 5);
    for level in table.levels() {
        for row in 0..level.rows {
            for col in 0..level.columns {
                let inside = |at: i32| at - level.side..at;
                let best = inside(row)
                    .flat_map(|y| inside(col).map(move |x| (x, y)))
                    .map(|(x, y)| table.value(x, y))
                    .max();
                // Places begin `side` cells before the grid.
                let best = best.map(|_| {
                    let (x0, y0) = (col - level.side, row - level.side);
                    (y0..y0 + level.side)
                        .flat_map(|y| (x0..x0 + level.side).map(move |x| (x, y)))
                        .map(|(x, y)| table.value(x, y))
                        .max()
                });
                let cost = level.costs[(row * level.columns + col) as usize];
                assert_eq!(
                    best.flatten().map(|v| 255 - v),
                    Some(cost),
                    "side {} at {col}, {row}",
                    level.side
                );
            }
        }
    }
}

#[test]
fn what_cannot_be_answered_is_said() {
    let (size, occupied) = world();
    let table = FitTable::around_marks(size, RESOLUTION_M, &occupied, 0.08, 6);
    let truth = free_pose(size, &occupied, 1);
    let points = scan(size, &occupied, &truth, 60);
    let mut search = CorrelativeSearch::default();
    let near = window(truth, 0.3, 0.1);
    assert_eq!(search.best(&table, &[], &near, None), Ok(None));
    let nowhere = SearchWindow { grid_from_base: pose2(f64::NAN, 0.0, 0.0), ..near };
    assert_eq!(search.best(&table, &points, &nowhere, None), Ok(None));
    let far_off = SearchWindow { grid_from_base: pose2(-500.0, 1e300, 0.0), least_score: 0.1, ..near };
    assert_eq!(search.best(&table, &points, &far_off, None), Ok(None));
    let strict = SearchWindow { least_score: 1.0, ..window(pose2(1.0, 1.0, 0.0), 0.3, 0.1) };
    assert_eq!(search.best(&table, &points, &strict, None), Ok(None));
    let short = SearchWindow { most_nodes: 10, ..near };
    assert!(matches!(search.best(&table, &points, &short, None), Err(SearchGaveUp { nodes }) if nodes > 10));
}

#[test]
fn turns_cover_the_window_once() {
    let all_around = window(pose2(0.0, 0.0, 0.5), 1.0, PI).turns_rad();
    for k in 0..1000 {
        let turn = -PI + k as f64 * 0.0062831;
        let nearest = all_around.iter().map(|t| wrap_angle(t - turn).abs()).fold(9.0, f64::min);
        assert!(nearest <= 0.01, "{turn}: {nearest}");
    }
    let mut sorted = all_around.clone();
    sorted.sort_by(f64::total_cmp);
    assert!(sorted.windows(2).all(|pair| pair[1] - pair[0] > 0.0199), "no turn twice");
    assert_eq!(window(pose2(0.0, 0.0, 0.0), 1.0, 0.05).turns_rad(), [0.0, 0.02, -0.02, 0.04, -0.04]);
    let step = turn_step_rad(&[Point2::new(0.0, -10.0), Point2::new(3.0, 1.0)], 0.05);
    assert!((step - 0.005).abs() < 1e-6, "{step}");
    assert_eq!(turn_step_rad(&[], 0.05), PI / 2.0);
}
