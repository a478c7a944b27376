//! Rays side by side: one in each lane of the processor's vectors, replaced by the next as it ends.

// One loop over the lanes is one vector instruction per line.
#![allow(clippy::needless_range_loop)]

use super::{OUTSIDE, Ray, RayGrid, Walk};
use crate::simd::{Kernel, Vectors};

/// Rays under way at the same time: enough that the steps of some hide the waiting of others.
const LANES: usize = 16;

/// One number for each ray under way.
type Lane = [f64; LANES];

/// A place this near to an edge (in cells) may be taken for the wrong cell; then the edge crossings decide.
const NEAR_EDGE: f64 = 1e-9;

/// No ray is in this lane.
const NOTHING: usize = usize::MAX;

/// See [`RayGrid::cast_fan`].
pub(super) struct Fan<'a> {
    pub(super) grid: &'a RayGrid,
    pub(super) origin: [f64; 2],
    /// Sine and cosine of the heading.
    pub(super) turn: (f64, f64),
    pub(super) directions: &'a [[f64; 2]],
    pub(super) max_range: f64,
    pub(super) distances: &'a mut [f64],
}

impl Kernel for Fan<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(mut self) {
        let mut lanes = Lanes::new();
        let mut rays = [NOTHING; LANES];
        let mut next = 0;
        let mut n_under_way = 0;
        while n_under_way < LANES
            && let Some((_, ray)) = self.begin_next(&mut lanes, n_under_way, &mut next)
        {
            rays[n_under_way] = ray;
            n_under_way += 1;
        }
        // With empty lanes, stepping all of them is a waste.
        while n_under_way == LANES {
            let mut skips = [0; LANES];
            for (skip, cell) in skips.iter_mut().zip(lanes.cells(self.grid.stride)) {
                *skip = self.grid.skip_at(cell);
            }
            let mut ended = lanes.ended(&skips, self.max_range);
            while ended != 0 {
                let lane = ended.trailing_zeros() as usize;
                self.distances[rays[lane]] = lanes.answer(lane, skips[lane], self.max_range);
                let Some((skip, ray)) = self.begin_next(&mut lanes, lane, &mut next) else {
                    n_under_way -= 1;
                    lanes.rest(lane);
                    skips[lane] = 1;
                    rays[lane] = NOTHING;
                    ended &= ended - 1;
                    continue;
                };
                (skips[lane], rays[lane]) = (skip, ray);
                if !lanes.has_ended(lane, skip, self.max_range) {
                    ended &= ended - 1;
                }
            }
            lanes.step(&skips);
        }
        for (lane, ray) in rays.into_iter().enumerate() {
            if ray != NOTHING {
                let (walk, distance) = lanes.walk(lane);
                self.distances[ray] = walk.run_from(distance, self.grid, self.max_range, i32::from);
            }
        }
    }
}

impl Fan<'_> {
    /// Puts the next ray that meets the map into a lane: its first skip and its number. Those that do not are answered.
    #[inline(always)]
    fn begin_next(&mut self, lanes: &mut Lanes, lane: usize, next: &mut usize) -> Option<(u8, usize)> {
        while let Some(&direction) = self.directions.get(*next) {
            let ray = *next;
            *next += 1;
            if let Some(walk) = self.grid.enter(&Ray::turned(self.origin, self.turn, direction)) {
                lanes.begin(lane, &walk);
                return Some((self.grid.skip_at(walk.index(self.grid.stride)), ray));
            }
            self.distances[ray] = self.max_range;
        }
        None
    }
}

/// The rays under way, by field. Cells and steps are whole numbers kept as `f64`.
struct Lanes {
    origin: [Lane; 2],
    direction: [Lane; 2],
    inverse: [Lane; 2],
    /// First edge relative to the cell, less one step: the n-th edge is at `cell + offset + n * step`.
    offset: [Lane; 2],
    step: [Lane; 2],
    cell: [Lane; 2],
    distance: Lane,
    entered: Lane,
}

impl Lanes {
    #[inline(always)]
    fn new() -> Self {
        const ZERO: [Lane; 2] = [[0.0; LANES]; 2];
        Self {
            origin: ZERO,
            direction: ZERO,
            inverse: ZERO,
            offset: ZERO,
            step: ZERO,
            cell: ZERO,
            distance: [0.0; LANES],
            entered: [0.0; LANES],
        }
    }

    #[inline(always)]
    fn begin(&mut self, lane: usize, walk: &Walk) {
        for (k, axis) in [&walk.x, &walk.y].into_iter().enumerate() {
            self.origin[k][lane] = axis.origin;
            self.direction[k][lane] = axis.direction;
            self.inverse[k][lane] = axis.inverse;
            self.offset[k][lane] = f64::from(axis.first_edge - axis.step);
            self.step[k][lane] = f64::from(axis.step);
            self.cell[k][lane] = f64::from(axis.cell);
        }
        self.distance[lane] = 0.0;
        self.entered[lane] = walk.entered;
    }

    /// The ray of a lane, to be walked on its own.
    #[inline(always)]
    fn walk(&self, lane: usize) -> (Walk, f64) {
        let axis = |k: usize| super::Axis {
            origin: self.origin[k][lane],
            direction: self.direction[k][lane],
            inverse: self.inverse[k][lane],
            cell: self.cell[k][lane] as i32,
            step: self.step[k][lane] as i32,
            first_edge: (self.offset[k][lane] + self.step[k][lane]) as i32,
        };
        (Walk { x: axis(0), y: axis(1), entered: self.entered[lane] }, self.distance[lane])
    }

    /// Where the present cells lie among the skips.
    #[inline(always)]
    fn cells(&self, stride: usize) -> [usize; LANES] {
        // Adding this leaves a whole number in the low bits: the cheapest conversion there is.
        const WHOLE: f64 = (1_u64 << 52) as f64;
        let mut cells = [0; LANES];
        for lane in 0..LANES {
            let index = (self.cell[1][lane] + 1.0) * stride as f64 + (self.cell[0][lane] + 1.0);
            cells[lane] = (index + WHOLE).to_bits() as u32 as usize;
        }
        cells
    }

    /// Bit `i` says that the ray in lane `i` ends where it is.
    #[inline(always)]
    fn ended(&self, skips: &[u8; LANES], max_range: f64) -> u32 {
        let mut ended = 0;
        for lane in 0..LANES {
            ended |= u32::from(self.has_ended(lane, skips[lane], max_range)) << lane;
        }
        ended
    }

    #[inline(always)]
    fn has_ended(&self, lane: usize, skip: u8, max_range: f64) -> bool {
        let is_far = self.entered[lane] + self.distance[lane] >= max_range;
        // 0 and OUTSIDE in one test.
        is_far | (skip.wrapping_sub(1) >= OUTSIDE - 1)
    }

    /// The answer of a ray that ends here.
    #[inline(always)]
    fn answer(&self, lane: usize, skip: u8, max_range: f64) -> f64 {
        let distance = self.entered[lane] + self.distance[lane];
        if skip == 0 && distance < max_range { distance } else { max_range }
    }

    /// Leaves a lane standing in the first cell.
    #[inline(always)]
    fn rest(&mut self, lane: usize) {
        for k in 0..2 {
            (self.direction[k][lane], self.inverse[k][lane], self.step[k][lane]) = (0.0, 0.0, 0.0);
            (self.cell[k][lane], self.origin[k][lane]) = (0.0, 0.5);
        }
    }

    /// Moves every ray out of the empty square around its cell, as [`Walk::run_from`] does.
    #[inline(always)]
    fn step(&mut self, skips: &[u8; LANES]) {
        let mut before = [[0.0; LANES]; 2];
        let mut is_near_edge = false;
        for lane in 0..LANES {
            let n = f64::from(skips[lane]);
            let square_edge = |k: usize| {
                let edge = self.cell[k][lane] + self.offset[k][lane] + self.step[k][lane] * n;
                (edge - self.origin[k][lane]) * self.inverse[k][lane]
            };
            let (to_x, to_y) = (square_edge(0), square_edge(1));
            let along_x = to_x <= to_y;
            let distance = if along_x { to_x } else { to_y };
            let side = |k: usize| self.origin[k][lane] + distance * self.direction[k][lane];
            let place = if along_x { side(1) } else { side(0) };
            let cell = place.floor();
            let past_edge = place - cell;
            is_near_edge |= (past_edge - 0.5).abs() > 0.5 - NEAR_EDGE;
            let beyond = |k: usize| self.cell[k][lane] + self.step[k][lane] * n;
            let (beyond_x, beyond_y) = (beyond(0), beyond(1));
            before[0][lane] = self.cell[0][lane];
            before[1][lane] = self.cell[1][lane];
            self.cell[0][lane] = if along_x { beyond_x } else { cell };
            self.cell[1][lane] = if along_x { cell } else { beyond_y };
            self.distance[lane] = distance;
        }
        if is_near_edge {
            self.cell = before;
            self.step_one_by_one(skips);
        }
    }

    #[inline(never)]
    fn step_one_by_one(&mut self, skips: &[u8; LANES]) {
        for (lane, &skip) in skips.iter().enumerate() {
            let (mut walk, mut distance) = self.walk(lane);
            walk.leave_square(i32::from(skip), &mut distance);
            self.cell[0][lane] = f64::from(walk.x.cell);
            self.cell[1][lane] = f64::from(walk.y.cell);
            self.distance[lane] = distance;
        }
    }
}
