//! People who walk to and fro on straight free pieces of the floor.

use super::rules::People;
use super::{Scenery, along, between};
use crate::compare::ground::Ground;
use crate::compare::range::unit;
use rumbo_core::rng::Rng;
use std::f64::consts::PI;
use toml::{Table, Value};

/// A walk is at most twice as long, meters.
const REACH_M: f64 = 4.0;
/// Shorter ones are drawn again, meters.
const LEAST_WALK_M: f64 = 2.0;
/// Nobody walks nearer to where the robot starts, meters.
const OFF_START_M: f64 = 1.0;
const MOST_TRIES: usize = 100;

/// Puts people in.
pub fn put(ground: &Ground, rule: &People, start: [f64; 2], rng: &mut Rng, scenery: &mut Scenery) {
    let n = between(rule.n.map(f64::from), rng).round() as usize;
    for idx in 0..n {
        let walk = (0..MOST_TRIES).find_map(|_| walk(ground, start, rng));
        let Some(route) = walk else { return };
        let mut walker = person(&format!("walker {}", idx + 1), &route, between(rule.speed_m_s, rng));
        let care =
            [("personal_space_m", rule.personal_space_m), ("turn_back_after_s", rule.turn_back_after_s)];
        for (key, value) in care {
            walker.extend(value.map(|value| (key.to_owned(), Value::Float(value))));
        }
        scenery.persons.push(walker);
    }
}

/// Both ends of a straight free piece.
fn walk(ground: &Ground, start: [f64; 2], rng: &mut Rng) -> Option<[[f64; 2]; 2]> {
    let middle = ground.place(rng);
    let direction_rad = PI * unit(rng);
    let ends = [direction_rad, direction_rad + PI].map(|direction_rad| {
        let n_steps = (REACH_M / ground.step_m()) as usize;
        let at = |step: usize| along(middle, direction_rad, step as f64 * ground.step_m());
        let free = (1..=n_steps).take_while(|step| ground.is_open(at(*step))).last().unwrap_or(0);
        at(free)
    });
    let [from, to] = ends;
    let way = [to[0] - from[0], to[1] - from[1]];
    let length_m = way[0].hypot(way[1]);
    let share = ((start[0] - from[0]) * way[0] + (start[1] - from[1]) * way[1]) / length_m.powi(2);
    let share = share.clamp(0.0, 1.0);
    let off_m = (from[0] + share * way[0] - start[0]).hypot(from[1] + share * way[1] - start[1]);
    (length_m >= LEAST_WALK_M && off_m >= OFF_START_M).then_some(ends)
}

/// A person as a world file has one.
pub fn person(name: &str, route: &[[f64; 2]], speed_m_s: f64) -> Table {
    let corners = route.iter().map(|corner| Value::Array(corner.map(Value::Float).into()));
    let mut table = Table::new();
    table.insert("name".into(), Value::String(name.to_owned()));
    table.insert("route".into(), Value::Array(corners.collect()));
    table.insert("speed_m_s".into(), Value::Float(speed_m_s));
    table.insert("shape".into(), Value::String("legs".into()));
    table
}
