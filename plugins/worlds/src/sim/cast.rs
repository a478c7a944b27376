//! Rays through a [`Lattice`]: exact to the edge of a wall's cell, analytic on solids.

use super::lattice::{LISTED, Lattice, WALL, quadrant};
use super::solid::Ray;

/// What a ray met first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Way over the plane, in cells.
    pub way: f64,
    /// The solid, or `None` for a wall of the background map.
    pub solid: Option<u32>,
}

/// A solid listed in a cell may be met a hair outside of it.
const OVERLAP: f64 = 1e-9;

impl Lattice {
    /// The first thing a ray meets within `reach` cells of way.
    pub fn cast(&self, ray: &Ray, reach: f64) -> Option<Hit> {
        if ray.slope == 0.0 { self.walk::<false>(ray, reach) } else { self.walk::<true>(ray, reach) }
    }

    /// `SLOPED` is decided outside the loop: most rays are level and need no heights.
    fn walk<const SLOPED: bool>(&self, ray: &Ray, reach: f64) -> Option<Hit> {
        let (from, along) = (ray.from, ray.along);
        let mut way = self.entry(ray)?;
        let leap = &self.leap[quadrant(along.x, along.y)];
        let (inverse_x, inverse_y) = (1.0 / along.x, 1.0 / along.y);
        let (right, up) = (along.x >= 0.0, along.y >= 0.0);
        let mut col = ((from.x + way * along.x).floor() as i64).clamp(0, self.width as i64 - 1);
        let mut row = ((from.y + way * along.y).floor() as i64).clamp(0, self.height as i64 - 1);
        if !SLOPED && !(0.0..=self.wall_height).contains(&ray.z) && self.solids.is_empty() {
            return None;
        }
        while way <= reach {
            let cell = row as usize * self.width + col as usize;
            let kind = leap[cell];
            if kind == WALL && !SLOPED {
                return Some(Hit { way, solid: None });
            }
            let edge = if kind == WALL || kind == LISTED { 1 } else { i64::from(kind) };
            let next_col = if right { col + edge } else { col - edge };
            let next_row = if up { row + edge } else { row - edge };
            let border_x = if right { next_col } else { next_col + 1 } as f64;
            let border_y = if up { next_row } else { next_row + 1 } as f64;
            // A ray along an axis never meets the borders beside it: 0 / 0 is not a way.
            let way_x = if along.x == 0.0 { f64::INFINITY } else { (border_x - from.x) * inverse_x };
            let way_y = if along.y == 0.0 { f64::INFINITY } else { (border_y - from.y) * inverse_y };
            let leave = way_x.min(way_y);
            if (kind == LISTED || (SLOPED && kind == WALL))
                && let Some(hit) = self.hit_in_cell(ray, cell, kind, way, leave)
            {
                return (hit.way <= reach).then_some(hit);
            }
            way = leave.max(way);
            if way_x < way_y {
                col = next_col;
                let (low, high) = if up { (row, next_row - 1) } else { (next_row + 1, row) };
                row = ((from.y + way * along.y).floor() as i64).clamp(low, high);
            } else {
                row = next_row;
                let (low, high) = if right { (col, next_col - 1) } else { (next_col + 1, col) };
                col = ((from.x + way * along.x).floor() as i64).clamp(low, high);
            }
            if col < 0 || row < 0 || col >= self.width as i64 || row >= self.height as i64 {
                return None;
            }
        }
        None
    }

    /// The first thing met inside one cell, between the ways at which the ray enters and leaves it.
    fn hit_in_cell(&self, ray: &Ray, cell: usize, kind: u8, enter: f64, leave: f64) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        if kind == WALL || self.is_walled(cell) {
            nearest = ray.between(0.0, self.wall_height).and_then(|(low, high)| {
                let way = enter.max(low);
                (way <= leave.min(high)).then_some(Hit { way, solid: None })
            });
        }
        for &idx in self.solids_in(cell) {
            if let Some(way) = self.solids[idx as usize].hit(ray)
                && way <= leave + OVERLAP
                && nearest.is_none_or(|hit| way < hit.way)
            {
                nearest = Some(Hit { way, solid: Some(idx) });
            }
        }
        nearest
    }

    /// The way at which a ray enters the lattice: 0 inside, `None` if it never does.
    fn entry(&self, ray: &Ray) -> Option<f64> {
        let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
        for (start, along, size) in
            [(ray.from.x, ray.along.x, self.width as f64), (ray.from.y, ray.along.y, self.height as f64)]
        {
            if along == 0.0 {
                if !(0.0..=size).contains(&start) {
                    return None;
                }
                continue;
            }
            let (a, b) = (-start / along, (size - start) / along);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        (enter <= leave).then_some(enter)
    }
}

#[cfg(test)]
mod tests;
