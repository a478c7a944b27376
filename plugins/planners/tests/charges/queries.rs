//! Random ways through the warehouse: how many arrive, and how long they are.

use super::shortest::ShortestWays;
use super::warehouse::{groups, racks};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::{Point2, pose2};
use rumbo_core::map::{Grid, Line, Lines, Map};
use rumbo_core::messages::Goal;
use rumbo_core::robot::Robot;
use rumbo_core::stages::{GiveUp, PlanError, PlanRequest};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::potential::Obstacles;
use std::sync::Arc;

/// Edge of a cell of the warehouse's grid, meters.
pub const CELL_M: f64 = 0.1;

/// The warehouse as wall lines and as a grid.
pub fn map() -> Map {
    let ends = |p: Point2| [p.x, p.y];
    let line = |piece: &rumbo_kit::potential::Piece| Line {
        from: ends(piece.from),
        to: ends(piece.to),
        ..Line::default()
    };
    let lines: Vec<Line> = groups().iter().flatten().map(line).collect();
    let mut grid = Grid::unknown(400, 300, CELL_M).unwrap();
    let racks = racks();
    for (index, odds) in grid.cells.make_mut().iter_mut().enumerate() {
        let at = Point2::new((index % 400) as f64 + 0.5, (index / 400) as f64 + 0.5) * CELL_M;
        let is_in =
            |[low, high]: &[Point2; 2]| at.x > low.x && at.x < high.x && at.y > low.y && at.y < high.y;
        *odds = if racks.iter().any(is_in) { Grid::CERTAIN } else { -Grid::CERTAIN };
    }
    Map { version: 1, lines: Some(Lines { lines: lines.into() }), grid: Some(grid), ..Map::default() }
}

/// A question.
pub fn request(map: &Map, start: Point2, goal: Point2) -> PlanRequest {
    PlanRequest {
        stamp: Time::ZERO,
        map: map.clone(),
        grid: map.grid.clone(),
        start: pose2(start.x, start.y, 0.0),
        goal: Goal { position: goal, yaw_rad: None },
        robot: Arc::new(Robot::default()),
        obstacles: Vec::new(),
        give_up: GiveUp::default(),
        trace: Trace::unwatched(),
    }
}

/// Starts at least 0.5 m, and goals at least 1.05 m from obstacles: nearer than 1 m to one face no goal is at rest.
pub fn queries(n: usize, seed: u64) -> Vec<[Point2; 2]> {
    let obstacles = Obstacles::new(&groups(), 2.0).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut place = |clearance_m: f64| loop {
        let at = Point2::new(rng.random_range(0.0..40.0), rng.random_range(0.0..30.0));
        let is_in =
            |[low, high]: &[Point2; 2]| at.x > low.x && at.x < high.x && at.y > low.y && at.y < high.y;
        if obstacles.clearance_m(at) >= clearance_m && !racks().iter().any(is_in) {
            return at;
        }
    };
    (0..n).map(|_| [place(0.5), place(1.05)]).collect()
}

/// What a planner made of many questions.
#[derive(Default)]
pub struct Tally {
    pub n_arrived: usize,
    pub n_goals_refused: usize,
    pub n_stuck: usize,
    /// Of those that arrived: length by that of the shortest way, sorted.
    pub ratios: Vec<f64>,
}

impl Tally {
    pub fn of(
        queries: &[[Point2; 2]],
        map: &Map,
        shortest: &ShortestWays,
        mut plan: impl FnMut(&PlanRequest) -> Result<f64, PlanError>,
    ) -> Tally {
        let mut tally = Tally::default();
        for [start, goal] in queries {
            match plan(&request(map, *start, *goal)) {
                Ok(length_m) => {
                    tally.n_arrived += 1;
                    tally.ratios.push(length_m / shortest.length_m(*start, *goal));
                }
                Err(PlanError::GoalTooClose { .. }) => tally.n_goals_refused += 1,
                Err(PlanError::Stuck { .. } | PlanError::Unreachable { .. }) => tally.n_stuck += 1,
                Err(other) => panic!("from {start} to {goal}: {other}"),
            }
        }
        tally.ratios.sort_by(f64::total_cmp);
        tally
    }

    pub fn quantile(&self, share: f64) -> f64 {
        let last = self.ratios.len().saturating_sub(1);
        self.ratios.get((share * last as f64).round() as usize).copied().unwrap_or(f64::NAN)
    }

    pub fn mean(&self) -> f64 {
        self.ratios.iter().sum::<f64>() / self.ratios.len() as f64
    }
}
