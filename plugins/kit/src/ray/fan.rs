//! Rays side by side: one in each lane of the processor's vectors, replaced by the next as it ends.

use super::{OUTSIDE, Ray, RayGrid, Walk};
use crate::simd::{Kernel, Vectors};

/// Rays under way at the same time: enough that the steps of some hide the waiting of others.
const LANES: usize = 16;

/// One number for each ray under way.
type Lane = [f64; LANES];

/// A place this near to an edge (in cells) may be taken for the wrong cell; then the edge crossings decide.
const NEAR_EDGE: f64 = 1e-9;

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
    fn run<V: Vectors>(self) {
        let Self { grid, origin, turn, directions, max_range, distances } = self;
        let mut waiting = directions.iter().zip(distances).filter_map(|(&direction, distance)| {
            *distance = max_range;
            let walk = grid.enter(&Ray::turned(origin, turn, direction))?;
            Some((walk, distance))
        });
        let mut lanes = Lanes::new();
        let mut answers: [Option<&mut f64>; LANES] = [const { None }; LANES];
        let mut n_under_way = 0;
        for (lane, answer) in answers.iter_mut().enumerate() {
            if let Some((walk, distance)) = waiting.next() {
                lanes.begin(lane, &walk);
                *answer = Some(distance);
                n_under_way += 1;
            }
        }
        // With empty lanes, stepping all of them is a waste.
        while n_under_way == LANES {
            let mut skips = [0; LANES];
            for (skip, cell) in skips.iter_mut().zip(lanes.cells(grid.stride)) {
                *skip = grid.skips.get(cell).copied().unwrap_or(OUTSIDE);
            }
            if lanes.any_ends(&skips, max_range) {
                for (lane, answer) in answers.iter_mut().enumerate() {
                    let Some(distance) = lanes.answer(lane, skips[lane], max_range) else { continue };
                    if let Some(answer) = answer.take() {
                        *answer = distance;
                    }
                    if let Some((walk, next)) = waiting.next() {
                        lanes.begin(lane, &walk);
                        *answer = Some(next);
                        skips[lane] =
                            grid.skips.get(lanes.cells(grid.stride)[lane]).copied().unwrap_or(OUTSIDE);
                    } else {
                        n_under_way -= 1;
                    }
                }
            } else {
                lanes.step(&skips);
            }
        }
        for (lane, answer) in answers.into_iter().enumerate() {
            if let Some(answer) = answer {
                let (walk, distance) = lanes.walk(lane);
                *answer = walk.run_from(distance, grid, max_range, i32::from);
            }
        }
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

    #[inline(always)]
    fn any_ends(&self, skips: &[u8; LANES], max_range: f64) -> bool {
        let mut any = false;
        for lane in 0..LANES {
            let is_far = self.entered[lane] + self.distance[lane] >= max_range;
            any |= is_far | (skips[lane] == 0) | (skips[lane] == OUTSIDE);
        }
        any
    }

    /// The answer of a ray that ends here.
    #[inline(always)]
    fn answer(&self, lane: usize, skip: u8, max_range: f64) -> Option<f64> {
        let distance = self.entered[lane] + self.distance[lane];
        match skip {
            0 => Some(distance.min(max_range)),
            OUTSIDE => Some(max_range),
            _ => (distance >= max_range).then_some(max_range),
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
            is_near_edge |= (past_edge < NEAR_EDGE) | (past_edge > 1.0 - NEAR_EDGE);
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
