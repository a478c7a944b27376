//! The search: A* in which a cell's parent may be any cell that sees it.

use super::floor::Floor;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Why there is no way.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoWay {
    /// Nobody waits for it any more.
    GivenUp,
    /// Obstacles close every way.
    Closed,
}

/// A cell to look at, the most promising first; among equals the one with the lowest number, so that every run decides
/// the same.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Open {
    promise: f64,
    cell: usize,
}

impl Eq for Open {}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.promise.total_cmp(&self.promise).then(other.cell.cmp(&self.cell))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// What is known of a cell.
#[derive(Debug, Clone, Copy)]
struct Reached {
    length: f64,
    parent: usize,
    done: bool,
}

/// Cells that are expanded between two looks at whether anybody still waits.
const EXPANSIONS_A_LOOK: u64 = 500;

/// The memory of a search, kept from one to the next.
#[derive(Debug, Default)]
pub struct ThetaStar {
    reached: Vec<Reached>,
    open: BinaryHeap<Open>,
    /// Cells that the last search expanded.
    pub n_expanded: u64,
}

impl ThetaStar {
    /// The corners of the way from one cell to another, both included, and its length in cells.
    pub fn search(
        &mut self,
        floor: &Floor,
        (start, goal): (usize, usize),
        greediness: f64,
        give_up: impl Fn() -> bool,
    ) -> Result<(Vec<usize>, f64), NoWay> {
        self.reached.clear();
        self.reached.resize(floor.len(), Reached { length: f64::INFINITY, parent: start, done: false });
        self.open.clear();
        self.n_expanded = 0;
        let left = |cell: usize| greediness * distance(floor, cell, goal);
        self.reach(start, start, 0.0, left(start));
        while let Some(Open { cell, .. }) = self.open.pop() {
            if self.n_expanded.is_multiple_of(EXPANSIONS_A_LOOK) && give_up() {
                return Err(NoWay::GivenUp);
            }
            let Some(here) = self.reached.get_mut(cell).filter(|here| !here.done) else { continue };
            here.done = true;
            let here = *here;
            self.n_expanded += 1;
            if cell == goal {
                return Ok((self.corners(start, goal), here.length));
            }
            for next in floor.neighbors(cell) {
                // Path 2 of the paper: straight from the parent, where it sees the neighbor; else path 1, through here.
                let from = if floor.is_clear(floor.middle(here.parent), floor.middle(next)) {
                    here.parent
                } else {
                    cell
                };
                let before = if from == cell { here.length } else { self.length(from) };
                let length = before + distance(floor, from, next);
                if length < self.length(next) {
                    self.reach(next, from, length, left(next));
                }
            }
        }
        Err(NoWay::Closed)
    }

    fn length(&self, cell: usize) -> f64 {
        self.reached.get(cell).map_or(f64::INFINITY, |reached| reached.length)
    }

    fn reach(&mut self, cell: usize, parent: usize, length: f64, left: f64) {
        if let Some(reached) = self.reached.get_mut(cell).filter(|reached| !reached.done) {
            *reached = Reached { length, parent, done: false };
            self.open.push(Open { promise: length + left, cell });
        }
    }

    fn corners(&self, start: usize, goal: usize) -> Vec<usize> {
        let mut corners = vec![goal];
        let mut cell = goal;
        while cell != start {
            cell = self.reached.get(cell).map_or(start, |reached| reached.parent);
            corners.push(cell);
        }
        corners.reverse();
        corners
    }
}

fn distance(floor: &Floor, a: usize, b: usize) -> f64 {
    let ([ax, ay], [bx, by]) = (floor.middle(a), floor.middle(b));
    (ax - bx).hypot(ay - by)
}

#[cfg(test)]
mod tests {
    use super::super::floor::tests::floor;
    use super::*;

    fn corners(floor: &Floor, start: usize, goal: usize) -> Result<Vec<usize>, NoWay> {
        ThetaStar::default().search(floor, (start, goal), 1.0, || false).map(|(corners, _)| corners)
    }

    #[test]
    fn a_free_way_is_one_straight_piece_in_any_direction() {
        let floor = floor(&".......\n".repeat(5), 0.0);
        assert_eq!(corners(&floor, 0, 34), Ok(vec![0, 34]));
        assert_eq!(corners(&floor, 20, 20), Ok(vec![20]));
    }

    #[test]
    fn a_way_turns_at_the_corners_of_obstacles_only() {
        // From the lower left to the lower right, around a wall that is open at the top.
        let floor = floor(".......\n...#...\n...#...\n...#...", 0.0);
        let found = corners(&floor, 0, 6).unwrap();
        assert_eq!(found, [0, 23, 25, 6], "both upper corners of the wall, with one cell between");
    }

    #[test]
    fn a_closed_way_and_a_lost_interest_are_told_apart() {
        let floor = floor("..#..\n..#..\n..#..", 0.0);
        assert_eq!(corners(&floor, 0, 4), Err(NoWay::Closed));
        assert_eq!(ThetaStar::default().search(&floor, (0, 4), 1.0, || true), Err(NoWay::GivenUp));
    }
}
