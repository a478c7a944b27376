//! Rays through a [`Lattice`]: exact to the edge of a wall's cell, analytic on solids.

use super::lattice::{Kind, Lattice, quadrant};
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
/// Rays of a fan walk together: while one waits for its cell, the others go on.
const ABREAST: usize = 8;

/// One dimension of a walk, mirrored where the ray goes down, so that every walk goes up.
#[derive(Clone, Copy)]
struct Axis {
    from: f64,
    along: f64,
    inverse: f64,
    /// The cell it is in.
    at: i32,
}

/// Adding this to a small number leaves its nearest whole number in the low bits (ties to even): much cheaper than a
/// checked conversion.
const ROUNDER: f64 = 1.5 * (1u64 << 52) as f64;

impl Axis {
    /// An axis at `way`; the cell is `cell` of the lattice.
    #[inline(always)]
    fn new(from: f64, along: f64, way: f64, n_cells: usize) -> Self {
        let cell = ((from + way * along) as i32).clamp(0, n_cells as i32 - 1);
        // The border ahead is never at `from` itself, so the largest number stands for "never".
        let inverse = if along == 0.0 { f64::MAX } else { 1.0 / along.abs() };
        if along < 0.0 {
            Self { from: -from, along: -along, inverse, at: -1 - cell }
        } else {
            Self { from, along, inverse, at: cell }
        }
    }

    /// Way to the lower border of cell `next`.
    #[inline(always)]
    fn way_to(&self, next: i32) -> f64 {
        (f64::from(next) - self.from) * self.inverse
    }

    /// The cell at a way, which lies between the present one and the one before `next`.
    #[inline(always)]
    fn cell_at(&self, way: f64, next: i32) -> i32 {
        // Exactly on a border this may give the cell below; the next step then has no length.
        let floor = ((self.from + way * self.along - 0.5) + ROUNDER).to_bits() as i32;
        floor.max(self.at).min(next - 1)
    }
}

/// A ray on its way.
#[derive(Clone, Copy)]
struct Walk<'a> {
    x: Axis,
    y: Axis,
    way: f64,
    reach: f64,
    leap: &'a [u8],
    /// Position in the arrays of the mirrored cell (0, 0), and from one mirrored column or row to the next.
    base: i32,
    col_step: i32,
    row_step: i32,
}

enum Step {
    On,
    End(Option<Hit>),
}

impl<'a> Walk<'a> {
    /// `None` when the ray never comes into the lattice.
    #[inline(always)]
    fn new(lattice: &'a Lattice, ray: &Ray, reach: f64) -> Option<Self> {
        let (width, height) = (lattice.width as f64, lattice.height as f64);
        let inside = ray.from.x >= 0.0 && ray.from.y >= 0.0 && ray.from.x < width && ray.from.y < height;
        let way = if inside { 0.0 } else { entry(ray, width, height)? };
        let quadrant = quadrant(ray.along.x, ray.along.y);
        let stride = lattice.stride() as i32;
        let (left, down) = ((quadrant & 1) as i32, (quadrant >> 1) as i32);
        Some(Self {
            x: Axis::new(ray.from.x, ray.along.x, way, lattice.width),
            y: Axis::new(ray.from.y, ray.along.y, way, lattice.height),
            way,
            reach,
            leap: &lattice.leap[quadrant],
            base: stride + 1 - left - down * stride,
            col_step: 1 - 2 * left,
            row_step: stride * (1 - 2 * down),
        })
    }

    /// Leaps over the empty square around the present cell, or looks into the cell.
    #[inline(always)]
    fn step(&mut self, lattice: &Lattice, ray: &Ray) -> Step {
        if self.way > self.reach {
            return Step::End(None);
        }
        let cell = (self.base + self.x.at * self.col_step + self.y.at * self.row_step) as usize;
        let mut edge = i32::from(self.leap[cell]);
        if edge == 0 {
            match self.look(lattice, ray, cell) {
                Step::On => edge = 1,
                end => return end,
            }
        }
        let (next_x, next_y) = (self.x.at + edge, self.y.at + edge);
        let (way_x, way_y) = (self.x.way_to(next_x), self.y.way_to(next_y));
        self.way = way_x.min(way_y);
        // Both cells are worked out and one is chosen: which border comes first is a coin toss no predictor wins.
        let (cell_x, cell_y) = (self.x.cell_at(self.way, next_x), self.y.cell_at(self.way, next_y));
        let crosses_x = way_x < way_y;
        self.x.at = if crosses_x { next_x } else { cell_x };
        self.y.at = if crosses_x { cell_y } else { next_y };
        Step::On
    }

    /// What a cell that is not empty does to the ray.
    fn look(&self, lattice: &Lattice, ray: &Ray, cell: usize) -> Step {
        let kind = lattice.kind(cell);
        if kind == Kind::Outside {
            return Step::End(None);
        }
        if kind == Kind::Wall && ray.slope == 0.0 {
            let met = (0.0..=lattice.wall_height).contains(&ray.z);
            return if met { Step::End(Some(Hit { way: self.way, solid: None })) } else { Step::On };
        }
        let leave = self.x.way_to(self.x.at + 1).min(self.y.way_to(self.y.at + 1));
        match lattice.hit_in_cell(ray, cell, self.way, leave) {
            Some(hit) => Step::End((hit.way <= self.reach).then_some(hit)),
            None => Step::On,
        }
    }
}

impl Lattice {
    /// The first thing a ray meets within `reach` cells of way.
    pub fn cast(&self, ray: &Ray, reach: f64) -> Option<Hit> {
        let mut walk = Walk::new(self, ray, reach)?;
        loop {
            if let Step::End(hit) = walk.step(self, ray) {
                return hit;
            }
        }
    }

    /// Casts `n_rays` rays, each given by its number with its reach; `done` is called once for each, in no particular
    /// order, with its number, the ray, its reach and what it met.
    pub fn cast_all(
        &self,
        n_rays: usize,
        ray_of: impl Fn(usize) -> (Ray, f64),
        mut done: impl FnMut(usize, &Ray, f64, Option<Hit>),
    ) {
        for first in (0..n_rays).step_by(ABREAST) {
            let n_abreast = ABREAST.min(n_rays - first);
            // Places beyond the last ray repeat it and stay empty.
            let rays: [(Ray, f64); ABREAST] =
                std::array::from_fn(|idx| ray_of(first + idx.min(n_abreast - 1)));
            let mut walks: [Option<Walk<'_>>; ABREAST] = [None; ABREAST];
            let mut n_walking = 0;
            for (idx, (ray, reach)) in rays[..n_abreast].iter().enumerate() {
                walks[idx] = Walk::new(self, ray, *reach);
                match walks[idx] {
                    Some(_) => n_walking += 1,
                    None => done(first + idx, ray, *reach, None),
                }
            }
            while n_walking > 0 {
                for (idx, slot) in walks.iter_mut().enumerate() {
                    let Some(walk) = slot else { continue };
                    let (ray, reach) = &rays[idx];
                    if let Step::End(hit) = walk.step(self, ray) {
                        done(first + idx, ray, *reach, hit);
                        *slot = None;
                        n_walking -= 1;
                    }
                }
            }
        }
    }

    /// The first thing met inside one cell, between the ways at which the ray enters and leaves it.
    fn hit_in_cell(&self, ray: &Ray, cell: usize, enter: f64, leave: f64) -> Option<Hit> {
        let mut nearest: Option<Hit> = None;
        if matches!(self.kind(cell), Kind::Wall | Kind::WalledAndListed) {
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
}

/// The way at which a ray from outside enters the lattice, if it ever does.
fn entry(ray: &Ray, width: f64, height: f64) -> Option<f64> {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for (start, along, size) in [(ray.from.x, ray.along.x, width), (ray.from.y, ray.along.y, height)] {
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

#[cfg(test)]
mod tests;
