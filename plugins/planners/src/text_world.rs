//! Maps drawn in the test source.

use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::{Cell, Grid, Map};
use rumbo_core::messages::Goal;
use rumbo_core::robot::Robot;
use rumbo_core::stages::{GiveUp, PlanRequest};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use std::sync::Arc;

/// A request on a drawn map: `#` occupied, `?` unknown, `S` start (looking along +x), `G` goal, anything else free.
pub fn request(resolution_m: f64, picture: &str) -> PlanRequest {
    let rows: Vec<&str> = picture.lines().map(str::trim).filter(|line| !line.is_empty()).rev().collect();
    let mut grid = Grid::unknown(rows[0].len() as u32, rows.len() as u32, resolution_m).unwrap();
    let (mut start, mut goal) = (None, None);
    for (row, line) in rows.iter().enumerate() {
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
    PlanRequest {
        stamp: Time::ZERO,
        map: Map::default(),
        grid: Some(grid),
        start: looking(start.x, start.y, 0.0),
        goal: Goal { position: goal.unwrap_or(start), yaw_rad: None },
        robot: Arc::new(Robot::default()),
        obstacles: Vec::new(),
        give_up: GiveUp::default(),
        trace: Trace::unwatched(),
    }
}

/// A pose, heading in degrees.
pub fn looking(x: f64, y: f64, heading_deg: f64) -> Pose2 {
    pose2(x, y, heading_deg.to_radians())
}
