//! Maps of tiles against plain grids: the same scans, the same cells, the same matches.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use rand::RngExt as _;
use rumbo_core::frames::{Point2, Pose2, Pose3, pose2};
use rumbo_core::map::Grid;
use rumbo_core::messages::LaserScan;
use rumbo_core::rng::{Rng, stream};
use rumbo_core::seal::Seal;
use rumbo_kit::GridSize;
use rumbo_kit::occupancy::{BeamEnds, BeamLimits, Evidence, FreeSpace, Mount2, ScanPainter};
use rumbo_kit::scan_match::{GridLevel, ScanPoints, linearize};
use rumbo_kit::tile_map::{ExportFault, GridExport, LevelView, TILE_CELLS, TileCode, TileMap, TilePainter};
use std::sync::Arc;

/// Edge of a cell, meters; with it the corners of grids and tiles are exact.
const CELL_M: f64 = 0.0625;
/// Half the width of the plain grids, meters: whole tiles.
const HALF_M: f64 = 16.0;
const N_CELLS: usize = 512;

fn limits() -> BeamLimits {
    BeamLimits { min_range_m: 0.1, max_range_m: 12.0, clear_range_m: 3.0 }
}

fn evidence() -> Evidence {
    Evidence::new(0.4, 0.9, 0.01, 0.99).unwrap()
}

fn random_scan(rng: &mut Rng) -> LaserScan {
    let mut range_m = 5.0f32;
    let mut reading = |_| {
        range_m = match rng.random_range(0..25) {
            0 => rng.random_range(0.2..11.0),
            _ => (range_m + rng.random_range(-0.2..0.2)).clamp(0.2, 11.0),
        };
        match rng.random_range(0..30) {
            0 => f32::NAN,
            1 => f32::INFINITY,
            _ => range_m,
        }
    };
    LaserScan {
        first_bearing_rad: -1.57,
        bearing_step_rad: 1f64.to_radians(),
        max_range_m: 30.0,
        ranges_m: (0..181).map(&mut reading).collect::<Vec<f32>>().into(),
        ..LaserScan::default()
    }
}

fn random_pose(rng: &mut Rng) -> Pose2 {
    pose2(rng.random_range(-3.5..3.5), rng.random_range(-3.5..3.5), rng.random_range(-3.0..3.0))
}

fn painter(free_space: FreeSpace) -> TilePainter {
    TilePainter::new(limits(), free_space, evidence())
}

const AREA: FreeSpace = FreeSpace::Area { widest_wedge_rad: 0.05 };

/// A map of some scans.
fn some_map(seed: u64, n_scans: u64) -> TileMap {
    let mut rng = stream(seed, "map");
    let mut map = TileMap::new(CELL_M, 3, &evidence());
    for k in 0..n_scans {
        let (scan, pose) = (random_scan(&mut rng), random_pose(&mut rng));
        painter(AREA).paint(&mut map, &scan, &pose, &Pose3::identity(), seed * 1000 + k + 1);
    }
    map
}

#[test]
fn scans_change_the_cells_that_they_change_on_plain_grids_of_every_level() {
    let mut rng = stream(5, "scans");
    for free_space in [AREA, FreeSpace::Beams] {
        let mut map = TileMap::new(CELL_M, 3, &evidence());
        let mut plain: Vec<Vec<f32>> = (0..3).map(|k| vec![0.0; (N_CELLS >> k).pow(2)]).collect();
        let mut tiles = painter(free_space);
        let (mut ends, mut on_grid) = (BeamEnds::default(), ScanPainter::default());
        // What a beam says to a plain grid, in the steps that a byte can hold.
        let rounded = map.rounded(&evidence());
        let mount = Pose3::translation(0.1, -0.05, 0.3);
        for k in 0..30 {
            let (scan, pose) = (random_scan(&mut rng), random_pose(&mut rng));
            tiles.paint(&mut map, &scan, &pose, &mount, k + 1);
            let grid_from_base = pose2(HALF_M, HALF_M, 0.0) * pose;
            ends.place(&scan, &Mount2::new(&grid_from_base, &mount, CELL_M), &limits());
            for (k, cells) in plain.iter_mut().enumerate() {
                let size = GridSize::new(N_CELLS >> k, N_CELLS >> k);
                assert!(on_grid.paint(cells, size, &ends, 0.5f32.powi(k as i32), free_space, &rounded));
            }
        }
        let (mut n_known, mut n_different) = (0, 0);
        for (k, (level, cells)) in map.levels().iter().zip(&plain).enumerate() {
            let size = GridSize::new(N_CELLS >> k, N_CELLS >> k);
            for (index, expected) in cells.iter().enumerate() {
                let (col, row) = size.col_row(index);
                let half = (size.width / 2) as i64;
                let found = level.cell([col as i64 - half, row as i64 - half]);
                n_known += usize::from(*expected != 0.0);
                n_different += usize::from((found - expected).abs() > 1e-4);
            }
        }
        // Single precision puts an end on the other side of an edge here and there: the two count from other corners.
        assert!(n_known > 50_000 && n_different * 2000 < n_known, "{n_different} of {n_known}");
    }
}

#[test]
fn a_clone_shares_all_tiles_until_one_is_written_and_then_all_others() {
    let map = some_map(1, 10);
    let before = map.clone();
    let shared = |a: &TileMap, b: &TileMap| {
        let levels = a.levels().iter().zip(b.levels());
        levels
            .map(|(a, b)| a.tiles().filter(|(at, t)| b.tile(*at).is_some_and(|o| Arc::ptr_eq(t, o))).count())
            .sum()
    };
    let (mut written, n_all): (TileMap, usize) = (map.clone(), map.n_tiles());
    assert_eq!(shared(&map, &written), n_all);
    let near = LaserScan { max_range_m: 30.0, ranges_m: vec![0.5; 3].into(), ..LaserScan::default() };
    let near = LaserScan { bearing_step_rad: 0.02, ..near };
    painter(AREA).paint(&mut written, &near, &pose2(1.0, 1.0, 0.0), &Pose3::identity(), 99);
    let n_shared: usize = shared(&map, &written);
    assert!(n_shared < n_all && n_shared + 6 >= n_all, "{n_shared} of {n_all}");
    assert_eq!(shared(&map, &before), n_all, "what others have is never changed");
    for (level, old) in map.levels().iter().zip(before.levels()) {
        assert!(level.tiles().all(|(at, tile)| old.tile(at) == Some(tile)));
    }
}

#[test]
fn a_scan_is_matched_with_tiles_as_with_the_grid_that_they_are_written_to() {
    let map = some_map(2, 20);
    let mut grid = None;
    GridExport::default().write(&map, &Pose2::identity(), &mut grid, 1 << 24).unwrap();
    let (grid, view) = (grid.unwrap(), LevelView::new(map.finest().unwrap()));
    let mut rng = stream(3, "points");
    let mut points = ScanPoints::default();
    for _ in 0..200 {
        points.push(rng.random_range(-9.0..9.0), rng.random_range(-9.0..9.0), 1.0);
    }
    for _ in 0..50 {
        let pose = random_pose(&mut rng);
        let (tiles, plain) =
            (linearize(&view, &points, &pose), linearize(&GridLevel::from(&grid), &points, &pose));
        assert_eq!((tiles.n_used, tiles.n_known), (plain.n_used, plain.n_known));
        assert!((tiles.cost - plain.cost).abs() < 1e-4 * plain.cost, "{} {}", tiles.cost, plain.cost);
        assert!((tiles.hessian - plain.hessian).amax() < 1e-3 * plain.hessian.amax());
        assert!((tiles.descent - plain.descent).amax() < 1e-3 * plain.hessian.amax());
    }
}

fn same_cells(map: &TileMap, grid: &Grid) {
    let level = map.finest().unwrap();
    for index in 0..grid.cells.len() {
        let center = grid.center_of(grid.cell_of(index));
        assert_eq!(grid.cells[index], map.log_odds_at(center), "{center}");
    }
    let n_known = grid.cells.iter().filter(|cell| **cell != 0.0).count();
    let n_in_tiles: usize =
        level.tiles().map(|(_, t)| t.cells.iter().filter(|cell| **cell != 0).count()).sum();
    assert_eq!(n_known, n_in_tiles, "nothing is beside the grid");
}

#[test]
fn a_grid_that_is_kept_up_to_date_is_the_grid_that_is_made_anew() {
    let mut rng = stream(7, "growth");
    let (mut export, mut grid) = (GridExport::default(), None);
    export.write(&TileMap::new(CELL_M, 3, &evidence()), &Pose2::identity(), &mut grid, 1 << 24).unwrap();
    assert_eq!(
        grid.as_ref().map(|grid| grid.cells.len()),
        Some(TILE_CELLS * TILE_CELLS),
        "an empty map is a grid"
    );
    let mut map = some_map(3, 3);
    let mut other = map.clone();
    for k in 0u32..12 {
        let far = pose2(f64::from(k) - 6.0, 3.0 * f64::from(k), 0.3);
        painter(AREA).paint(
            &mut map,
            &random_scan(&mut rng),
            &far,
            &Pose3::identity(),
            20_000 + u64::from(k),
        );
        painter(AREA).paint(
            &mut other,
            &random_scan(&mut rng),
            &random_pose(&mut rng),
            &Pose3::identity(),
            30_000 + u64::from(k),
        );
        // Now the one and then the other, as the best of several changes.
        let best = if k % 3 == 0 { &other } else { &map };
        export.write(best, &Pose2::identity(), &mut grid, 1 << 24).unwrap();
        same_cells(best, grid.as_ref().unwrap());
    }
    let too_large = GridExport::default().write(&map, &Pose2::identity(), &mut None, 4096);
    assert!(matches!(too_large, Err(ExportFault::TooLarge { max_cells: 4096, .. })));
}

#[test]
fn maps_come_back_from_bytes_and_share_what_they_shared() {
    const SEAL: Seal = Seal { magic: *b"TESTTILE", version: 1 };
    let map = some_map(4, 10);
    let mut other = map.clone();
    painter(AREA).paint(
        &mut other,
        &random_scan(&mut stream(8, "one")),
        &Pose2::identity(),
        &Pose3::identity(),
        77,
    );
    let mut bytes = SEAL.begin(0);
    let mut code = TileCode::default();
    code.write(&map, &mut bytes);
    let n_one = bytes.len();
    code.write(&other, &mut bytes);
    assert!(bytes.len() - n_one < n_one, "shared tiles are written once");
    let bytes = Seal::close(bytes);
    let (mut rest, mut code) = (SEAL.open(&bytes).unwrap(), TileCode::default());
    let back = [code.read(&mut rest).unwrap(), code.read(&mut rest).unwrap()];
    assert!(rest.is_empty());
    for (map, back) in [&map, &other].into_iter().zip(&back) {
        for (level, read) in map.levels().iter().zip(back.levels()) {
            assert_eq!(level.resolution_m(), read.resolution_m());
            assert_eq!(level.tiles().count(), read.tiles().count());
            assert!(level.tiles().all(|(at, tile)| read.tile(at) == Some(tile)));
        }
    }
    let of = |map: &TileMap| {
        map.levels().iter().flat_map(|l| l.tiles().map(|(_, t)| Arc::as_ptr(t))).collect::<Vec<_>>()
    };
    let n_shared = |a: &TileMap, b: &TileMap| of(b).iter().filter(|tile| of(a).contains(tile)).count();
    assert_eq!(n_shared(&back[0], &back[1]), n_shared(&map, &other));
    let mut cut = SEAL.begin(0);
    TileCode::default().write(&map, &mut cut);
    cut.truncate(cut.len() / 2);
    let cut = Seal::close(cut);
    assert!(TileCode::default().read(&mut SEAL.open(&cut).unwrap()).is_none());
}

#[test]
fn scans_from_impossible_places_change_nothing() {
    let mut map = TileMap::new(CELL_M, 2, &evidence());
    let scan = random_scan(&mut stream(1, "far"));
    for pose in [pose2(f64::NAN, 0.0, 0.0), pose2(1e300, 0.0, 0.0), pose2(0.0, f64::INFINITY, 0.0)] {
        painter(AREA).paint(&mut map, &scan, &pose, &Pose3::identity(), 1);
    }
    assert_eq!(map.n_tiles(), 0);
    assert_eq!(map.log_odds_at(Point2::new(1.0, 1.0)), 0.0);
}

#[test]
fn bytes_say_nearly_what_a_beam_says_and_never_unknown() {
    for (p_min, p_max) in [(0.01, 0.99), (0.0001, 0.9), (0.1, 0.9999)] {
        let exact = Evidence::new(0.4, 0.9, p_min, p_max).unwrap();
        let map = TileMap::new(CELL_M, 1, &exact);
        let rounded = map.rounded(&exact);
        let unit = exact.most.max(-exact.least) / 127.0;
        for (a, b) in [
            (exact.free, rounded.free),
            (exact.occupied, rounded.occupied),
            (exact.least, rounded.least),
            (exact.most, rounded.most),
        ] {
            assert!((a - b).abs() <= 0.5001 * unit && a * b > 0.0, "{a} {b}");
        }
    }
    // As many hits as passes make up for: a cell that was seen.
    let even = Evidence::new(0.4, 0.6, 0.01, 0.99).unwrap();
    let mut map = TileMap::new(CELL_M, 1, &even);
    let mut painter = TilePainter::new(limits(), FreeSpace::Beams, even);
    let to = |range_m: f32| LaserScan {
        max_range_m: 30.0,
        bearing_step_rad: 0.1,
        ranges_m: vec![range_m].into(),
        ..LaserScan::default()
    };
    for (k, range_m) in (1u64..).zip([2.03, 4.03, 2.03, 4.03]) {
        painter.paint(&mut map, &to(range_m), &pose2(0.03, 0.03, 0.0), &Pose3::identity(), k);
        assert!(map.log_odds_at(Point2::new(2.05, 0.03)).abs() > 0.01, "after {k} scans");
    }
}
