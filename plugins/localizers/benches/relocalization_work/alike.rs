//! Rooms that look the same.

use super::Office;
use rand::RngExt;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::rng::Rng;
use rumbo_kit::GridSize;
use std::f64::consts::PI;

/// Width and depth of a room, and width of the corridor, cells.
const ROOM: [usize; 2] = [80, 100];
const CORRIDOR: usize = 36;
/// Walls, cells.
const WALL: usize = 2;
/// The corridor is this much longer than the rooms on the left and on the right, cells.
const ENDS: [usize; 2] = [20, 50];
/// Door of a room: where it begins and ends, cells from the left of the room.
const DOOR: [usize; 2] = [12, 34];
/// What stands in each room: left, lower, width, height, cells.
const FURNITURE: [[usize; 4]; 3] = [[0, 80, 30, 8], [50, 50, 20, 14], [20, 42, 8, 8]];

impl Office {
    /// So many rooms of 4 m by 5 m with the same furniture, side by side above a corridor whose ends differ: one is 2.5 m from
    /// the first door, with a cupboard in the corner, the other 5.9 m from the last, with a pillar before it. Closed rooms
    /// have no doors.
    pub fn alike(n_rooms: usize, is_closed: bool) -> Office {
        let width = ENDS[0] + n_rooms * (ROOM[0] + WALL) + ENDS[1] + 2 * WALL;
        let size = GridSize::new(width, ROOM[1] + CORRIDOR + 3 * WALL);
        let mut occupied = vec![1_u8; size.n_cells()];
        let mut fill = |[left, lower, width, height]: [usize; 4], value: u8| {
            for row in lower..lower + height {
                occupied[size.index(left, row)..][..width].fill(value);
            }
        };
        fill([WALL, WALL, width - 2 * WALL, CORRIDOR], 0);
        fill([WALL, WALL, 10, 14], 1);
        fill([width - 30, 12, 6, 6], 1);
        let lower = CORRIDOR + 2 * WALL;
        for room in 0..n_rooms {
            let left = first_left(room);
            fill([left, lower, ROOM[0], ROOM[1]], 0);
            for [x, y, wide, high] in FURNITURE {
                fill([left + x, lower + y, wide, high], 1);
            }
            if !is_closed {
                fill([left + DOOR[0], lower - WALL, DOOR[1] - DOOR[0], WALL], 0);
            }
        }
        Office::of(size, occupied, &[])
    }

    /// Somewhere in one of the rooms of [`Office::alike`].
    pub fn pose_in_a_room(&self, n_rooms: usize, rng: &mut Rng) -> Pose2 {
        let lower = (CORRIDOR + 2 * WALL) as f64;
        loop {
            let left = first_left(rng.random_range(0..n_rooms)) as f64;
            let x = left + rng.random_range(0.0..ROOM[0] as f64);
            let y = lower + rng.random_range(0.0..ROOM[1] as f64);
            if self.is_open(x, y, 0.30 / super::CELL_M) {
                return pose2(x * super::CELL_M, y * super::CELL_M, rng.random_range(-PI..PI));
            }
        }
    }
}

/// Edge of a room of [`Office::alike`] to the next, meters.
pub const ROOM_TO_ROOM_M: f64 = (ROOM[0] + WALL) as f64 * super::CELL_M;

/// Left edge of the first, meters.
pub const FIRST_ROOM_M: f64 = (WALL + ENDS[0]) as f64 * super::CELL_M;

fn first_left(room: usize) -> usize {
    WALL + ENDS[0] + room * (ROOM[0] + WALL)
}
