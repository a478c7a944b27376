//! The floor that the robot's middle may cross: free cells that are far enough from every obstacle.

/// Which cells are open, and what can be seen from where. Coordinates are in cells: cell (2, 3) has its middle at
/// (2.5, 3.5).
#[derive(Debug, Default)]
pub struct Floor {
    width: usize,
    height: usize,
    open: Vec<bool>,
}

/// What a cell is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// The robot may be here.
    Free,
    /// The robot keeps its clearance from here.
    Obstacle,
    /// Nobody knows: closed, but nothing to keep away from.
    Unknown,
}

impl Floor {
    /// Lays the floor anew: `clearance` is in cells. The cell `start` and the free ones near it are open in any case, so
    /// that a robot that stands too close to something can leave.
    pub fn lay(&mut self, width: usize, kinds: &[Kind], clearance: f64, start: usize) {
        self.width = width.max(1);
        self.height = kinds.len() / self.width;
        self.open.clear();
        self.open.extend(kinds.iter().map(|kind| *kind == Kind::Free));
        for cell in 0..kinds.len() {
            if self.is_edge(kinds, cell) {
                self.each_within(cell, clearance + 0.5, |open, _| *open = false);
            }
        }
        self.each_within(start, clearance, |open, cell| {
            *open |= kinds.get(cell) == Some(&Kind::Free);
        });
    }

    /// The robot may be in this cell.
    pub fn is_open(&self, cell: usize) -> bool {
        self.open.get(cell).copied().unwrap_or(false)
    }

    /// How many cells there are.
    pub fn len(&self) -> usize {
        self.open.len()
    }

    /// Column and row of a cell.
    pub fn col_row(&self, cell: usize) -> (usize, usize) {
        (cell % self.width, cell / self.width)
    }

    /// Middle of a cell.
    pub fn middle(&self, cell: usize) -> [f64; 2] {
        let (col, row) = self.col_row(cell);
        [col as f64 + 0.5, row as f64 + 0.5]
    }

    /// The open ones of the eight neighbors; a diagonal step does not squeeze between two closed cells.
    pub fn neighbors(&self, cell: usize) -> impl Iterator<Item = usize> + '_ {
        const STEPS: [(isize, isize); 8] =
            [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (-1, 1), (1, -1), (-1, -1)];
        STEPS.into_iter().filter_map(move |(dx, dy)| {
            let there = self.beside(cell, dx, dy)?;
            let sides_open = [self.beside(cell, dx, 0)?, self.beside(cell, 0, dy)?];
            let fits = self.is_open(there) && sides_open.into_iter().all(|side| self.is_open(side));
            fits.then_some(there)
        })
    }

    /// Every cell that the straight line touches is open (Amanatides and Woo, *A Fast Voxel Traversal Algorithm*, 1987).
    pub fn is_clear(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let mut cell = [from[0].floor(), from[1].floor()];
        let last = [to[0].floor(), to[1].floor()];
        let way = [to[0] - from[0], to[1] - from[1]];
        let step = way.map(f64::signum);
        // Share of the way at which the next border is crossed, on both axes.
        let border = |axis: usize, cell: f64| {
            let at = if step[axis] > 0.0 { cell + 1.0 } else { cell };
            if way[axis] == 0.0 { f64::INFINITY } else { (at - from[axis]) / way[axis] }
        };
        let n_crossed = (last[0] - cell[0]).abs() + (last[1] - cell[1]).abs();
        for _ in 0..=n_crossed as usize {
            if !self.is_open_at(cell) {
                return false;
            }
            if cell == last {
                return true;
            }
            let [x, y] = [border(0, cell[0]), border(1, cell[1])];
            if (x - y).abs() < 1e-12 {
                // Through a corner: both cells beside it are touched.
                let beside = [[cell[0] + step[0], cell[1]], [cell[0], cell[1] + step[1]]];
                if !beside.into_iter().all(|cell| self.is_open_at(cell)) {
                    return false;
                }
                cell = [cell[0] + step[0], cell[1] + step[1]];
            } else if x < y {
                cell[0] += step[0];
            } else {
                cell[1] += step[1];
            }
        }
        cell == last && self.is_open_at(cell)
    }

    fn is_open_at(&self, [col, row]: [f64; 2]) -> bool {
        let inside = col >= 0.0 && row >= 0.0 && col < self.width as f64 && row < self.height as f64;
        inside && self.is_open(row as usize * self.width + col as usize)
    }

    fn beside(&self, cell: usize, dx: isize, dy: isize) -> Option<usize> {
        let (col, row) = self.col_row(cell);
        let (col, row) = (col.checked_add_signed(dx)?, row.checked_add_signed(dy)?);
        (col < self.width && row < self.height).then_some(row * self.width + col)
    }

    /// An obstacle that does not only touch obstacles: the others close nothing that these leave open.
    fn is_edge(&self, kinds: &[Kind], cell: usize) -> bool {
        let is_obstacle = |cell: usize| kinds.get(cell) == Some(&Kind::Obstacle);
        let around = [(1, 0), (-1, 0), (0, 1), (0, -1)];
        is_obstacle(cell)
            && around.into_iter().any(|(dx, dy)| self.beside(cell, dx, dy).is_some_and(|c| !is_obstacle(c)))
    }

    /// Calls `change` for every cell whose middle is nearer than `reach` to that of `cell`.
    fn each_within(&mut self, cell: usize, reach: f64, change: impl Fn(&mut bool, usize)) {
        let (col, row) = self.col_row(cell);
        let most = reach.ceil() as usize;
        for y in row.saturating_sub(most)..=(row + most).min(self.height.saturating_sub(1)) {
            for x in col.saturating_sub(most)..=(col + most).min(self.width - 1) {
                let (dx, dy) = (x.abs_diff(col) as f64, y.abs_diff(row) as f64);
                let there = y * self.width + x;
                if dx.hypot(dy) < reach
                    && let Some(open) = self.open.get_mut(there)
                {
                    change(open, there);
                }
            }
        }
    }
}

#[cfg(test)]
pub mod tests {
    use super::*;

    /// A floor from a picture, the top row first, with its width: `#` obstacle, `?` unknown.
    pub fn floor(picture: &str, clearance: f64) -> Floor {
        let rows: Vec<&str> = picture.split_whitespace().rev().collect();
        let kind = |c: char| match c {
            '#' => Kind::Obstacle,
            '?' => Kind::Unknown,
            _ => Kind::Free,
        };
        let kinds: Vec<Kind> = rows.iter().flat_map(|row| row.chars().map(kind)).collect();
        let mut floor = Floor::default();
        floor.lay(rows[0].len(), &kinds, clearance, usize::MAX / 2);
        floor
    }

    #[test]
    fn clearance_closes_the_cells_around_obstacles_and_not_around_the_unknown() {
        let found = floor(".....\n..#..\n.....\n....?", 0.5);
        let open: Vec<bool> = (0..20).map(|cell| found.is_open(cell)).collect();
        let closed = [4, 12];
        assert!((0..20).all(|cell| open[cell] != closed.contains(&cell)), "{open:?}");
        assert!(!floor(".....\n..#..\n.....", 1.0).is_open(1), "the diagonal is 1.4 cells away");
    }

    #[test]
    fn a_line_of_sight_ends_at_every_cell_that_it_touches() {
        let floor = floor("....\n.#..\n....", 0.0);
        assert!(floor.is_clear([0.5, 0.5], [3.5, 0.5]) && floor.is_clear([3.5, 2.5], [0.5, 2.5]));
        assert!(!floor.is_clear([0.5, 1.5], [3.5, 1.5]) && !floor.is_clear([3.5, 1.6], [0.5, 1.4]));
        // Exactly through the corner of the obstacle.
        assert!(!floor.is_clear([0.5, 1.5], [1.5, 0.5]));
        assert!(!floor.is_clear([0.5, 0.5], [0.5, 7.0]), "beside the floor");
    }
}
