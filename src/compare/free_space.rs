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
/// The robot stands with this distance between hull and walls at its start and its goal, meters: room to turn and stop.
const STAND_M: f64 = 0.3;
/// A passage counts as one when it leaves this distance on both sides of the hull, meters.
const PASS_M: f64 = 0.1;
/// Start and goal are at least this share of the free space's diagonal apart.
const LEAST_SHARE: f64 = 0.25;

/// Middles of the cells where a robot may start and end: those with room to stand in the largest part of the free space
/// that is connected by passages, meters.
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
    /// Places for a robot with this radius, free also of what the world's map does not show.
    pub fn of(scene: &WorldScene, radius_m: f64) -> Result<FreeSpace, String> {
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
        FreeSpace::of_image(&image, radius_m)
    }

    fn of_image(image: &MapImage, radius_m: f64) -> Result<FreeSpace, String> {
        let size = GridSize::new(image.width, image.height);
        let marked: Vec<u8> =
            image.cells.iter().map(|percent| u8::from(!(0..=50).contains(percent))).collect();
        let field = squared_distance_field(size, &marked);
        // From middle to middle; a wall begins half a cell before the middle of its own.
        let squared = |clearance_m: f64| ((radius_m + clearance_m) / image.resolution_m + 0.5).powi(2);
        let (pass, stand) = (squared(PASS_M), squared(STAND_M));
        let open: Vec<bool> = field.iter().map(|d| f64::from(*d) >= pass).collect();
        let may_stand = |cell: &usize| field.get(*cell).is_some_and(|d| f64::from(*d) >= stand);
        let middle = |cell: usize| {
            let (col, row) = size.col_row(cell);
            let along = |count: usize| (count as f64 + 0.5) * image.resolution_m;
            let (left_m, bottom_m, yaw_rad) = (image.origin[0], image.origin[1], image.origin[2]);
            let (sin, cos) = yaw_rad.sin_cos();
            [left_m + cos * along(col) - sin * along(row), bottom_m + sin * along(col) + cos * along(row)]
        };
        let middles: Vec<[f64; 2]> =
            largest_room(size, &open).into_iter().filter(may_stand).map(middle).collect();
        if middles.len() < 2 {
            return Err(format!("has no free space for a robot of {radius_m} m radius to start and end in"));
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

    /// Two rooms of 4 m beside each other, with a door of so many cells of 0.1 m between them.
    fn two_rooms(n_door_cells: usize) -> MapImage {
        let (width, height) = (81, 40);
        let is_wall = |col: usize, row: usize| col == 40 && row >= n_door_cells;
        let cell = |idx: usize| if is_wall(idx % width, idx / width) { 100 } else { 0 };
        let cells = (0..width * height).map(cell).collect();
        MapImage { width, height, resolution_m: 0.1, origin: [-1.0, 2.0, 0.0], cells }
    }

    #[test]
    fn ends_have_room_to_stand_and_are_joined_by_passages() {
        let narrow = FreeSpace::of_image(&two_rooms(0), 0.2).unwrap();
        let joined = FreeSpace::of_image(&two_rooms(4), 0.2).unwrap();
        let sides = |space: &FreeSpace| {
            let is_left = |middle: &[f64; 2]| middle[0] < 3.05;
            (space.middles.iter().any(is_left), space.middles.iter().any(|middle| !is_left(middle)))
        };
        assert_eq!((sides(&narrow), sides(&joined)), ((true, false), (true, true)));
        // The wall stands from x = 3.0 m to 3.1 m; the hull of 0.2 m keeps 0.3 m from it.
        assert!(narrow.middles.iter().all(|middle| middle[0] <= 2.5));
    }

    #[test]
    fn a_mission_is_that_of_its_seed_and_number_and_not_too_short() {
        let space = FreeSpace::of_image(&two_rooms(4), 0.2).unwrap();
        for seed in 0..50 {
            let ends = space.draw(seed, 0);
            let way_m = (ends.goal[0] - ends.start[0]).hypot(ends.goal[1] - ends.start[1]);
            assert!(way_m >= space.least_way_m && way_m > 2.0, "{way_m}");
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
