//! Rays side by side: one in each lane of the processor's vectors, replaced by the next as it ends.

// One loop over the lanes is one vector instruction per line.
#![allow(clippy::needless_range_loop)]

use super::{Axis, OUTSIDE, Ray, RayGrid, Walk};
use crate::simd::{Kernel, Vectors};

/// Rays under way at the same time: enough that the steps of some hide the waiting of others.
const LANES: usize = 16;
/// Rays made ready at a time.
const BATCH: usize = 64;
/// A place this near to an edge (in cells) may be taken for the wrong cell; then the edge crossings decide.
const NEAR_EDGE: f64 = 1e-9;
/// No ray is in this lane.
const NOTHING: usize = usize::MAX;

/// One number for each ray under way.
type Lane = [f64; LANES];

/// A fan whose origin lies inside the map: see [`RayGrid::cast_fan`].
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
    fn run<V: Vectors>(self) {
        let Self { grid, origin, turn, directions, max_range, distances } = self;
        let mut waiting =
            Waiting { origin, turn, directions, n_ready: 0, next: 0, ready: [[[0.0; BATCH]; 2]; 3] };
        let mut lanes = Lanes::new(origin, grid);
        let mut rays = [NOTHING; LANES];
        let first_skip = grid.skip_at(lanes.cells(grid.stride)[0]);
        if first_skip == 0 || max_range <= 0.0 {
            distances.fill(max_range.min(0.0));
            return;
        }
        let mut n_under_way = 0;
        while n_under_way < LANES && waiting.begin(&mut lanes, n_under_way) {
            rays[n_under_way] = n_under_way;
            n_under_way += 1;
        }
        // With empty lanes, stepping all of them is a waste.
        while n_under_way == LANES {
            let mut skips = [0; LANES];
            for (skip, cell) in skips.iter_mut().zip(lanes.cells(grid.stride)) {
                *skip = grid.skip_at(cell);
            }
            let mut ended = lanes.ended(&skips, max_range);
            while ended != 0 {
                let lane = ended.trailing_zeros() as usize;
                ended &= ended - 1;
                let is_hit = skips[lane] == 0 && lanes.distance[lane] < max_range;
                distances[rays[lane]] = if is_hit { lanes.distance[lane] } else { max_range };
                rays[lane] = waiting.next;
                if !waiting.begin(&mut lanes, lane) {
                    rays[lane] = NOTHING;
                    n_under_way -= 1;
                    lanes.rest(lane);
                }
                skips[lane] = first_skip;
            }
            lanes.step(&skips);
        }
        for (lane, ray) in rays.into_iter().enumerate().filter(|(_, ray)| *ray != NOTHING) {
            distances[ray] = lanes.walk(lane).run_from(lanes.distance[lane], grid, max_range, i32::from);
        }
    }
}

/// The rays that have not begun, a batch of them made ready.
struct Waiting<'a> {
    origin: [f64; 2],
    turn: (f64, f64),
    directions: &'a [[f64; 2]],
    n_ready: usize,
    next: usize,
    /// Direction, its inverse and its sign, along x and y.
    ready: [[[f64; BATCH]; 2]; 3],
}

impl Waiting<'_> {
    /// Puts the next ray into a lane; false when there is none.
    #[inline(always)]
    fn begin(&mut self, lanes: &mut Lanes, lane: usize) -> bool {
        if self.next == self.n_ready && !self.make_ready() {
            return false;
        }
        let i = self.next % BATCH;
        for k in 0..2 {
            lanes.direction[k][lane] = self.ready[0][k][i];
            lanes.inverse[k][lane] = self.ready[1][k][i];
            lanes.step[k][lane] = self.ready[2][k][i];
            lanes.cell[k][lane] = lanes.first_cell[k];
        }
        lanes.distance[lane] = 0.0;
        self.next += 1;
        true
    }

    #[inline(always)]
    fn make_ready(&mut self) -> bool {
        let batch = &self.directions[self.n_ready..];
        let batch = &batch[..batch.len().min(BATCH)];
        for (i, direction) in batch.iter().enumerate() {
            let ray = Ray::turned(self.origin, self.turn, *direction);
            for (k, along) in [ray.dir_x, ray.dir_y].into_iter().enumerate() {
                self.ready[0][k][i] = along;
                self.ready[1][k][i] = Axis::inverse(along);
                self.ready[2][k][i] = if along >= 0.0 { 1.0 } else { -1.0 };
            }
        }
        self.n_ready += batch.len();
        !batch.is_empty()
    }
}

/// The rays under way, by field. Cells and steps are whole numbers kept as `f64`.
struct Lanes {
    origin: [f64; 2],
    first_cell: [f64; 2],
    direction: [Lane; 2],
    inverse: [Lane; 2],
    step: [Lane; 2],
    cell: [Lane; 2],
    distance: Lane,
}

impl Lanes {
    #[inline(always)]
    fn new(origin: [f64; 2], grid: &RayGrid) -> Self {
        let first = [(origin[0], grid.size.width), (origin[1], grid.size.height)]
            .map(|(origin, n_cells)| f64::from(Axis::new(origin, 1.0, n_cells).cell));
        Self {
            origin,
            first_cell: first,
            direction: [[0.0; LANES]; 2],
            inverse: [[0.0; LANES]; 2],
            step: [[0.0; LANES]; 2],
            cell: first.map(|first| [first; LANES]),
            distance: [0.0; LANES],
        }
    }

    /// The ray of a lane, to be walked on its own.
    #[inline(always)]
    fn walk(&self, lane: usize) -> Walk {
        let axis = |k: usize| Axis {
            origin: self.origin[k],
            direction: self.direction[k][lane],
            inverse: self.inverse[k][lane],
            cell: self.cell[k][lane] as i32,
            step: self.step[k][lane] as i32,
            first_edge: i32::from(self.step[k][lane] > 0.0),
        };
        Walk { x: axis(0), y: axis(1), entered: 0.0 }
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
            // 0 and OUTSIDE in one test.
            let is_stopped = skips[lane].wrapping_sub(1) >= OUTSIDE - 1;
            ended |= u32::from((self.distance[lane] >= max_range) | is_stopped) << lane;
        }
        ended
    }

    /// Leaves a lane standing in the first cell.
    #[inline(always)]
    fn rest(&mut self, lane: usize) {
        for k in 0..2 {
            (self.direction[k][lane], self.inverse[k][lane], self.step[k][lane]) = (0.0, 0.0, 0.0);
            self.cell[k][lane] = self.first_cell[k];
        }
        self.distance[lane] = 0.0;
    }

    /// Moves every ray out of the empty square around its cell, as [`Walk::leave_square`] does.
    #[inline(always)]
    fn step(&mut self, skips: &[u8; LANES]) {
        let before = self.cell;
        let [origin_x, origin_y] = self.origin;
        let ([step_xs, step_ys], [inverse_xs, inverse_ys]) = (&self.step, &self.inverse);
        let [direction_xs, direction_ys] = &self.direction;
        let n: Lane = std::array::from_fn(|lane| f64::from(skips[lane]));
        let mut cells = [[0.0; LANES]; 2];
        let mut distances = [0.0; LANES];
        let mut from_middle = [0.0; LANES];
        for lane in 0..LANES {
            let (step_x, step_y) = (step_xs[lane], step_ys[lane]);
            let (beyond_x, beyond_y) =
                (before[0][lane] + step_x * n[lane], before[1][lane] + step_y * n[lane]);
            // A ray going up leaves a cell by its upper edge, one going down by its lower.
            let edge_x = beyond_x + if step_x > 0.0 { 0.0 } else { 1.0 };
            let edge_y = beyond_y + if step_y > 0.0 { 0.0 } else { 1.0 };
            let to_x = (edge_x - origin_x) * inverse_xs[lane];
            let to_y = (edge_y - origin_y) * inverse_ys[lane];
            let along_x = to_x <= to_y;
            let distance = if along_x { to_x } else { to_y };
            let (place_x, place_y) =
                (origin_x + distance * direction_xs[lane], origin_y + distance * direction_ys[lane]);
            let place = if along_x { place_y } else { place_x };
            let cell = place.floor();
            from_middle[lane] = (place - cell - 0.5).abs();
            cells[0][lane] = if along_x { beyond_x } else { cell };
            cells[1][lane] = if along_x { cell } else { beyond_y };
            distances[lane] = distance;
        }
        let mut is_near_edge = false;
        for lane in 0..LANES {
            is_near_edge |= from_middle[lane] > 0.5 - NEAR_EDGE;
        }
        self.cell = cells;
        let distances_before = std::mem::replace(&mut self.distance, distances);
        if is_near_edge {
            (self.cell, self.distance) = (before, distances_before);
            self.step_one_by_one(skips);
        }
    }

    #[inline(never)]
    fn step_one_by_one(&mut self, skips: &[u8; LANES]) {
        for (lane, &skip) in skips.iter().enumerate() {
            let mut walk = self.walk(lane);
            walk.leave_square(i32::from(skip), &mut self.distance[lane]);
            self.cell[0][lane] = f64::from(walk.x.cell);
            self.cell[1][lane] = f64::from(walk.y.cell);
        }
    }
}
