//! Start and goal in the connected free space of a world.

use super::fingerprint::Fingerprint;
use super::range::unit;
use rand_xoshiro::rand_core::Rng as _;
use rumbo_core::rng::{Rng, stream};
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, MapImage, load_map};
use rumbo_kit::world_file::{WorldScene, draw_mapped, raster_map};
use rumbo_kit::{GridSize, NEIGHBORS_8};

/// Cells of worlds without a picture behind them, meters.
const CELL_M: f64 = 0.05;
/// Start and goal are at least this share of the free space's diagonal apart.
const LEAST_SHARE: f64 = 0.25;

/// Middles of the cells of the largest connected free space, meters.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeSpace {
    middles: Vec<[f64; 2]>,
    least_way_m: f64,
}

/// Where a mission begins and ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ends {
    /// Start, meters.
    pub start: [f64; 2],
    /// Which way the robot looks there, degrees.
    pub yaw_deg: f64,
    /// Goal, meters.
    pub goal: [f64; 2],
}

impl FreeSpace {
    /// Places of the world that are `clearance_m` from everything, also from what its map does not show.
    pub fn of(scene: &WorldScene, clearance_m: f64) -> Result<FreeSpace, String> {
        let mut scene = scene.clone();
        scene.walls.iter_mut().for_each(|wall| wall.mapped = true);
        scene.boxes.iter_mut().for_each(|solid| solid.mapped = true);
        let image = match &scene.map {
            Some(map) => {
                let mut image = load_map(map, DEFAULT_MAX_CELLS).map_err(|error| error.to_string())?;
                draw_mapped(&scene, &mut image);
                image
            }
            None => raster_map(&scene, CELL_M, DEFAULT_MAX_CELLS)
                .ok_or("the world is too large to draw a mission in it")?,
        };
        FreeSpace::of_image(&image, clearance_m)
    }

    fn of_image(image: &MapImage, clearance_m: f64) -> Result<FreeSpace, String> {
        let size = GridSize::new(image.width, image.height);
        let marked: Vec<u8> =
            image.cells.iter().map(|percent| u8::from(!(0..=50).contains(percent))).collect();
        // From middle to middle; a wall begins half a cell before the middle of its own.
        let keep = (clearance_m / image.resolution_m + 0.5).powi(2);
        let open: Vec<bool> =
            squared_distance_field(size, &marked).iter().map(|d| f64::from(*d) >= keep).collect();
        let middle = |cell: usize| {
            let (col, row) = size.col_row(cell);
            let along = |count: usize| (count as f64 + 0.5) * image.resolution_m;
            let (left_m, bottom_m, yaw_rad) = (image.origin[0], image.origin[1], image.origin[2]);
            let (sin, cos) = yaw_rad.sin_cos();
            [left_m + cos * along(col) - sin * along(row), bottom_m + sin * along(col) + cos * along(row)]
        };
        let middles: Vec<[f64; 2]> = largest_room(size, &open).into_iter().map(middle).collect();
        if middles.len() < 2 {
            return Err(format!("has no free space that is {clearance_m} m from everything"));
        }
        let span = |axis: usize| {
            let values = || middles.iter().filter_map(|middle| middle.get(axis).copied());
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        let least_way_m = LEAST_SHARE * span(0).hypot(span(1));
        Ok(FreeSpace { middles, least_way_m })
    }

    /// The mission `number` of a seed. A goal too near to the start is drawn again; where the start leaves no other
    /// place, a few draws later the farthest of them is taken.
    pub fn draw(&self, seed: u64, number: u32) -> Ends {
        const MOST_DRAWS: usize = 100;
        let mut rng = stream(seed, &format!("compare.mission.{number}"));
        let start = self.place(&mut rng);
        let yaw_deg = (unit(&mut rng) * 360.0 - 180.0).round();
        let far = |goal: &[f64; 2]| (goal[0] - start[0]).hypot(goal[1] - start[1]);
        let mut goal = start;
        for _ in 0..MOST_DRAWS {
            let drawn = self.place(&mut rng);
            if far(&drawn) > far(&goal) {
                goal = drawn;
            }
            if far(&drawn) >= self.least_way_m {
                goal = drawn;
                break;
            }
        }
        Ends { start, yaw_deg, goal }
    }

    /// Tells what it is made of.
    pub fn note(&self, print: &mut Fingerprint) {
        self.middles.iter().for_each(|middle| print.numbers(middle));
    }

    fn place(&self, rng: &mut Rng) -> [f64; 2] {
        let n = self.middles.len() as u128;
        let idx = ((u128::from(rng.next_u64()) * n) >> 64) as usize;
        self.middles.get(idx).copied().unwrap_or_default()
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall in the middle parts a large room of 6 m from a small one of 3 m.
    fn two_rooms() -> MapImage {
        let (width, height) = (100, 40);
        let cells = (0..width * height).map(|cell| if cell % width == 65 { 100 } else { 0 }).collect();
        MapImage { width, height, resolution_m: 0.1, origin: [-1.0, 2.0, 0.0], cells }
    }

    #[test]
    fn ends_lie_apart_in_the_larger_room_with_clearance() {
        let space = FreeSpace::of_image(&two_rooms(), 0.5).unwrap();
        for seed in 0..50 {
            let ends = space.draw(seed, 0);
            for [x, y] in [ends.start, ends.goal] {
                assert!(x < -1.0 + 6.5 - 0.5 && y > 2.0, "({x}, {y})");
            }
            let way = (ends.goal[0] - ends.start[0]).hypot(ends.goal[1] - ends.start[1]);
            assert!(way >= space.least_way_m, "{way}");
            assert_eq!(ends, space.draw(seed, 0));
            assert_ne!(ends, space.draw(seed, 1));
        }
    }

    #[test]
    fn a_world_without_room_is_refused() {
        let cells = vec![100; 100];
        let image = MapImage { width: 10, height: 10, resolution_m: 0.1, origin: [0.0; 3], cells };
        assert!(FreeSpace::of_image(&image, 0.5).unwrap_err().contains("no free space"));
    }
}
