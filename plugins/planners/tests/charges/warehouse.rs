//! The published warehouse: obstacles, starts and what the reference implementation did.

use rumbo_core::frames::Point2;
use rumbo_kit::potential::{Group, Piece};

const FILE: &str = include_str!("../data/potential/fc_warehouse.toml");

/// The goal of all runs.
pub fn goal() -> Point2 {
    Point2::new(20.0, 25.0)
}

/// Obstacles of the warehouse: four walls, then ten racks.
pub fn groups() -> Vec<Group> {
    let table: toml::Table = toml::from_str(FILE).unwrap();
    let obstacles = table["obstacle"].as_array().unwrap();
    let pieces =
        |obstacle: &toml::Value| obstacle["segments"].as_array().unwrap().iter().map(piece).collect();
    obstacles.iter().map(pieces).collect()
}

/// Racks as lower left and upper right corner.
#[allow(dead_code)]
pub fn racks() -> Vec<[Point2; 2]> {
    let corners = |group: &Group| {
        let fold = |k: fn(f64, f64) -> f64| {
            group.iter().fold(group[0].from, |all, p| Point2::new(k(all.x, p.from.x), k(all.y, p.from.y)))
        };
        [fold(f64::min), fold(f64::max)]
    };
    groups().iter().filter(|group| group.len() == 4).map(corners).collect()
}

fn piece(segment: &toml::Value) -> Piece {
    let v = numbers(segment);
    Piece::between(Point2::new(v[0], v[1]), Point2::new(v[2], v[3]))
}

fn numbers(values: &toml::Value) -> Vec<f64> {
    let number = |v: &toml::Value| v.as_float().unwrap_or_else(|| v.as_integer().unwrap() as f64);
    values.as_array().unwrap().iter().map(number).collect()
}

/// A published run.
#[allow(dead_code)]
pub struct PublishedRun {
    pub start: Point2,
    pub plain_arrived: bool,
    pub plain_end: Point2,
    pub plain_length_m: f64,
    pub length_m: f64,
    pub clearance_m: f64,
    pub charges: Vec<Point2>,
}

/// The sixteen starts.
#[allow(dead_code)]
pub fn runs() -> Vec<PublishedRun> {
    let table: toml::Table = toml::from_str(FILE).unwrap();
    let point = |v: &toml::Value| Point2::new(numbers(v)[0], numbers(v)[1]);
    let run = |run: &toml::Value| {
        let (plain, charge) = (&run["plain"], &run["charge"]);
        let float = |table: &toml::Value, key: &str| table[key].as_float().unwrap();
        PublishedRun {
            start: point(&run["start"]),
            plain_arrived: plain["arrived"].as_bool().unwrap(),
            plain_end: Point2::new(float(plain, "x"), float(plain, "y")),
            plain_length_m: float(plain, "length_m"),
            length_m: float(charge, "length_m"),
            clearance_m: float(charge, "min_clearance_m"),
            charges: run["charge_positions"].as_array().unwrap().iter().map(point).collect(),
        }
    };
    table["run"].as_array().unwrap().iter().map(run).collect()
}

/// The 268 starts every 2 m outside of racks grown by 0.3 m.
#[allow(dead_code)]
pub fn grid_of_starts() -> Vec<Point2> {
    let mut starts = Vec::new();
    for i in 0..20 {
        for j in 0..15 {
            let at = Point2::new(1.13 + 2.0 * f64::from(i), 1.07 + 2.0 * f64::from(j));
            let is_in = |[low, high]: &[Point2; 2]| {
                at.x > low.x - 0.3 && at.x < high.x + 0.3 && at.y > low.y - 0.3 && at.y < high.y + 0.3
            };
            if !racks().iter().any(is_in) {
                starts.push(at);
            }
        }
    }
    starts
}
