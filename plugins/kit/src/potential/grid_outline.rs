//! Obstacles from a grid: the sides of cells between what is free and what is not.

use super::outline::{parts, turn_rad};
use super::{Group, Piece};
use crate::GridSize;
use nalgebra::Point2;

/// A point in cells.
type Corner = [f64; 2];

/// The obstacles of a grid, in cells, exact to the sides of the cells: outlines of all that is not free, and the rim of the
/// grid, parted where they bend inwards. Free cells that touch at a corner only do not hang together.
///
/// Stairs of slanted walls are no corners: where an outline is parted is looked up on an outline that may stray from it by
/// one and a half cells.
pub fn outlines_of_grid(size: GridSize, is_free: &[bool]) -> Vec<Group> {
    assert_eq!(is_free.len(), size.n_cells(), "one answer a cell");
    let outlines = Outlines { size, is_free };
    let mut seen = vec![0_u8; size.n_cells()];
    let mut groups = Vec::new();
    for cell in 0..size.n_cells() {
        if !is_free[cell] || outlines.is_amid_free(cell) {
            continue;
        }
        for side in 0..4 {
            if seen[cell] & (1 << side) == 0 && outlines.is_wall(cell, side) {
                let corners = outlines.follow(cell, side, &mut seen);
                groups.extend(parted(&corners));
            }
        }
    }
    groups
}

/// Stairs stray less than this from the slanted wall that they stand for, in cells.
const STRAY_CELLS: f64 = 1.5;

/// Outward steps of the sides: below, right, above, left. Walked with the free cell on the left, a side leads on as the
/// next one points out.
const OUT: [(i32, i32); 4] = [(0, -1), (1, 0), (0, 1), (-1, 0)];
/// Where each side begins, from the lower left corner of its cell.
const BEGIN: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

struct Outlines<'a> {
    size: GridSize,
    is_free: &'a [bool],
}

impl Outlines<'_> {
    fn free_neighbor(&self, cell: usize, side: usize) -> Option<usize> {
        let (dx, dy) = OUT[side];
        self.size.neighbor(cell, dx, dy).filter(|next| self.is_free[*next])
    }

    /// No side is a wall, told without looking up columns and rows: most cells of a map are like this.
    fn is_amid_free(&self, cell: usize) -> bool {
        let width = self.size.width;
        let at =
            |place: Option<usize>| place.and_then(|place| self.is_free.get(place)).is_some_and(|free| *free);
        let is_free = at(cell.checked_sub(width))
            && at(cell.checked_sub(1))
            && at(Some(cell + 1))
            && at(Some(cell + width));
        is_free && (1..width.saturating_sub(1)).contains(&(cell % width))
    }

    fn is_wall(&self, cell: usize, side: usize) -> bool {
        self.free_neighbor(cell, side).is_none()
    }

    /// The corners of the outline that a side belongs to, and which way each turns.
    fn follow(&self, cell: usize, side: usize, seen: &mut [u8]) -> Vec<Corner> {
        let (mut at, mut corners) = ((cell, side), Vec::new());
        let mut came_along = None;
        while seen[at.0] & (1 << at.1) == 0 {
            seen[at.0] |= 1 << at.1;
            if came_along != Some(at.1) {
                let (col, row) = self.size.col_row(at.0);
                corners.push([col as f64 + BEGIN[at.1][0], row as f64 + BEGIN[at.1][1]]);
            }
            came_along = Some(at.1);
            at = self.next(at);
        }
        // Began in the middle of a straight piece.
        if corners.len() > 4 && came_along == Some(side) {
            corners.remove(0);
        }
        corners
    }

    fn next(&self, (cell, side): (usize, usize)) -> (usize, usize) {
        let (along, back) = ((side + 1) % 4, (side + 3) % 4);
        match self.free_neighbor(cell, along) {
            None => (cell, along),
            Some(ahead) => match self.free_neighbor(ahead, side) {
                None => (ahead, side),
                Some(beyond) => (beyond, back),
            },
        }
    }
}

/// The sides between corners, grouped.
fn parted(corners: &[Corner]) -> Vec<Group> {
    let n = corners.len();
    let kept = coarse(corners);
    let leg = |a: usize, b: usize| {
        let (a, b) = (corners[a % n], corners[b % n]);
        [b[0] - a[0], b[1] - a[1]]
    };
    let m = kept.len();
    let turns: Vec<f64> = (0..m)
        .map(|k| {
            let (before, here, after) = (kept[(k + m - 1) % m], kept[k], kept[(k + 1) % m]);
            let turn = turn_rad(leg(before, here), leg(here, after));
            // A turn back has its sign from the corners that were left out.
            let is_back = turn.abs() > 3.0;
            if is_back { turn.abs() * net_turn(corners, here).signum() } else { turn }
        })
        .collect();
    let piece = |i: usize| Piece::between(Point2::from(corners[i % n]), Point2::from(corners[(i + 1) % n]));
    let group = |sides: std::ops::Range<usize>| {
        let begin = kept[sides.start % m] + n * (sides.start / m);
        let end = kept[sides.end % m] + n * (sides.end / m);
        (begin..end).map(piece).collect()
    };
    parts(&turns).into_iter().map(group).collect()
}

/// Turn at a corner and those beside it, radians.
fn net_turn(corners: &[Corner], at: usize) -> f64 {
    let n = corners.len();
    let leg = |i: usize| {
        let (a, b) = (corners[i % n], corners[(i + 1) % n]);
        [b[0] - a[0], b[1] - a[1]]
    };
    (at + n - 1..=at + n + 1).map(|i| turn_rad(leg(i + n - 1), leg(i))).sum()
}

/// Which corners a closed outline keeps that strays by no more than [`STRAY_CELLS`] (Ramer 1972; Douglas and Peucker 1973).
fn coarse(corners: &[Corner]) -> Vec<usize> {
    let n = corners.len();
    let square = |a: Corner, b: Corner| (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2);
    let farthest_from = |from: usize| {
        (0..n).max_by(|a, b| {
            let of = |i: &usize| square(corners[*i], corners[from]);
            of(a).total_cmp(&of(b)).then(b.cmp(a))
        })
    };
    // Both ends of a first chord lie where the outline surely turns: far from what is far.
    let Some((a, b)) = farthest_from(0).and_then(|a| Some((a, farthest_from(a)?))) else { return Vec::new() };
    let (a, b) = (a.min(b), a.max(b));
    let mut keep = vec![false; n];
    keep[a] = true;
    keep[b] = true;
    let mut open = vec![(a, b), (b, a + n)];
    while let Some((from, to)) = open.pop() {
        let (p, q) = (corners[from % n], corners[to % n]);
        let stray = |i: usize| distance_to_chord(corners[i % n], p, q);
        let Some(worst) = (from + 1..to).max_by(|i, j| stray(*i).total_cmp(&stray(*j)).then(j.cmp(i))) else {
            continue;
        };
        if stray(worst) > STRAY_CELLS {
            keep[worst % n] = true;
            open.extend([(from, worst), (worst, to)]);
        }
    }
    (0..n).filter(|i| keep[*i]).collect()
}

fn distance_to_chord(at: Corner, a: Corner, b: Corner) -> f64 {
    let (along, to_point) = ([b[0] - a[0], b[1] - a[1]], [at[0] - a[0], at[1] - a[1]]);
    let square = along[0].powi(2) + along[1].powi(2);
    let t = if square > 0.0 {
        ((to_point[0] * along[0] + to_point[1] * along[1]) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    (to_point[0] - t * along[0]).hypot(to_point[1] - t * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance_field::squared_distance_field;
    use crate::potential::Obstacles;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn drawn(picture: &str, letter_cells: usize) -> (GridSize, Vec<bool>) {
        let rows: Vec<&str> = picture.lines().map(str::trim).filter(|line| !line.is_empty()).rev().collect();
        let size = GridSize::new(rows[0].len() * letter_cells, rows.len() * letter_cells);
        let is_free = (0..size.n_cells())
            .map(|cell| {
                let (col, row) = size.col_row(cell);
                rows[row / letter_cells].as_bytes()[col / letter_cells] != b'#'
            })
            .collect();
        (size, is_free)
    }

    fn sizes(groups: &[Group]) -> Vec<usize> {
        let mut sizes: Vec<usize> = groups.iter().map(Vec::len).collect();
        sizes.sort_unstable();
        sizes
    }

    #[test]
    fn a_rack_in_a_hall_is_one_obstacle_among_four_walls() {
        for letter_cells in [2, 5] {
            let (size, is_free) = drawn("..........\n....##....\n..........", letter_cells);
            assert_eq!(sizes(&outlines_of_grid(size, &is_free)), [1, 1, 1, 1, 4], "{letter_cells}");
        }
    }

    #[test]
    fn a_wall_with_a_door_is_two_jambs() {
        let (size, is_free) = drawn("...#...\n...#...\n.......\n.......\n...#...", 4);
        let groups = outlines_of_grid(size, &is_free);
        // Walls: left and right one each, above and below parted by the jambs, which have three sides.
        assert_eq!(sizes(&groups), [1, 1, 1, 1, 1, 1, 3, 3]);
    }

    #[test]
    fn a_slanted_wall_is_one_obstacle_in_spite_of_its_stairs() {
        for slope in [0.05, 0.2, 0.5, 1.0] {
            let size = GridSize::new(120, 150);
            let above = |cell: usize| {
                let (col, row) = size.col_row(cell);
                row as f64 + 0.5 > 10.0 + slope * (col as f64 + 0.5)
            };
            let is_free: Vec<bool> = (0..size.n_cells()).map(above).collect();
            let groups = outlines_of_grid(size, &is_free);
            assert_eq!(groups.len(), 4, "slope {slope}: {:?}", sizes(&groups));
        }
    }

    #[test]
    fn distances_are_those_to_the_sides_of_the_cells_on_random_grids() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for _ in 0..60 {
            let size = GridSize::new(rng.random_range(1..30), rng.random_range(1..30));
            let is_free: Vec<bool> = (0..size.n_cells()).map(|_| rng.random_bool(0.8)).collect();
            let groups = outlines_of_grid(size, &is_free);
            let n_sides: usize = groups.iter().map(Vec::len).sum();
            let obstacles = Obstacles::new(&groups, 100.0).unwrap();
            for _ in 0..40 {
                let at =
                    [rng.random_range(0.0..size.width as f64), rng.random_range(0.0..size.height as f64)];
                if !is_free[size.index(at[0] as usize, at[1] as usize)] {
                    continue;
                }
                let mut nearest =
                    at[0].min(at[1]).min(size.width as f64 - at[0]).min(size.height as f64 - at[1]);
                for cell in (0..size.n_cells()).filter(|cell| !is_free[*cell]) {
                    let (col, row) = size.col_row(cell);
                    let beside = |v: f64, low: usize| (low as f64 - v).max(v - low as f64 - 1.0).max(0.0);
                    nearest = nearest.min(beside(at[0], col).hypot(beside(at[1], row)));
                }
                let found = obstacles.clearance_m(Point2::from(at));
                assert!((found - nearest).abs() < 1e-9, "{found} {nearest} of {n_sides} sides");
            }
        }
    }

    #[test]
    fn distances_agree_with_the_distance_field_of_a_large_grid() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
        let size = GridSize::new(300, 200);
        let mut is_free = vec![true; size.n_cells()];
        for _ in 0..12 {
            let (col, row) = (rng.random_range(0..280), rng.random_range(0..180));
            (row..row + 15).for_each(|r| is_free[size.index(col, r)..][..8].fill(false));
        }
        let marked: Vec<u8> = is_free.iter().map(|free| u8::from(!free)).collect();
        let field = squared_distance_field(size, &marked);
        let obstacles = Obstacles::new(&outlines_of_grid(size, &is_free), 20.0).unwrap();
        for _ in 0..2000 {
            let (col, row) = (rng.random_range(30..270), rng.random_range(30..170));
            let centers = f64::from(field[size.index(col, row)]).sqrt();
            let found = obstacles.clearance_m(Point2::new(col as f64 + 0.5, row as f64 + 0.5));
            if centers > 0.0 && centers < 20.0 {
                // From center to center is half a side to half a diagonal more than to the side of the cell.
                assert!((0.5 - 1e-9..=0.7072).contains(&(centers - found)), "{centers} {found}");
            }
        }
    }

    #[test]
    fn grids_without_free_cells_or_without_cells_have_no_obstacles() {
        assert!(outlines_of_grid(GridSize::new(3, 2), &[false; 6]).is_empty());
        assert!(outlines_of_grid(GridSize::new(0, 0), &[]).is_empty());
        assert_eq!(sizes(&outlines_of_grid(GridSize::new(1, 1), &[true])).iter().sum::<usize>(), 4);
    }
}
