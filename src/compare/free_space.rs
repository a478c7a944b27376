//! Start and goal in the connected free space of a world.

use super::fingerprint::Fingerprint;
use super::ground::{Ground, Passing};
use super::range::unit;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::rng::{Rng, stream};
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, MapImage, load_map};
use rumbo_kit::world_file::{SolidBox, WorldScene, draw_mapped, raster_map};

/// Cells of worlds without a picture behind them, meters.
const CELL_M: f64 = 0.05;
/// Start and goal are at least this share of the free space's diagonal apart.
const LEAST_SHARE: f64 = 0.25;
/// Boxes that take more than this share of the places part the room.
const LOST_SHARE: f64 = 0.15;

/// Where a robot may start and end: places with room to stand in the largest part of the free space that is connected by
/// passages.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeSpace {
    scene: WorldScene,
    image: MapImage,
    radius_m: f64,
    ground: Ground,
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
        let mut all = scene.clone();
        all.walls.iter_mut().for_each(|wall| wall.mapped = true);
        all.boxes.iter_mut().for_each(|solid| solid.mapped = true);
        let mut image = match &all.map {
            Some(map) => {
                let mut image = load_map(map, DEFAULT_MAX_CELLS).map_err(|error| error.to_string())?;
                draw_mapped(&all, &mut image);
                image
            }
            None => raster_map(&all, CELL_M, DEFAULT_MAX_CELLS)
                .ok_or("the world is too large to draw a mission in it")?,
        };
        if let Some(map) = &all.robot_map {
            let known = load_map(map, DEFAULT_MAX_CELLS).map_err(|error| error.to_string())?;
            close_unknown(&mut image, &known);
        }
        FreeSpace::of_image(image, radius_m, scene.clone())
    }

    fn of_image(image: MapImage, radius_m: f64, scene: WorldScene) -> Result<FreeSpace, String> {
        let ground = Ground::of(&image, radius_m, Passing::WithRoom);
        if ground.middles.len() < 2 {
            return Err(format!("has no free space for a robot of {radius_m} m radius to start and end in"));
        }
        let span = |axis: usize| {
            let values = || ground.middles.iter().filter_map(|middle| middle.get(axis).copied());
            values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
        };
        let least_way_m = LEAST_SHARE * span(0).hypot(span(1));
        Ok(FreeSpace { scene, image, radius_m, ground, least_way_m })
    }

    /// The world.
    pub fn scene(&self) -> &WorldScene {
        &self.scene
    }

    /// Start and goal are at least so far from each other where nothing else is asked, meters.
    pub fn least_way_m(&self) -> f64 {
        self.least_way_m
    }

    /// A place to stand.
    pub fn place(&self, rng: &mut Rng) -> [f64; 2] {
        self.ground.place(rng)
    }

    /// The ground with more boxes on it.
    pub fn with(&self, boxes: &[SolidBox]) -> Ground {
        match boxes {
            [] => self.ground.clone(),
            _ => self.ground_for(Passing::WithRoom, boxes),
        }
    }

    /// The ground with more boxes on it, for a robot that passes them like this.
    pub fn ground_for(&self, passing: Passing, boxes: &[SolidBox]) -> Ground {
        Ground::of(&self.image_with(boxes), self.radius_m, passing)
    }

    /// Whether these boxes leave almost all places joined.
    pub fn stays_joined(&self, boxes: &[SolidBox]) -> bool {
        let n_lost = self.ground.middles.len().saturating_sub(self.with(boxes).middles.len());
        (n_lost as f64) < LOST_SHARE * self.ground.middles.len() as f64
    }

    fn image_with(&self, boxes: &[SolidBox]) -> MapImage {
        let mut image = self.image.clone();
        let boxes = boxes.iter().map(|solid| SolidBox { mapped: true, ..solid.clone() }).collect();
        draw_mapped(&WorldScene { boxes, ..WorldScene::default() }, &mut image);
        image
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
        self.ground.middles.iter().for_each(|middle| print.numbers(middle));
    }
}

/// Where the robot's own map shows no free floor, no mission begins or ends.
fn close_unknown(image: &mut MapImage, known: &MapImage) {
    let cell_from_cell = map_from_cells(known).inverse() * map_from_cells(image);
    let (width, steps) = (image.width, [known.resolution_m, image.resolution_m]);
    for (idx, cell) in image.cells.iter_mut().enumerate() {
        let middle = [idx % width, idx / width].map(|n| (n as f64 + 0.5) * steps[1]);
        let [col, row] =
            <[f64; 2]>::from((cell_from_cell * Point2::from(middle)).coords).map(|m| (m / steps[0]).floor());
        let is_inside = (0.0..known.width as f64).contains(&col) && (0.0..known.height as f64).contains(&row);
        let percent = is_inside.then(|| known.cells.get(row as usize * known.width + col as usize)).flatten();
        if !percent.is_some_and(|percent| (0..=50).contains(percent)) {
            *cell = 100;
        }
    }
}

fn map_from_cells(image: &MapImage) -> Pose2 {
    pose2(image.origin[0], image.origin[1], image.origin[2])
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
        let narrow = FreeSpace::of_image(two_rooms(0), 0.2, WorldScene::default()).unwrap();
        let joined = FreeSpace::of_image(two_rooms(4), 0.2, WorldScene::default()).unwrap();
        let sides = |space: &FreeSpace| {
            let is_left = |middle: &[f64; 2]| middle[0] < 3.05;
            (
                space.ground.middles.iter().any(is_left),
                space.ground.middles.iter().any(|middle| !is_left(middle)),
            )
        };
        assert_eq!((sides(&narrow), sides(&joined)), ((true, false), (true, true)));
        // The wall stands from x = 3.0 m to 3.1 m; the hull of 0.2 m keeps 0.3 m from it.
        assert!(narrow.ground.middles.iter().all(|middle| middle[0] <= 2.5));
    }

    #[test]
    fn a_mission_is_that_of_its_seed_and_number_and_not_too_short() {
        let space = FreeSpace::of_image(two_rooms(4), 0.2, WorldScene::default()).unwrap();
        for seed in 0..50 {
            let ends = space.draw(seed, 0);
            let way_m = (ends.goal[0] - ends.start[0]).hypot(ends.goal[1] - ends.start[1]);
            assert!(way_m >= space.least_way_m && way_m > 2.0, "{way_m}");
            assert_eq!(ends, space.draw(seed, 0));
            assert_ne!(ends, space.draw(seed, 1));
        }
    }

    #[test]
    fn missions_stay_where_the_robots_own_map_shows_free_floor() {
        let mut image = two_rooms(4);
        // The robot knows the left room only, on a map of finer cells that is turned by a quarter.
        let known = MapImage {
            width: 80,
            height: 80,
            resolution_m: 0.05,
            origin: [3.0, 2.0, std::f64::consts::FRAC_PI_2],
            cells: vec![0; 80 * 80],
        };
        close_unknown(&mut image, &known);
        let space = FreeSpace::of_image(image, 0.2, WorldScene::default()).unwrap();
        assert!(
            space.ground.middles.iter().all(|middle| middle[0] <= 2.5),
            "{:?}",
            space.ground.middles.last()
        );
        assert!(space.ground.middles.iter().any(|middle| middle[0] >= 2.4));
    }

    #[test]
    fn a_world_without_room_is_refused() {
        let cells = vec![100; 100];
        let image = MapImage { width: 10, height: 10, resolution_m: 0.1, origin: [0.0; 3], cells };
        assert!(
            FreeSpace::of_image(image, 0.5, WorldScene::default()).unwrap_err().contains("no free space")
        );
    }
}
