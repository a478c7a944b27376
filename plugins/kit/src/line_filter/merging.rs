//! Walls that turn out to be one: pieces that the first scan showed apart (not in the source).

use super::association::{Gates, mahalanobis2};
use super::state::{State, wrapped};
use super::update::{Row, Update};
use super::wall::{Axes, Wall};

/// Variance of "both are the same": not zero, so that the covariance of their difference stays one.
const SAME: f64 = 1e-8;

/// Joins the first wall that overlaps one of `touched` and cannot be told from it. Returns the wall that went.
pub(super) fn merge_one(
    state: &mut State,
    walls: &mut Vec<Wall>,
    touched: &[usize],
    gates: &Gates,
) -> Option<usize> {
    let (kept, gone) = touched.iter().find_map(|&one| {
        let other =
            (0..walls.len()).find(|&other| other != one && are_one(state, walls, one, other, gates))?;
        Some((one.min(other), one.max(other)))
    })?;
    let columns = [kept, gone].map(|wall| state.column_of(wall));
    let (lines, walls_of) = (&state.walls, &*walls);
    let ([rho, phi], [gone_rho, gone_phi]) = (*lines.get(kept)?, *lines.get(gone)?);
    let gone_ends_m = walls_of.get(gone)?.ends_m;
    let rows = [
        Row::new(&[(columns[0], 1.0), (columns[1], -1.0)], gone_rho - rho, SAME),
        Row::new(&[(columns[0] + 1, 1.0), (columns[1] + 1, -1.0)], wrapped(gone_phi - phi), SAME),
    ];
    // Where their difference has no covariance they stay two.
    let update = Update::new(state, &rows).ok()?;
    update.fuse(state, &rows, false);
    let axes = Axes::new(*state.walls.get(kept)?);
    walls.get_mut(kept)?.extend(&axes, &gone_ends_m);
    state.swap_remove(gone);
    walls.swap_remove(gone);
    Some(gone)
}

fn are_one(state: &State, walls: &[Wall], one: usize, other: usize, gates: &Gates) -> bool {
    let (Some(line), Some(other_line)) = (state.walls.get(one), state.walls.get(other)) else { return false };
    let d = [line[0] - other_line[0], wrapped(line[1] - other_line[1])];
    let (Some(wall), Some(other_wall)) = (walls.get(one), walls.get(other)) else { return false };
    let is_near = d[0].abs() <= gates.distance_m && d[1].abs() <= gates.normal_rad;
    if !is_near || Axes::new(*line).gap_m(&wall.ends_m, &other_wall.ends_m) > 0.0 {
        return false;
    }
    let shared = state.between(one, other);
    let s = state.between(one, one) + state.between(other, other) - shared - shared.transpose();
    mahalanobis2(d, &s) <= gates.distance2
}
