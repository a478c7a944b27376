//! Scans into grids: the published vectors, and an area filled by brute force.

use super::*;
use crate::GridSize;
use rand::RngExt as _;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng as _;
use rumbo_core::frames::{Pose3, pose2};
use rumbo_core::messages::LaserScan;
use serde_json::Value;

fn vector(name: &str) -> Value {
    let path = format!("{}/tests/data/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(value: &Value) -> f64 {
    match value {
        Value::String(word) => word.trim_start_matches('+').parse().unwrap(),
        number => number.as_f64().unwrap(),
    }
}

fn evidence() -> Evidence {
    Evidence::new(0.4, 0.9, 0.01, 0.99).unwrap()
}

fn limits() -> BeamLimits {
    BeamLimits { min_range_m: 0.0, max_range_m: 3.0, clear_range_m: 3.0 }
}

/// Single precision carries the sums of a sequence to this.
const F32: f64 = 2e-6;

#[test]
fn sequences_of_hits_and_passes_have_the_published_log_odds() {
    let file = vector("slam2d_log_odds");
    let run = |evidence: &Evidence, case: &Value| {
        let mut cell = 0.0;
        for letter in case["sequence"].as_str().unwrap().chars() {
            cell = if letter == 'h' { evidence.hit(cell) } else { evidence.passed(cell) };
        }
        let expected = number(&case["log_odds"]);
        assert!((f64::from(cell) - expected).abs() < F32, "{case}: {cell}");
        let probability = 1.0 / (1.0 + (-f64::from(cell)).exp());
        assert!((probability - number(&case["probability"])).abs() < F32, "{case}: {probability}");
        if let Some(state) = case["state"].as_str() {
            assert_eq!(state == "occupied", cell > 0.0, "{case}");
        }
    };
    let bold = Evidence::new(0.3, 0.9, 0.01, 0.99).unwrap();
    assert!((f64::from(evidence().free) - number(&file["log_odds_free"])).abs() < F32);
    assert!((f64::from(evidence().occupied) - number(&file["log_odds_occupied"])).abs() < F32);
    assert!((f64::from(evidence().least) - number(&file["log_odds_min"])).abs() < F32);
    assert!((f64::from(evidence().most) - number(&file["log_odds_max"])).abs() < F32);
    file["cases"].as_array().unwrap().iter().for_each(|case| run(&evidence(), case));
    file["with_update_factor_free_0_3"]["cases"].as_array().unwrap().iter().for_each(|case| run(&bold, case));
    for bad in file["invalid_parameters_must_be_rejected"].as_array().unwrap() {
        let or = |key: &str, default: f64| bad.get(key).map_or(default, number);
        let made = Evidence::new(
            or("update_factor_free", 0.4),
            or("update_factor_occupied", 0.9),
            or("p_min", 0.01),
            or("p_max", 0.99),
        );
        assert_eq!(made.unwrap_err().len(), 1, "{bad}");
    }
}

/// A scan whose beams point anywhere: one of these for each beam of the vector, with its bearing as the first.
fn beam(bearing_rad: f64, range_m: f64) -> LaserScan {
    LaserScan {
        first_bearing_rad: bearing_rad,
        bearing_step_rad: 0.01,
        max_range_m: 100.0,
        ranges_m: vec![range_m as f32].into(),
        ..LaserScan::default()
    }
}

#[test]
fn the_published_scan_changes_exactly_the_published_cells() {
    let file = vector("slam2d_grid_scan_update");
    let size = GridSize::new(14, 10);
    let mount = Mount2::new(&pose2(0.25, 0.45, 0.0), &Pose3::identity(), 0.1);
    // The beams of the vector have no common step, so their ends are put into one fan by hand.
    let mut fan = BeamEnds::default();
    for beam in file["beams"].as_array().unwrap().iter().map(|entry| &entry["beam"]) {
        let mut one = BeamEnds::default();
        one.place(&self::beam(number(&beam["bearing"]), number(&beam["range"])), &mount, &limits());
        fan.origin = one.origin;
        fan.step_rad = one.step_rad;
        fan.x.extend(one.x);
        fan.y.extend(one.y);
        fan.length.extend(one.length);
        fan.ends.extend(one.ends);
    }
    let mut cells = vec![0.0; size.n_cells()];
    let painted = ScanPainter::default().paint(&mut cells, size, &fan, 1.0, FreeSpace::Beams, &evidence());
    assert!(painted);
    for (row, line) in file["expected_log_odds_rows"].as_array().unwrap().iter().enumerate() {
        for (col, expected) in line.as_array().unwrap().iter().enumerate() {
            let found = f64::from(cells[size.index(col, row)]);
            assert!((found - number(expected)).abs() < F32, "({col}, {row}): {found} for {expected}");
        }
    }
}

#[test]
fn a_line_visits_the_published_cells() {
    let file = vector("slam2d_grid_scan_update");
    let size = GridSize::new(14, 10);
    for entry in file["beams"].as_array().unwrap().iter().filter(|entry| entry["free_cells"].is_array()) {
        let pair = |value: &Value| [0, 1].map(|idx| value[idx].as_i64().unwrap() as i32);
        let mut visited = Vec::new();
        line_cells(size, [2, 4], pair(&entry["end_cell"]), |index| visited.push(size.col_row(index)));
        let expected: Vec<(usize, usize)> = entry["free_cells"]
            .as_array()
            .unwrap()
            .iter()
            .map(|cell| pair(cell).map(|v| v as usize).into())
            .collect();
        assert_eq!(visited, expected, "{entry}");
    }
}

/// A scan of a room with noise, gaps and open beams.
fn random_scan(rng: &mut Xoshiro256PlusPlus, n: usize, step_rad: f64) -> LaserScan {
    let mut range_m = 1.5f32;
    let ranges: Vec<f32> = (0..n)
        .map(|_| {
            range_m = match rng.random_range(0..20) {
                0 => rng.random_range(0.05..2.9),
                _ => (range_m + rng.random_range(-0.05..0.05)).clamp(0.05, 2.9),
            };
            match rng.random_range(0..30) {
                0 => f32::NAN,
                1 => f32::INFINITY,
                _ => range_m,
            }
        })
        .collect();
    LaserScan {
        first_bearing_rad: -step_rad * n as f64 / 2.0,
        bearing_step_rad: step_rad,
        max_range_m: 3.0,
        ranges_m: ranges.into(),
        ..LaserScan::default()
    }
}

/// Whether a point is inside the wedge of two beams, by the signs of three cross products.
fn in_wedge(point: [f64; 2], corners: [[f64; 2]; 3]) -> Option<bool> {
    let side =
        |a: [f64; 2], b: [f64; 2]| (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0]);
    let sides = [side(corners[0], corners[1]), side(corners[1], corners[2]), side(corners[2], corners[0])];
    // Too near to an edge to say in single precision.
    if sides.iter().any(|side| side.abs() < 2e-3) {
        return None;
    }
    Some(sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0))
}

#[test]
fn the_filled_area_is_the_union_of_all_wedges_each_cell_once() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let size = GridSize::new(90, 80);
    let (mut area, mut fan) = (AreaFill::default(), BeamEnds::default());
    let mut n_free = 0;
    for round in 0..40 {
        let step_rad = if round % 2 == 0 { 0.0175 } else { std::f64::consts::TAU / 360.0 };
        let scan = random_scan(&mut rng, if round % 2 == 0 { 181 } else { 360 }, step_rad);
        let pose = pose2(rng.random_range(0.1..4.4), rng.random_range(0.1..3.9), rng.random_range(-3.0..3.0));
        fan.place(&scan, &Mount2::new(&pose, &Pose3::identity(), 0.05), &limits());
        assert_eq!(fan.is_closed, round % 2 == 1);
        let mut cells = vec![0.0; size.n_cells()];
        area.fill(&mut cells, size, &fan, 1.0, 0.02, &evidence());
        let origin = fan.origin.map(f64::from);
        let n = fan.ends.len();
        let end = |idx: usize| -> [f64; 2] {
            let shorter = if fan.ends[idx] == BeamEnd::Hit { 0.5 } else { 0.0 };
            let part = (1.0 - shorter / f64::from(fan.length[idx])).max(0.0);
            let at = [f64::from(fan.x[idx]), f64::from(fan.y[idx])];
            [origin[0] + (at[0] - origin[0]) * part, origin[1] + (at[1] - origin[1]) * part]
        };
        let says = |idx: usize| fan.ends[idx] != BeamEnd::Nothing;
        let wedges: Vec<[[f64; 2]; 3]> = (0..if fan.is_closed { n } else { n - 1 })
            .filter(|idx| says(*idx) && says((idx + 1) % n))
            .map(|idx| [origin, end(idx), end((idx + 1) % n)])
            .collect();
        for (index, cell) in cells.iter().enumerate() {
            let (col, row) = size.col_row(index);
            let middle = [col as f64 + 0.5, row as f64 + 0.5];
            let verdicts: Vec<Option<bool>> = wedges.iter().map(|wedge| in_wedge(middle, *wedge)).collect();
            if verdicts.contains(&None) {
                continue;
            }
            let expected = if verdicts.contains(&Some(true)) { evidence().free } else { 0.0 };
            assert_eq!(*cell, expected, "round {round} ({col}, {row})");
            n_free += usize::from(expected != 0.0);
        }
    }
    assert!(n_free > 20_000, "{n_free}");
}

#[test]
fn every_cell_changes_once_a_scan_and_a_hit_wins() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let size = GridSize::new(90, 80);
    let mount = Mount2::new(&pose2(2.2, 2.0, 0.7), &Pose3::identity(), 0.05);
    let (mut painter, mut fan) = (ScanPainter::default(), BeamEnds::default());
    for (round, free_space) in [FreeSpace::Beams, FreeSpace::Area { widest_wedge_rad: 0.02 }]
        .into_iter()
        .cycle()
        .take(20)
        .enumerate()
    {
        fan.place(&random_scan(&mut rng, 181, if round < 10 { 0.0175 } else { 0.05 }), &mount, &limits());
        let mut cells = vec![0.25; size.n_cells()];
        assert!(painter.paint(&mut cells, size, &fan, 1.0, free_space, &evidence()));
        let once = [0.25, evidence().passed(0.25), evidence().hit(0.25)];
        assert!(cells.iter().all(|cell| once.contains(cell)));
        for idx in (0..181).filter(|idx| fan.ends[*idx] == BeamEnd::Hit) {
            let (col, row) = (fan.x[idx].floor(), fan.y[idx].floor());
            let inside = col >= 0.0 && row >= 0.0 && col < 90.0 && row < 80.0;
            if inside && [col, row] != fan.origin.map(f32::floor) {
                assert_eq!(cells[size.index(col as usize, row as usize)], once[2]);
            }
        }
    }
}

#[test]
fn a_sensor_beside_the_grid_changes_nothing_and_one_upside_down_looks_the_other_way() {
    let size = GridSize::new(40, 40);
    let mut cells = vec![0.0; size.n_cells()];
    let (mut painter, mut fan) = (ScanPainter::default(), BeamEnds::default());
    let outside = Mount2::new(&pose2(-0.5, 1.0, 0.0), &Pose3::identity(), 0.05);
    fan.place(&beam(0.0, 1.0), &outside, &limits());
    assert!(!painter.paint(&mut cells, size, &fan, 1.0, FreeSpace::Beams, &evidence()));
    assert!(cells.iter().all(|cell| *cell == 0.0));
    let hanging = Pose3::from_parts(
        rumbo_core::frames::Point3::origin().coords.into(),
        nalgebra::UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0),
    );
    fan.place(&beam(0.5, 0.8), &Mount2::new(&pose2(1.0, 1.0, 0.0), &hanging, 0.05), &limits());
    let end = [1.0 + 0.8 * 0.5f64.cos(), 1.0 - 0.8 * 0.5f64.sin()].map(|v| v / 0.05);
    assert!((f64::from(fan.x[0]) - end[0]).abs() < 1e-4 && (f64::from(fan.y[0]) - end[1]).abs() < 1e-4);
}

#[test]
fn coarser_grids_take_the_same_scan() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let mount = Mount2::new(&pose2(2.2, 2.0, 0.7), &Pose3::identity(), 0.05);
    let coarse_mount = Mount2::new(&pose2(2.2, 2.0, 0.7), &Pose3::identity(), 0.2);
    let size = GridSize::new(24, 20);
    let (mut fan, mut coarse_fan) = (BeamEnds::default(), BeamEnds::default());
    let scan = random_scan(&mut rng, 181, 0.0175);
    fan.place(&scan, &mount, &limits());
    coarse_fan.place(&scan, &coarse_mount, &limits());
    let (mut scaled, mut direct) = (vec![0.0; size.n_cells()], vec![0.0; size.n_cells()]);
    let free_space = FreeSpace::Area { widest_wedge_rad: 0.02 };
    let mut painter = ScanPainter::default();
    painter.paint(&mut scaled, size, &fan, 0.25, free_space, &evidence());
    painter.paint(&mut direct, size, &coarse_fan, 1.0, free_space, &evidence());
    let n_different = scaled.iter().zip(&direct).filter(|(a, b)| a != b).count();
    assert!(n_different <= 1, "{n_different} cells differ by more than rounding at an edge");
    assert!(scaled.iter().filter(|cell| **cell > 0.0).count() > 20);
}
