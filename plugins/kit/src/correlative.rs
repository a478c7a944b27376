//! Where in a map does this scan fit best? Correlative matching, answered exactly by branch and bound.
//!
//! Every pose of a window, cell by cell and turn by turn, is scored by how well the scan's points lie on the map (Olson,
//! "Real-time correlative scan matching", 2009). The best one is found without looking at all of them: the best value
//! inside a square of cells bounds the scores of all the poses that put a point into that square (Hess, Kohler, Rapp,
//! Andor, "Real-time loop closure in 2D LIDAR SLAM", 2016). Differs from both: the most promising node of all is opened
//! first, not that of the deepest level, so the first whole pose that comes up is the answer.
//!
//! Poses are those of the base in the grid's own frame: origin at the lower left corner of the grid, meters.

mod fit_table;
mod search;
mod window;

pub use fit_table::{FitTable, MOST_LEVELS};
pub use search::{CorrelativeMatch, CorrelativeSearch, SearchGaveUp};
pub use window::{Apart, SearchWindow, turn_step_rad};

#[cfg(test)]
mod tests;
