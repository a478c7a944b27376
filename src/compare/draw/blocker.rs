//! Something across the way that no map shows.

use super::people::person;
use super::rules::{InTheWay, Kind};
use super::{Scenery, along, between};
use crate::compare::free_space::{Ends, FreeSpace};
use crate::compare::ground::{Ground, Passing};
use crate::compare::range::unit;
use rumbo_core::rng::Rng;
use rumbo_kit::world_file::{Material, SolidBox};
use std::f64::consts::FRAC_PI_2;
use toml::Value;

/// Part of the way in which it stands.
const SHARE: [f64; 2] = [0.3, 0.7];
/// Not nearer to start and goal, meters: the robot has turned and drives.
const OFF_ENDS_M: f64 = 1.0;
/// The way's direction is that between two points so far before and behind, meters.
const BESIDE_M: f64 = 0.25;
/// Length of a pane, meters.
const PANE_M: f64 = 1.2;
/// A door reaches so far to both sides at the most, meters.
const DOOR_REACH_M: f64 = 3.0;
/// Thickness of panes and doors, meters.
const THIN_M: f64 = 0.04;
/// Speed at which a robot may come along, to tell when it has, m/s.
const COMING_M_S: f64 = 0.15;
/// Who leaves walks so fast, straight ahead through all walls, m/s and meters.
const LEAVING_M_S: f64 = 1.0;
const GONE_M: f64 = 500.0;

/// Puts it there; none where it would not leave the ways that the rule wants.
pub fn put(
    (space, ground): (&FreeSpace, &Ground),
    rule: &InTheWay,
    ends: &Ends,
    way: &[[f64; 2]],
    rng: &mut Rng,
    scenery: &mut Scenery,
) -> Option<()> {
    let step_m = ground.step_m();
    let idx = (between(SHARE, rng) * way.len() as f64) as usize;
    let n_beside = (BESIDE_M / step_m).ceil() as usize;
    let (at, before, behind) =
        (way.get(idx)?, way.get(idx.checked_sub(n_beside)?)?, way.get(idx + n_beside)?);
    let off = |end: [f64; 2]| (at[0] - end[0]).hypot(at[1] - end[1]);
    if off(ends.start) < OFF_ENDS_M || off(ends.goal) < OFF_ENDS_M {
        return None;
    }
    let heading_rad = (behind[1] - before[1]).atan2(behind[0] - before[0]);
    let side = if unit(rng) < 0.5 { -1.0 } else { 1.0 };
    let across_rad = heading_rad + FRAC_PI_2 + side * between(rule.turned_deg, rng).to_radians();
    let boxes = match rule.kind {
        Kind::Box => vec![solid("crate", *at, [0.3, 0.6].map(|_| between([0.3, 0.6], rng)), across_rad)],
        Kind::Chair => chair(*at, across_rad),
        Kind::Glass => {
            let pane = solid("pane", *at, [PANE_M, THIN_M], across_rad);
            vec![SolidBox { material: Material::Glass, z_max_m: 2.0, ..pane }]
        }
        Kind::Door => vec![door(ground, *at, across_rad)],
        Kind::Person => vec![solid("person", *at, [0.5, 0.5], across_rad)],
    };
    let all: Vec<SolidBox> = scenery.boxes.iter().chain(&boxes).cloned().collect();
    let is_joined = |passing: Passing| space.ground_for(passing, &all).are_joined(ends.start, ends.goal);
    // Where no way shall be left, none must be left for a robot that takes passages as narrow as its hull.
    let is_right =
        if rule.another_way { is_joined(Passing::WithRoom) } else { !is_joined(Passing::Narrowly) };
    if !is_right && rule.leaves_after_s.is_none() {
        return None;
    }
    if rule.kind != Kind::Person {
        scenery.boxes.extend(boxes);
        return Some(());
    }
    let mut standing = match rule.leaves_after_s {
        Some(_) => person("somebody", &[*at, along(*at, heading_rad, GONE_M)], LEAVING_M_S),
        None => person("somebody", &[*at], 0.0),
    };
    if let Some(leaves_after_s) = rule.leaves_after_s {
        let comes_s = idx as f64 * step_m / COMING_M_S;
        standing.insert("start_s".into(), Value::Float(comes_s + leaves_after_s));
    }
    scenery.persons.push(standing);
    Some(())
}

fn solid(name: &str, center: [f64; 2], size: [f64; 2], yaw_rad: f64) -> SolidBox {
    let (name, material) = (name.to_owned(), Material::Opaque);
    SolidBox { name, center, size, yaw_rad, z_min_m: 0.0, z_max_m: 1.0, material, mapped: false }
}

/// Legs that a laser at 0.30 m sees, and a seat above it.
fn chair(center: [f64; 2], yaw_rad: f64) -> Vec<SolidBox> {
    const APART_M: f64 = 0.40;
    const LEG_M: f64 = 0.03;
    const SEAT_M: [f64; 2] = [0.42, 0.46];
    let corner = |quarter: usize| {
        let direction_rad = yaw_rad + FRAC_PI_2 * (quarter as f64 + 0.5);
        let leg =
            solid("chair leg", along(center, direction_rad, APART_M / 2f64.sqrt()), [LEG_M; 2], yaw_rad);
        SolidBox { z_max_m: SEAT_M[0], ..leg }
    };
    let seat = solid("seat", center, [APART_M + LEG_M; 2], yaw_rad);
    (0..4).map(corner).chain([SolidBox { z_min_m: SEAT_M[0], z_max_m: SEAT_M[1], ..seat }]).collect()
}

/// From wall to wall.
fn door(ground: &Ground, at: [f64; 2], across_rad: f64) -> SolidBox {
    let reach_m = [1.0, -1.0].map(|side| {
        let n_steps = (DOOR_REACH_M / ground.step_m()) as usize;
        let is_floor =
            |step: &usize| ground.is_floor(along(at, across_rad, side * *step as f64 * ground.step_m()));
        side * (1..=n_steps).take_while(is_floor).count() as f64 * ground.step_m()
    });
    let middle = along(at, across_rad, (reach_m[0] + reach_m[1]) / 2.0);
    let length_m = reach_m[0] - reach_m[1] + 2.0 * ground.step_m();
    SolidBox { z_max_m: 2.0, ..solid("shut door", middle, [length_m, THIN_M], across_rad) }
}
