//! Visits to a room whose scans are cast in another grid than the map, with errors of the pose and of the ranges.

use super::*;
use crate::lasting_changes::RemovalRule;
use rand::{RngExt as _, SeedableRng as _};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::{Pose3, pose2};
use rumbo_core::messages::{Data, Seen};
use rumbo_core::trace::Trace;
use rumbo_kit::GridSize;
use rumbo_kit::ray::{Ray, RayGrid};
use std::f64::consts::FRAC_PI_2;
use std::path::PathBuf;

const SIZE: GridSize = GridSize::new(140, 100);
const CELL_M: f64 = 0.05;

/// A rectangle of cells: first column, first row, columns, rows.
type Thing = [usize; 4];

const SOFA: Thing = [30, 88, 20, 8];
const CHEST: Thing = [100, 20, 10, 10];
const CHEST_MOVED: Thing = [84, 60, 10, 10];
const PILLAR: Thing = [55, 30, 2, 2];

/// A room with walls of two cells.
fn room(things: &[Thing]) -> Vec<u8> {
    let mut cells = vec![0; SIZE.n_cells()];
    let walls = [[0, 0, 140, 2], [0, 98, 140, 2], [0, 0, 2, 100], [138, 0, 2, 100], [60, 2, 2, 30]];
    for [col, row, n_cols, n_rows] in walls.iter().chain(things) {
        for row in *row..row + n_rows {
            cells[SIZE.index(*col, row)..][..*n_cols].fill(1);
        }
    }
    cells
}

fn map_of(cells: &[u8]) -> Map {
    let mut grid = Grid::unknown(SIZE.width as u32, SIZE.height as u32, CELL_M).unwrap();
    for (cell, is_occupied) in grid.cells.make_mut().iter_mut().zip(cells) {
        *cell = if *is_occupied == 0 { -Grid::CERTAIN } else { Grid::CERTAIN };
    }
    Map { grid: Some(grid), ..Map::default() }
}

fn occupied(map: &Map) -> Vec<u8> {
    let grid = map.grid.as_ref().unwrap();
    grid.cells.iter().map(|cell| u8::from(grid.class_of(*cell) == CellClass::Occupied)).collect()
}

/// Round the room, and back a little off.
fn way() -> Vec<Pose2> {
    let corners: [[f64; 2]; 8] =
        [[0.6, 0.6], [0.6, 3.9], [4.0, 3.9], [6.3, 3.7], [6.3, 0.7], [4.0, 0.7], [3.8, 2.4], [1.0, 2.2]];
    let mut poses = Vec::new();
    for ends in corners.windows(2) {
        let [from, to] = [ends[0], ends[1]];
        let way = [to[0] - from[0], to[1] - from[1]];
        let n = (way[0].hypot(way[1]) / 0.08).ceil() as usize;
        let heading = way[1].atan2(way[0]);
        poses.extend((0..n).map(|k| {
            let share = k as f64 / n as f64;
            pose2(from[0] + share * way[0], from[1] + share * way[1], heading)
        }));
    }
    poses
}

/// How a visit goes.
#[derive(Clone, Copy)]
struct Conditions {
    seed: u64,
    /// Somebody walks to and fro.
    walks: bool,
    /// Somebody stands here all the time.
    stands: Option<Thing>,
    /// Standard deviation that the estimate claims along x and y, meters.
    claimed_m: f64,
    status: Status,
    /// The estimate is off by this along x and y, meters.
    off_m: f64,
}

const FINE: Conditions =
    Conditions { seed: 1, walks: false, stands: None, claimed_m: 0.01, status: Status::Tracking, off_m: 0.0 };

fn scan(rays: &RayGrid, from: &Pose2, rng: &mut Xoshiro256PlusPlus) -> LaserScan {
    let mut scan = LaserScan {
        first_bearing_rad: -FRAC_PI_2,
        bearing_step_rad: 0.5f64.to_radians(),
        max_range_m: 8.0,
        ..LaserScan::default()
    };
    let heading = from.rotation.angle();
    let [x, y] = [from.translation.x, from.translation.y].map(|v| v / CELL_M);
    let range = |k: usize| {
        let ray = Ray::at_angle(x, y, heading + scan.bearing_rad(k));
        (rays.cast(&ray, 400.0) * CELL_M) as f32
    };
    let ranges: Vec<f32> = (0..361).map(|k| range(k) + rng.random_range(-0.015..0.015)).collect();
    scan.ranges_m = ranges.into();
    scan
}

/// Drives through a world of these cells, two scans a second.
fn drive(builder: &mut dyn MapBuilder, map: &mut Map, world: &[u8], conditions: &Conditions) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(conditions.seed);
    let trace = Trace::unwatched();
    for (k, pose) in way().into_iter().enumerate() {
        let mut cells = world.to_vec();
        let walker = [66 + 5 * (k % 12), 44, 6, 6];
        for [col, row, n_cols, n_rows] in
            conditions.walks.then_some(walker).into_iter().chain(conditions.stands)
        {
            for row in row..row + n_rows {
                cells[SIZE.index(col, row)..][..n_cols].fill(1);
            }
        }
        let scan = scan(&RayGrid::new(SIZE, &cells), &pose, &mut rng);
        let stamp = Time::from_secs(0.5 * k as f64);
        let mut off = |most: f64| rng.random_range(-most..most);
        let error = pose2(conditions.off_m + off(0.012), conditions.off_m + off(0.012), off(0.002));
        let believed = Pose2::from_parts(
            (pose.translation.vector + error.translation.vector).into(),
            pose.rotation * error.rotation,
        );
        let covariance = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(
            conditions.claimed_m.powi(2),
            conditions.claimed_m.powi(2),
            1e-6,
        ));
        let estimate =
            Estimate { status: conditions.status, ..Estimate::planar(stamp, believed, believed, covariance) };
        let data = Data::LaserScan(scan);
        let seen = [Observation {
            sensor: SensorId(1),
            stamp,
            base_from_sensor: Pose3::identity(),
            valid: true,
            data,
        }];
        let input = MapInput { seen: Seen::sorted(&seen), estimate: &estimate };
        builder.insert(&mut Cx { now: stamp, trace: &trace }, &input, map).unwrap();
    }
}

/// Where two maps differ, as a picture: `+` came, `-` went.
fn difference(before: &[u8], after: &[u8]) -> String {
    let letter = |index: usize| match (before[index], after[index]) {
        (0, 0) => '.',
        (0, _) => '+',
        (_, 0) => '-',
        _ => '#',
    };
    let line = |row: usize| (0..SIZE.width).map(|col| letter(SIZE.index(col, row))).collect::<String>();
    (0..SIZE.height).rev().map(|row| format!("\n{}", line(row))).collect()
}

/// A folder of this test's own, and the pipeline that lies there.
struct Place {
    folder: PathBuf,
}

impl Place {
    fn new(name: &str) -> Place {
        let folder =
            std::env::temp_dir().join(format!("rumbo-lasting-changes-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        Place { folder }
    }

    fn build(&self, params: &LastingChangesParams) -> Result<Box<dyn MapBuilder>, BuildError> {
        params.build(&BuildContext { folder: self.folder.clone(), ..BuildContext::bare("lasting_changes") })
    }

    /// One visit: the map that is saved; what must be remembered is written.
    fn visit(&self, params: &LastingChangesParams, map: &Map, world: &[u8], conditions: &Conditions) -> Map {
        let file = self.folder.join("memory");
        let memory = file.is_file().then(|| PathBuf::from("memory"));
        let mut builder = self.build(&LastingChangesParams { memory, ..params.clone() }).unwrap();
        let mut map = map.clone();
        builder.start(&mut map).unwrap();
        let started = map.clone();
        drive(builder.as_mut(), &mut map, world, conditions);
        assert_eq!(map, started, "nothing changes during a visit");
        let kept = builder.save(&mut map).unwrap().unwrap();
        std::fs::write(file, kept).unwrap();
        map
    }

    fn visits(
        &self,
        params: &LastingChangesParams,
        map: Map,
        world: &[u8],
        n: u64,
        conditions: &Conditions,
    ) -> Map {
        (0..n).fold(map, |map, k| {
            let conditions = Conditions { seed: conditions.seed * 100 + k, ..*conditions };
            self.visit(params, &map, world, &conditions)
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

fn cells_of([col, row, n_cols, n_rows]: Thing) -> Vec<usize> {
    (row..row + n_rows).flat_map(|row| (col..col + n_cols).map(move |col| SIZE.index(col, row))).collect()
}

/// Cells in which a beam without noise ends in at least ten scans of the way.
fn visible(world: &[u8]) -> Vec<usize> {
    let rays = RayGrid::new(SIZE, world);
    let mut counts = vec![0; SIZE.n_cells()];
    for pose in way() {
        let mut in_scan = vec![false; SIZE.n_cells()];
        for k in 0..361 {
            let angle = pose.rotation.angle() - FRAC_PI_2 + (0.5 * f64::from(k)).to_radians();
            let (x, y) = (pose.translation.x / CELL_M, pose.translation.y / CELL_M);
            let reach = rays.cast(&Ray::at_angle(x, y, angle), 160.0) + 1e-6;
            if reach < 160.0 {
                let (col, row) = (x + reach * angle.cos(), y + reach * angle.sin());
                in_scan[SIZE.index(col as usize, row as usize)] = true;
            }
        }
        counts.iter_mut().zip(in_scan).for_each(|(count, is_met)| *count += u32::from(is_met));
    }
    (0..SIZE.n_cells()).filter(|cell| counts[*cell] >= 10).collect()
}

#[test]
fn five_visits_bring_moved_furniture_into_the_map_and_nothing_else_with_somebody_walking_about() {
    let place = Place::new("moved");
    let params = LastingChangesParams::default();
    let before = room(&[SOFA, CHEST, PILLAR]);
    let after = room(&[SOFA, CHEST_MOVED, PILLAR]);
    let walks = Conditions { walks: true, ..FINE };
    let map = place.visits(&params, map_of(&before), &before, 1, &walks);
    assert_eq!(occupied(&map), before, "a visit to the place as it was mapped changes nothing");
    let map = place.visits(&params, map, &after, 2, &Conditions { seed: 2, ..walks });
    assert_eq!(occupied(&map), before, "two visits are not enough");
    let map = occupied(&place.visits(&params, map, &after, 3, &Conditions { seed: 3, ..walks }));
    let seen = visible(&after);
    let new: Vec<usize> = cells_of(CHEST_MOVED).into_iter().filter(|cell| seen.contains(cell)).collect();
    let n_new = new.iter().filter(|cell| map[**cell] == 1).count();
    assert!(new.len() >= 25 && n_new * 10 >= new.len() * 9, "{n_new} of {} cells came in", new.len());
    let n_gone = cells_of(CHEST).iter().filter(|cell| map[**cell] == 0).count();
    assert!(n_gone >= 95, "{n_gone} of 100 cells are gone");
    let own = [cells_of(CHEST), cells_of(CHEST_MOVED)].concat();
    let n_false = (0..map.len()).filter(|cell| map[*cell] != before[*cell] && !own.contains(cell)).count();
    assert!(n_false <= 4, "{n_false} other cells changed: {}", difference(&before, &map));
}

#[test]
fn a_map_that_is_off_by_one_cell_is_left_as_it_is() {
    for (name, off) in [("right", 1), ("left", -1)] {
        let place = Place::new(name);
        let world = room(&[SOFA, CHEST, PILLAR]);
        let mut mapped = vec![0; world.len()];
        for (index, cell) in mapped.iter_mut().enumerate() {
            *cell = SIZE.neighbor(index, off, 0).map_or(0, |beside| world[beside]);
        }
        let params = LastingChangesParams { removes: RemovalRule::All, ..LastingChangesParams::default() };
        let map = occupied(&place.visits(&params, map_of(&mapped), &world, 4, &FINE));
        let n_changed = map.iter().zip(&mapped).filter(|(a, b)| a != b).count();
        // Of about 700 cells at surfaces.
        assert!(n_changed <= 8, "{n_changed} cells changed: {}", difference(&mapped, &map));
    }
}

#[test]
fn glass_stays_in_the_map_unless_everything_shall_go_that_is_seen_through() {
    const PANE: Thing = [62, 31, 30, 1];
    let (world, mapped) = (room(&[SOFA, CHEST]), room(&[SOFA, CHEST, PANE]));
    let pane = |map: &[u8]| cells_of(PANE).into_iter().filter(|cell| map[*cell] == 1).count();
    let usual = LastingChangesParams::default();
    let kept = Place::new("glass").visits(&usual, map_of(&mapped), &world, 5, &FINE);
    assert_eq!(pane(&occupied(&kept)), 30);
    let all = LastingChangesParams { removes: RemovalRule::All, ..usual };
    let removed = Place::new("all").visits(&all, map_of(&mapped), &world, 5, &FINE);
    assert!(pane(&occupied(&removed)) <= 4, "{}", pane(&occupied(&removed)));
}

#[test]
fn who_stands_there_in_one_visit_and_not_in_the_next_never_comes_into_the_map() {
    let place = Place::new("stands");
    let world = room(&[SOFA, CHEST]);
    let mut map = map_of(&world);
    for k in 0..6 {
        let stands = (k % 3 != 2).then_some([80, 44, 6, 6]);
        let conditions = Conditions { seed: k, stands, ..FINE };
        map = place.visit(&LastingChangesParams::default(), &map, &world, &conditions);
    }
    assert_eq!(occupied(&map), world);
}

#[test]
fn scans_of_a_robot_that_is_not_sure_or_not_there_count_for_nothing() {
    let (mapped, world) = (room(&[SOFA, CHEST, PILLAR]), room(&[SOFA, CHEST_MOVED, PILLAR]));
    let params = LastingChangesParams { confirm_visits: 1, removes: RemovalRule::All, ..Default::default() };
    let cases = [
        ("unsure", Conditions { claimed_m: 0.1, ..FINE }),
        ("ambiguous", Conditions { status: Status::Ambiguous, ..FINE }),
        ("elsewhere", Conditions { off_m: 0.5, ..FINE }),
    ];
    for (name, conditions) in cases {
        let map = Place::new(name).visit(&params, &map_of(&mapped), &world, &conditions);
        let n_changed = occupied(&map).iter().zip(&mapped).filter(|(a, b)| a != b).count();
        assert_eq!(n_changed, 0, "{name}");
    }
    let map = Place::new("sure").visit(&params, &map_of(&mapped), &world, &FINE);
    assert_ne!(occupied(&map), mapped);
}

#[test]
fn unconfirmed_changes_are_shown_where_wanted_and_not_saved() {
    let place = Place::new("shown");
    let (mapped, world) = (room(&[SOFA, CHEST]), room(&[SOFA, CHEST_MOVED]));
    let params = LastingChangesParams { removes: RemovalRule::All, ..LastingChangesParams::default() };
    let map = place.visit(&params, &map_of(&mapped), &world, &FINE);
    assert_eq!(occupied(&map), mapped);
    let shown = LastingChangesParams { shows_unconfirmed: true, memory: Some("memory".into()), ..params };
    let mut builder = place.build(&shown).unwrap();
    let mut shows = map.clone();
    builder.start(&mut shows).unwrap();
    let seen = occupied(&shows);
    let front = cells_of(CHEST_MOVED).into_iter().filter(|cell| seen[*cell] == 1).count();
    let old = cells_of(CHEST).into_iter().filter(|cell| seen[*cell] == 1).count();
    assert!(front >= 20 && old <= 5, "{front} cells of the new place, {old} of the old one");
    builder.save(&mut shows).unwrap();
    assert_eq!(occupied(&shows), mapped);
}

#[test]
fn the_map_that_the_first_visit_began_with_goes_on_as_well_as_the_saved_one() {
    let place = Place::new("chain");
    let (mapped, world) = (room(&[SOFA, CHEST]), room(&[SOFA, CHEST_MOVED]));
    let params = LastingChangesParams { removes: RemovalRule::All, ..LastingChangesParams::default() };
    let saved = place.visits(&params, map_of(&mapped), &world, 3, &FINE);
    assert_ne!(occupied(&saved), mapped);
    let again = LastingChangesParams { memory: Some("memory".into()), ..params };
    let start = |map: &Map| {
        let mut map = map.clone();
        place.build(&again).unwrap().start(&mut map).map(|()| occupied(&map))
    };
    assert_eq!(start(&map_of(&mapped)), Ok(occupied(&saved)));
    assert_eq!(start(&saved), Ok(occupied(&saved)));
    let error = start(&map_of(&room(&[PILLAR]))).unwrap_err().to_string();
    assert!(error.contains("memory") && error.contains("another map"), "{error}");
}

#[test]
fn what_cannot_be_corrected_is_told() {
    let place = Place::new("faults");
    let missing = LastingChangesParams { memory: Some("nothing".into()), ..Default::default() };
    let error = place.build(&missing).err().unwrap();
    assert!(error.path == "memory" && error.message.contains("nothing"), "{error:?}");
    let start = |map: &mut Map| {
        let mut builder = place.build(&LastingChangesParams::default()).unwrap();
        builder.start(map).map(|()| builder)
    };
    assert_eq!(start(&mut Map::default()).err(), Some(MapError::MissingLayer { layer: "grid" }));
    let mut unknown = Map { grid: Some(Grid::unknown(5, 5, 0.1).unwrap()), ..Map::default() };
    assert!(start(&mut unknown).err().unwrap().to_string().contains("no known cell"));
    let mut with_levels = map_of(&room(&[]));
    with_levels.coarse_grids = vec![Grid::unknown(70, 50, 0.1).unwrap()];
    assert!(start(&mut with_levels).err().unwrap().to_string().contains("coarser grids"));
    let mut map = map_of(&room(&[]));
    let builder = start(&mut map).unwrap();
    let error = builder.save(&mut unknown).unwrap_err().to_string();
    assert!(error.contains("replaced"), "{error}");
    let unstarted = place.build(&LastingChangesParams::default()).unwrap();
    assert!(unstarted.save(&mut map).is_err());
}

#[test]
fn every_fault_of_the_parameters_is_told() {
    let bad = LastingChangesParams {
        confirm_visits: 0,
        min_scans: 0,
        max_end_std_m: 0.0,
        max_range_m: f64::NAN,
        min_duration_s: -1.0,
        scan_distance_m: f64::INFINITY,
        scan_angle_deg: -1.0,
        max_pose_age_s: -0.1,
        min_explained: 1.5,
        ..LastingChangesParams::default()
    };
    let paths: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    let expected = [
        "confirm_visits",
        "min_scans",
        "max_end_std_m",
        "max_range_m",
        "min_duration_s",
        "scan_distance_m",
        "scan_angle_deg",
        "max_pose_age_s",
        "min_explained",
    ];
    assert_eq!(paths, expected);
    assert!(LastingChangesParams::default().check().is_empty());
}

#[test]
fn the_reach_is_where_heading_and_place_together_are_unsure_enough() {
    let estimate = |std_m: f64, std_rad: f64| {
        let covariance =
            nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::new(std_m * std_m, 0.0, std_rad * std_rad));
        Estimate::planar(Time::ZERO, Pose2::identity(), Pose2::identity(), covariance)
    };
    // 3, 4, 5: at 4 m a heading that is off by 10 mrad moves the end by 4 cm.
    assert!((reach_m(&estimate(0.03, 0.01), 0.05, 8.0).unwrap() - 4.0).abs() < 1e-9);
    assert_eq!(reach_m(&estimate(0.03, 0.0), 0.05, 8.0), Some(8.0));
    assert_eq!(reach_m(&estimate(0.03, 1e-4), 0.05, 8.0), Some(8.0));
    assert_eq!(reach_m(&estimate(0.06, 1e-4), 0.05, 8.0), None);
    assert_eq!(reach_m(&Estimate::lost(Time::ZERO), 0.05, 8.0), None);
}
