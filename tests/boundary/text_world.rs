//! Maps drawn in the test source.

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::{Cell, Grid, Map};
use rumbo_core::messages::Goal;

/// A drawn map: `#` occupied, `?` unknown, `S` start, `G` goal, anything else free.
pub struct TextWorld {
    pub map: Map,
    pub start: Pose2,
    pub goal: Goal,
}

pub fn text_world(resolution_m: f64, picture: &str) -> TextWorld {
    let rows: Vec<&str> = picture.lines().map(str::trim).filter(|line| !line.is_empty()).rev().collect();
    let (width, height) = (rows[0].len() as u32, rows.len() as u32);
    let mut grid = Grid::unknown(width, height, resolution_m).unwrap();
    let (mut start, mut goal) = (None, None);
    for (row, line) in rows.iter().enumerate() {
        assert_eq!(line.len() as u32, width, "row {row} of the picture");
        for (col, letter) in line.bytes().enumerate() {
            let cell = Cell { col: col as u32, row: row as u32 };
            let index = grid.index_of(cell);
            grid.cells.make_mut()[index] = match letter {
                b'#' => Grid::CERTAIN,
                b'?' => 0.0,
                _ => -Grid::CERTAIN,
            };
            match letter {
                b'S' => start = Some(grid.center_of(cell)),
                b'G' => goal = Some(grid.center_of(cell)),
                _ => {}
            }
        }
    }
    let start = start.expect("a start in the picture");
    TextWorld {
        map: Map { grid: Some(grid), version: 1, ..Map::default() },
        start: pose2(start.x, start.y, 0.0),
        goal: Goal { position: goal.unwrap_or(start), yaw_rad: None },
    }
}
