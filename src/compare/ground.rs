//! The floor of a world as a robot of one size may use it.

use rand_xoshiro::rand_core::Rng as _;
use rumbo_core::rng::Rng;
use rumbo_kit::cost_field::{CostField, StepRule, Until};
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::map_file::MapImage;
use rumbo_kit::{GridSize, NEIGHBORS_8};

/// The robot stands with this distance between hull and walls at its start and its goal, meters: room to turn and stop.
const STAND_M: f64 = 0.3;
/// A passage counts as one when it leaves this distance on both sides of the hull, meters.
const PASS_M: f64 = 0.1;
/// Ways keep this distance from walls where they can, and one step costs e times as much for each of these lengths less,
/// meters: what the planner `dp` does by default (Hernández Alamilla 2005, section 3.2.3).
const PREFERRED_M: f64 = 0.45;
const PENALTY_M: f64 = 0.05;
/// Goals that are tried.
const MOST_GOALS: usize = 100;

/// Cells that a robot may pass, and the middles of those where it may stand in the largest part that passages join.
#[derive(Debug, Clone, PartialEq)]
pub struct Ground {
    size: GridSize,
    resolution_m: f64,
    origin: [f64; 3],
    is_floor: Vec<bool>,
    is_open: Vec<bool>,
    /// What a step into a cell costs a planner that keeps away from walls, at least 1; infinite where none goes.
    entries: Vec<f64>,
    /// Meters.
    pub middles: Vec<[f64; 2]>,
}

/// How near to walls a robot passes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Passing {
    /// With room on both sides of the hull.
    WithRoom,
    /// As near as can be.
    Narrowly,
}

impl Passing {
    fn beside_m(self) -> f64 {
        match self {
            Passing::WithRoom => PASS_M,
            Passing::Narrowly => 0.0,
        }
    }
}

/// What the ways from one place cost.
pub struct Ways(Vec<f64>);

impl Ways {
    fn to(&self, cell: usize) -> f64 {
        self.0.get(cell).copied().unwrap_or(f64::INFINITY)
    }
}

impl Ground {
    /// Of a map, for a robot with this radius.
    pub fn of(image: &MapImage, radius_m: f64, passing: Passing) -> Ground {
        let size = GridSize::new(image.width, image.height);
        let marked: Vec<u8> =
            image.cells.iter().map(|percent| u8::from(!(0..=50).contains(percent))).collect();
        let field = squared_distance_field(size, &marked);
        // From middle to middle; a wall begins half a cell before the middle of its own.
        let squared = |clearance_m: f64| ((radius_m + clearance_m) / image.resolution_m + 0.5).powi(2);
        let (pass, stand) = (squared(passing.beside_m()), squared(STAND_M));
        let is_open: Vec<bool> = field.iter().map(|d| f64::from(*d) >= pass).collect();
        // From a cell's middle to that of the nearest wall cell, as planners on a grid count.
        let entry = |(squared, is_open): (&u32, &bool)| {
            let near_m = PREFERRED_M - f64::from(*squared).sqrt() * image.resolution_m;
            let penalty = if near_m > 0.0 { (near_m / PENALTY_M).exp() } else { 0.0 };
            if *is_open { 1.0 + penalty } else { f64::INFINITY }
        };
        let entries = field.iter().zip(&is_open).map(entry).collect();
        let is_floor = marked.iter().map(|marked| *marked == 0).collect();
        let (resolution_m, origin) = (image.resolution_m, image.origin);
        let mut ground =
            Ground { size, resolution_m, origin, is_floor, is_open, entries, middles: Vec::new() };
        let may_stand = |cell: &usize| field.get(*cell).is_some_and(|d| f64::from(*d) >= stand);
        let cells = largest_room(size, &ground.is_open).into_iter().filter(may_stand);
        ground.middles = cells.map(|cell| ground.middle(cell)).collect();
        ground
    }

    /// Edge of a cell, meters.
    pub fn step_m(&self) -> f64 {
        self.resolution_m
    }

    /// A place to stand.
    pub fn place(&self, rng: &mut Rng) -> [f64; 2] {
        pick(&self.middles, rng).unwrap_or_default()
    }

    /// Nothing stands there.
    pub fn is_floor(&self, at: [f64; 2]) -> bool {
        self.cell(at).and_then(|cell| self.is_floor.get(cell)).is_some_and(|is_floor| *is_floor)
    }

    /// The robot may pass there.
    pub fn is_open(&self, at: [f64; 2]) -> bool {
        self.cell(at).and_then(|cell| self.is_open.get(cell)).is_some_and(|is_open| *is_open)
    }

    /// Whether a robot gets from one place to another.
    pub fn are_joined(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let length = self.ways_from(from).zip(self.cell(to)).map(|(ways, cell)| ways.to(cell));
        length.is_some_and(f64::is_finite)
    }

    /// The ways from a place; none where a robot cannot stand there.
    pub fn ways_from(&self, from: [f64; 2]) -> Option<Ways> {
        let source = self.cell(from).filter(|_| self.is_open(from))?;
        let mut field = CostField::new();
        field.set_entry_costs(self.size, &self.entries, StepRule::default());
        field.grow(source, Until::Everywhere, || false).ok()?;
        Some(Ways(field.to_vec()))
    }

    /// A place to stand to which the way has a length in this range, meters, with that way.
    pub fn goal(&self, ways: &Ways, [from_m, to_m]: [f64; 2], rng: &mut Rng) -> Option<Vec<[f64; 2]>> {
        (0..MOST_GOALS).find_map(|_| {
            let way = self.way(ways, self.place(rng));
            (way.len() > 1 && (from_m..=to_m).contains(&length_m(&way))).then_some(way)
        })
    }

    /// The way to a place, from where `ways` begin.
    pub fn way(&self, ways: &Ways, to: [f64; 2]) -> Vec<[f64; 2]> {
        let mut cells: Vec<usize> = self.cell(to).into_iter().collect();
        while let Some(&cell) = cells.last() {
            let near = NEIGHBORS_8.into_iter().filter_map(|(dx, dy)| self.size.neighbor(cell, dx, dy));
            let next = near.min_by(|a, b| ways.to(*a).total_cmp(&ways.to(*b)));
            match next.filter(|next| ways.to(*next) < ways.to(cell)) {
                Some(next) => cells.push(next),
                None => break,
            }
        }
        cells.into_iter().rev().map(|cell| self.middle(cell)).collect()
    }

    /// The same way made of as few straight pieces as keep its distance from walls (algorithm 3.3 of the planner `dp`), in
    /// steps of a cell.
    pub fn refined(&self, way: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let mut refined: Vec<[f64; 2]> = way.first().copied().into_iter().collect();
        let mut idx = 0;
        while let Some(from) = way.get(idx) {
            let is_clear = |next: &usize| {
                let part = way.get(idx..=*next).unwrap_or_default();
                let dearest = part.iter().map(|place| self.entry(*place)).fold(1.0, f64::max);
                let to = part.last().copied().unwrap_or(*from);
                self.steps(*from, to).all(|place| self.entry(place) <= dearest)
            };
            // From a cell to the next one the way itself leads.
            let next = (idx + 2..way.len()).rev().find(is_clear).unwrap_or(idx + 1);
            refined.extend(way.get(next).into_iter().flat_map(|to| self.steps(*from, *to)));
            idx = next;
        }
        refined
    }

    /// Places between two, the last one included.
    fn steps(&self, from: [f64; 2], to: [f64; 2]) -> impl Iterator<Item = [f64; 2]> + use<> {
        let n = ((to[0] - from[0]).hypot(to[1] - from[1]) / self.resolution_m).ceil().max(1.0) as usize;
        let at = move |share: f64| [0, 1].map(|axis: usize| from[axis] + (to[axis] - from[axis]) * share);
        (1..=n).map(move |step| at(step as f64 / n as f64))
    }

    fn entry(&self, at: [f64; 2]) -> f64 {
        self.cell(at).and_then(|cell| self.entries.get(cell)).copied().unwrap_or(f64::INFINITY)
    }

    fn middle(&self, cell: usize) -> [f64; 2] {
        let (col, row) = self.size.col_row(cell);
        let along = |count: usize| (count as f64 + 0.5) * self.resolution_m;
        let [left_m, bottom_m, yaw_rad] = self.origin;
        let (sin, cos) = yaw_rad.sin_cos();
        [left_m + cos * along(col) - sin * along(row), bottom_m + sin * along(col) + cos * along(row)]
    }

    fn cell(&self, [x, y]: [f64; 2]) -> Option<usize> {
        let [left_m, bottom_m, yaw_rad] = self.origin;
        let ((sin, cos), x, y) = (yaw_rad.sin_cos(), x - left_m, y - bottom_m);
        let [col, row] = [cos * x + sin * y, cos * y - sin * x].map(|m| (m / self.resolution_m).floor());
        let is_inside =
            (0.0..self.size.width as f64).contains(&col) && (0.0..self.size.height as f64).contains(&row);
        is_inside.then(|| row as usize * self.size.width + col as usize)
    }
}

fn length_m(way: &[[f64; 2]]) -> f64 {
    way.windows(2).map(|leg| (leg[1][0] - leg[0][0]).hypot(leg[1][1] - leg[0][1])).sum()
}

fn pick(places: &[[f64; 2]], rng: &mut Rng) -> Option<[f64; 2]> {
    let idx = ((u128::from(rng.next_u64()) * places.len() as u128) >> 64) as usize;
    places.get(idx).copied()
}

/// Cells of the largest connected part.
fn largest_room(size: GridSize, open: &[bool]) -> Vec<usize> {
    let mut unseen = open.to_vec();
    let mut largest = Vec::new();
    for first in 0..open.len() {
        if !take(&mut unseen, first) {
            continue;
        }
        let mut room = vec![first];
        let mut next = 0;
        while let Some(&cell) = room.get(next) {
            next += 1;
            let near = NEIGHBORS_8.into_iter().filter_map(|(dx, dy)| size.neighbor(cell, dx, dy));
            room.extend(near.filter(|near| take(&mut unseen, *near)));
        }
        if room.len() > largest.len() {
            largest = room;
        }
    }
    largest
}

/// It was there, and is not any more.
fn take(unseen: &mut [bool], cell: usize) -> bool {
    unseen.get_mut(cell).is_some_and(|place| std::mem::replace(place, false))
}
