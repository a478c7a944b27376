//! A cloud of points, thinned: depth cameras give hundreds of thousands, and the stop zone looks at each for every step
//! of the motion ahead.

use crate::frames::Point2;

/// Cells of the plane around the robot; of all points in a cell the first one counts.
#[derive(Debug, Default)]
pub struct CloudCells {
    reach_m: f64,
    cell_m: f64,
    n_side: usize,
    /// One bit a cell.
    taken: Vec<u64>,
}

impl CloudCells {
    /// Cells have at least this edge, meters: points in one are nearer to one another than readings are exact.
    const CELL_M: f64 = 0.01;
    /// Most cells along an edge.
    const MOST: f64 = 1024.0;

    /// Nothing taken within `reach_m`. Memory is taken at the first call only.
    pub fn start(&mut self, reach_m: f64) {
        self.reach_m = reach_m;
        self.cell_m = (2.0 * reach_m / Self::MOST).max(Self::CELL_M);
        self.n_side = (2.0 * reach_m / self.cell_m).ceil() as usize + 1;
        self.taken.clear();
        self.taken.resize((self.n_side * self.n_side).div_ceil(64), 0);
    }

    /// Takes the cell of a point (base frame) within reach; tells whether it was free.
    pub fn take(&mut self, in_base: Point2) -> bool {
        let [col, row] = [in_base.x, in_base.y].map(|v| ((v + self.reach_m) / self.cell_m) as usize);
        let cell = row * self.n_side + col;
        let Some(word) = self.taken.get_mut(cell / 64).filter(|_| col < self.n_side) else { return false };
        let bit = 1 << (cell % 64);
        let is_free = *word & bit == 0;
        *word |= bit;
        is_free
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_the_points_in_a_cell_the_first_one_counts() {
        let mut cells = CloudCells::default();
        cells.start(1.5);
        let taken: Vec<bool> =
            [(0.5, 0.5), (0.502, 0.503), (0.52, 0.5), (-1.5, -1.5), (1.5, 1.5), (0.5, 0.5)]
                .into_iter()
                .map(|(x, y)| cells.take(Point2::new(x, y)))
                .collect();
        assert_eq!(taken, [true, false, true, true, true, false]);
        assert!(!cells.take(Point2::new(9.0, 0.0)) && !cells.take(Point2::new(0.0, 9.0)), "beyond");
        cells.start(1.5);
        assert!(cells.take(Point2::new(0.5, 0.5)), "a new picture");
    }

    #[test]
    fn a_long_reach_has_coarser_cells() {
        let mut cells = CloudCells::default();
        cells.start(100.0);
        assert!(cells.taken.len() < 20_000);
        assert!(cells.take(Point2::new(50.0, 0.0)) && !cells.take(Point2::new(50.1, 0.1)));
    }
}
