//! Furniture that stands elsewhere than on the map, and boxes around the robot that no map shows.

use super::rules::Clutter;
use super::{Scenery, along, between};
use crate::compare::free_space::FreeSpace;
use crate::compare::range::unit;
use rumbo_core::rng::Rng;
use rumbo_kit::world_file::{Material, SolidBox};
use std::f64::consts::{PI, TAU};

/// Moved furniture stands so far from its place on the map, meters.
const MOVED_M: [f64; 2] = [0.3, 1.0];
/// And turned by no more than this to either side.
const TURNED_RAD: f64 = PI / 6.0;
/// No piece of it comes nearer to the robot's middle, meters.
const OFF_START_M: f64 = 0.55;
const MOST_TRIES: usize = 20;

/// Moves a share of the furniture. A piece that finds no place that leaves all of the room joined stays.
pub fn move_some(space: &FreeSpace, share: f64, start: [f64; 2], rng: &mut Rng, scenery: &mut Scenery) {
    let is_furniture = |solid: &&SolidBox| solid.mapped && !solid.name.starts_with("wall");
    let mut left: Vec<&SolidBox> = space.scene().boxes.iter().filter(is_furniture).collect();
    let n_to_move = (share * left.len() as f64).round() as usize;
    for _ in 0..n_to_move {
        let idx = ((unit(rng) * left.len() as f64) as usize).min(left.len().saturating_sub(1));
        let piece = left.swap_remove(idx);
        for _ in 0..MOST_TRIES {
            let center = along(piece.center, TAU * unit(rng), between(MOVED_M, rng));
            let yaw_rad = piece.yaw_rad + between([-TURNED_RAD, TURNED_RAD], rng);
            let moved = SolidBox { name: format!("{}, moved", piece.name), center, yaw_rad, ..piece.clone() };
            let off_start_m = (center[0] - start[0]).hypot(center[1] - start[1]) - half_diagonal_m(&moved);
            let with_it: Vec<SolidBox> = scenery.boxes.iter().cloned().chain([moved.clone()]).collect();
            if off_start_m >= OFF_START_M && space.stays_joined(&with_it) {
                scenery.boxes.push(moved);
                scenery.without.push(piece.name.clone());
                break;
            }
        }
    }
}

fn half_diagonal_m(solid: &SolidBox) -> f64 {
    solid.size[0].hypot(solid.size[1]) / 2.0
}

/// Boxes around the robot: each has a corner at the drawn distance, and lies behind it as seen from the robot.
pub fn clutter(rule: &Clutter, start: [f64; 2], rng: &mut Rng, scenery: &mut Scenery) {
    let half_m = rule.size_m * std::f64::consts::FRAC_1_SQRT_2;
    for idx in 0..rule.n {
        let direction_rad = TAU * unit(rng);
        let center = along(start, direction_rad, between(rule.distance_m, rng) + half_m);
        scenery.boxes.push(SolidBox {
            name: format!("clutter {}", idx + 1),
            center,
            size: [rule.size_m; 2],
            yaw_rad: direction_rad + PI / 4.0,
            z_min_m: 0.0,
            z_max_m: 1.0,
            material: Material::Opaque,
            mapped: false,
        });
    }
}
