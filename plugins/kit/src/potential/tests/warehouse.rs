//! The warehouse with two known minima.

use crate::potential::{Attraction, Field, Form, Group, Obstacles, Piece, Repulsion};
use nalgebra::Point2;

/// Its obstacles.
pub fn groups() -> Vec<Group> {
    let table: toml::Table =
        toml::from_str(include_str!("../../../tests/data/potential/fc_warehouse.toml")).unwrap();
    let obstacles = table["obstacle"].as_array().unwrap();
    obstacles
        .iter()
        .map(|obstacle| obstacle["segments"].as_array().unwrap().iter().map(piece).collect())
        .collect()
}

fn piece(segment: &toml::Value) -> Piece {
    let number = |v: &toml::Value| v.as_float().unwrap_or_else(|| v.as_integer().unwrap() as f64);
    let v: Vec<f64> = segment.as_array().unwrap().iter().map(number).collect();
    Piece::between(Point2::new(v[0], v[1]), Point2::new(v[2], v[3]))
}

/// Stationary points: minimum or not, place.
pub fn stationary_points() -> Vec<(bool, Point2<f64>)> {
    let table: toml::Table =
        toml::from_str(include_str!("../../../tests/data/potential/fc_warehouse.toml")).unwrap();
    let points = table["stationary_point"].as_array().unwrap();
    let number = |point: &toml::Value, key: &str| point[key].as_float().unwrap();
    let point = |p: &toml::Value| {
        (p["kind"].as_str() == Some("minimum"), Point2::new(number(p, "x"), number(p, "y")))
    };
    points.iter().map(point).collect()
}

pub const REPULSION: Repulsion = Repulsion { strength: 1.0, influence_m: 2.0, inflation_m: 0.0 };

/// Its field with the goal (20, 25).
pub fn field(obstacles: &Obstacles, form: Form) -> Field<'_> {
    Field {
        goal: Point2::new(20.0, 25.0),
        attraction: Attraction { form, strength: 1.0 },
        obstacles,
        repulsion: REPULSION,
        goal_scaling_m: None,
    }
}
