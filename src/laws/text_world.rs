//! Worlds drawn as text.

use super::law::Trouble;
use super::turn::Turn;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::map::{Cell, CellClass, Grid, Landmark, Landmarks, Line, Lines, Map};
use rumbo_core::messages::Goal;
use rumbo_kit::GridSize;
use rumbo_kit::map_file::{MapImage, UNKNOWN};
use rumbo_kit::ray::{Ray, RayGrid};
use rumbo_maps::static_map::wall_lines;

/// Two rooms with a door of 1.5 m beside the straight way: any sensible clearance leaves a way.
pub const ROOMS: &str = "
    ##########################
    #...........#............#
    #...........#........G...#
    #..S........#............#
    #........................#
    #........................#
    #........................#
    #........................#
    #........................#
    #........................#
    #...........#............#
    #...........#............#
    #...........#............#
    #...........#............#
    ##########################";

/// Edge of a letter of [`ROOMS`], meters.
pub const ROOMS_LETTER_M: f64 = 0.25;

/// A room that looks different from everywhere.
pub const HALL: &str = "
    ####################
    #......#...........#
    #......#...........#
    #..................#
    #..............##..#
    #..............##..#
    #..S...............#
    #..................#
    #.....##.......G...#
    #.....##...........#
    #..................#
    ####################";

/// Edge of a letter of [`HALL`], meters.
pub const HALL_LETTER_M: f64 = 0.5;

/// Edge of a letter of [`OPEN`], meters.
pub const OPEN_LETTER_M: f64 = 0.5;

/// Nothing stands between start and goal, and little beside the way: a search that may end early finds it all the same.
pub const OPEN: &str = "
    ##########################
    #........................#
    #........................#
    #........................#
    #........................#
    #........#..........G....#
    #........................#
    #........................#
    #........................#
    #........................#
    #........................#
    #....S...................#
    #........................#
    #........................#
    #........................#
    #........................#
    ##########################";

/// Shorter pieces of wall are no lines of the map, meters.
const SHORTEST_LINE_M: f64 = 0.3;

/// Marks on the walls of [`HALL`]: identity, and place in meters, a hair before the wall.
pub const HALL_MARKS: [(u32, [f64; 2]); 6] = [
    (1, [9.49, 2.0]),
    (2, [9.49, 4.2]),
    (3, [5.2, 5.49]),
    (4, [7.0, 0.51]),
    (5, [0.51, 4.5]),
    (6, [2.0, 0.51]),
];

/// A drawn world: `#` occupied, `?` unknown, `S` start, `G` goal, anything else free.
#[derive(Debug, Clone)]
pub struct TextWorld {
    /// Its grid, with the lower left corner at the origin.
    pub grid: Grid,
    /// Where the robot starts; it looks along the lines.
    pub start: Pose2,
    /// Where it shall go.
    pub goal: Goal,
    /// Marks that a camera can recognize, with their identities.
    pub marks: Vec<(u32, Point2)>,
    rays: RayGrid,
}

impl TextWorld {
    /// The world of a picture whose letters are `letter_m` wide and made of `n_cells` by `n_cells` cells.
    pub fn drawn(picture: &str, letter_m: f64, n_cells: u32) -> Result<TextWorld, Trouble> {
        let rows: Vec<&str> = picture.lines().map(str::trim).filter(|line| !line.is_empty()).rev().collect();
        let n_cols = rows.iter().map(|row| row.len()).max().unwrap_or(0) as u32;
        let resolution_m = letter_m / f64::from(n_cells);
        let mut grid = Grid::unknown(n_cols * n_cells, rows.len() as u32 * n_cells, resolution_m)?;
        let (mut start, mut goal) = (None, None);
        for (row, line) in (0..).zip(&rows) {
            for (col, letter) in (0..).zip(line.bytes()) {
                let middle = Point2::new(f64::from(col) + 0.5, f64::from(row) + 0.5) * letter_m;
                match letter {
                    b'S' => start = Some(middle),
                    b'G' => goal = Some(middle),
                    _ => {}
                }
                let log_odds = match letter {
                    b'#' => Grid::CERTAIN,
                    b'?' => 0.0,
                    _ => -Grid::CERTAIN,
                };
                fill(&mut grid, [col * n_cells, row * n_cells], n_cells, log_odds);
            }
        }
        let start = start.ok_or_else(|| Trouble::not_applicable("the law's own picture has no start"))?;
        let goal = Goal { position: goal.unwrap_or(start), yaw_rad: None };
        Ok(TextWorld::new(grid, pose2(start.x, start.y, 0.0), goal))
    }

    /// The rooms, in cells of 5 cm.
    pub fn rooms() -> Result<TextWorld, Trouble> {
        TextWorld::drawn(ROOMS, ROOMS_LETTER_M, 5)
    }

    /// The rooms, in as few cells as there are letters.
    pub fn coarse_rooms() -> Result<TextWorld, Trouble> {
        TextWorld::drawn(ROOMS, ROOMS_LETTER_M, 1)
    }

    /// The hall, in cells of 5 cm.
    pub fn hall() -> Result<TextWorld, Trouble> {
        let marks = HALL_MARKS.map(|(identity, at)| (identity, Point2::from(at))).to_vec();
        Ok(TextWorld { marks, ..TextWorld::drawn(HALL, HALL_LETTER_M, 10)? })
    }

    /// The open floor, in cells of 5 cm.
    pub fn open() -> Result<TextWorld, Trouble> {
        TextWorld::drawn(OPEN, OPEN_LETTER_M, 10)
    }

    /// A way through `n` by `n` cells of 10 cm that winds from wall to wall.
    pub fn serpentine(n: u32) -> Result<TextWorld, Trouble> {
        // Lanes of 2 m, walls of 10 cm, gaps of 2 m in turns at the right and at the left end.
        let (lane, resolution_m) = (20, 0.1);
        let mut grid = Grid::unknown(n, n, resolution_m)?;
        let last_lane = (n - 2) / (lane + 1);
        for row in 0..n {
            let is_wall_row = row % (lane + 1) == 0;
            let gap_is_right = row / (lane + 1) % 2 == 1;
            for col in 0..n {
                let is_gap = if gap_is_right { col + lane >= n - 1 } else { col <= lane };
                let is_rim = row == 0 || col == 0 || row + 1 == n || col + 1 == n;
                let is_wall = is_rim || (is_wall_row && !is_gap);
                let log_odds = if is_wall { Grid::CERTAIN } else { -Grid::CERTAIN };
                fill(&mut grid, [col, row], 1, log_odds);
            }
        }
        let middle_of = |lane_no: u32| f64::from(lane_no * (lane + 1) + lane / 2) * resolution_m;
        let start = pose2(f64::from(lane / 2) * resolution_m, middle_of(0), 0.0);
        let goal = Point2::new(f64::from(n / 2) * resolution_m, middle_of(last_lane.saturating_sub(1)));
        Ok(TextWorld::new(grid, start, Goal { position: goal, yaw_rad: None }))
    }

    fn new(grid: Grid, start: Pose2, goal: Goal) -> TextWorld {
        let occupied: Vec<u8> =
            grid.cells.iter().map(|v| u8::from(grid.class_of(*v) == CellClass::Occupied)).collect();
        let rays = RayGrid::new(GridSize::new(grid.width() as usize, grid.height() as usize), &occupied);
        TextWorld { grid, start, goal, marks: Vec::new(), rays }
    }

    /// The same world from another side.
    pub fn turned(&self, turn: Turn) -> Result<TextWorld, Trouble> {
        let height_m = self.height_m();
        let goal = Goal {
            position: turn.point(self.goal.position, height_m),
            yaw_rad: self.goal.yaw_rad.map(|yaw| turn.yaw(yaw)),
        };
        let marks = self.marks.iter().map(|(identity, at)| (*identity, turn.point(*at, height_m))).collect();
        let turned = TextWorld::new(turn.grid(&self.grid)?, turn.pose(&self.start, height_m), goal);
        Ok(TextWorld { marks, ..turned })
    }

    /// The same world with a disc in it.
    pub fn with_disc(&self, middle: Point2, radius_m: f64) -> TextWorld {
        let mut grid = self.grid.clone();
        grid.occupy_disc(middle, radius_m);
        TextWorld { marks: self.marks.clone(), ..TextWorld::new(grid, self.start, self.goal) }
    }

    /// From the lower to the upper rim, meters.
    pub fn height_m(&self) -> f64 {
        f64::from(self.grid.height()) * self.grid.resolution_m()
    }

    /// Its map: the grid, the lines of its walls, and its marks if there are any.
    pub fn map(&self) -> Map {
        let lines = Lines { lines: Buffer::from(self.lines()) };
        let landmark = |(identity, at): &(u32, Point2)| Landmark {
            identity: *identity,
            position: [at.x, at.y],
            covariance: [1e-6, 0.0, 1e-6],
            ..Landmark::default()
        };
        let landmarks: Vec<Landmark> = self.marks.iter().map(landmark).collect();
        let landmarks = (!landmarks.is_empty()).then(|| Landmarks { landmarks: landmarks.into() });
        let (grid, lines) = (Some(self.grid.clone()), Some(lines));
        Map { grid, lines, landmarks, version: 1, ..Map::default() }
    }

    fn lines(&self) -> Vec<Line> {
        let percent = |log_odds: &f32| match self.grid.class_of(*log_odds) {
            CellClass::Occupied => 100,
            CellClass::Free => 0,
            CellClass::Unknown => UNKNOWN,
        };
        let image = MapImage {
            width: self.grid.width() as usize,
            height: self.grid.height() as usize,
            resolution_m: self.grid.resolution_m(),
            origin: self.grid.header().origin,
            cells: self.grid.cells.iter().map(percent).collect(),
        };
        wall_lines(&image, SHORTEST_LINE_M)
    }

    /// From a place along a heading to the first wall, meters; infinite where there is none within reach.
    pub fn range_m(&self, from: &Pose2, max_range_m: f64) -> f64 {
        let cell_m = self.grid.resolution_m();
        let ray =
            Ray::at_angle(from.translation.x / cell_m, from.translation.y / cell_m, from.rotation.angle());
        let most = max_range_m / cell_m;
        let cells = self.rays.cast(&ray, most);
        if cells < most { cells * cell_m } else { f64::INFINITY }
    }

    /// From a point to the edge of the nearest occupied cell, meters; zero inside one.
    pub fn clearance_m(&self, point: Point2) -> f64 {
        let (cell_m, at) = (self.grid.resolution_m(), point / self.grid.resolution_m());
        let mut nearest = f64::INFINITY;
        for index in 0..self.grid.cells.len() {
            let cell: Cell = self.grid.cell_of(index);
            if self.grid.class(cell) == CellClass::Occupied {
                let beside = |at: f64, low: u32| {
                    let low = f64::from(low);
                    (low - at).max(at - low - 1.0).max(0.0)
                };
                nearest = nearest.min(beside(at.x, cell.col).hypot(beside(at.y, cell.row)));
            }
        }
        nearest * cell_m
    }
}

/// Writes a square of cells.
fn fill(grid: &mut Grid, [col, row]: [u32; 2], n_cells: u32, log_odds: f32) {
    let width = grid.width() as usize;
    let cells = grid.cells.make_mut();
    for row in row..row + n_cells {
        let first = row as usize * width + col as usize;
        if let Some(part) = cells.get_mut(first..first + n_cells as usize) {
            part.fill(log_odds);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turned_world_has_the_same_ranges_to_the_other_side() {
        let world = TextWorld::hall().unwrap();
        let height_m = world.height_m();
        for turn in Turn::BOTH {
            let turned = world.turned(turn).unwrap();
            for yaw in [-2.0, 0.3, 1.1] {
                let from = world.start * pose2(0.02, 0.01, yaw);
                let there = turned.range_m(&turn.pose(&from, height_m), 20.0);
                assert!((world.range_m(&from, 20.0) - there).abs() < 1e-6, "{turn:?} {yaw}");
            }
        }
    }

    #[test]
    fn the_clearance_is_to_the_edge_of_the_wall() {
        let world = TextWorld::drawn("###\n#S#\n###", 1.0, 2).unwrap();
        assert!((world.clearance_m(Point2::new(1.25, 1.5)) - 0.25).abs() < 1e-9);
        assert_eq!(world.clearance_m(Point2::new(0.5, 1.5)), 0.0);
    }

    #[test]
    fn a_serpentine_winds() {
        let world = TextWorld::serpentine(100).unwrap();
        assert_eq!(world.grid.class(world.grid.cell_at(world.goal.position).unwrap()), CellClass::Free);
        assert!(world.range_m(&(world.start * pose2(0.0, 0.0, 1.57)), 20.0) < 1.2);
    }
}
