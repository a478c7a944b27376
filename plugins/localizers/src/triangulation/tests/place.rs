//! Three offices: what a map says of them, and where their walls really stand.

use rand::RngExt;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::{Grid, GridHeader};
use rumbo_core::rng::{Rng, stream};
use rumbo_kit::GridSize;
use rumbo_kit::ray::{Ray, RayGrid};
use std::f64::consts::TAU;

const CELL_M: f64 = 0.05;
/// What the robot does between two scans.
const STEP_M: f64 = 0.1;
const STEP_RAD: f64 = 0.074;

/// A rectangle that is solid, or cut out of what was solid before.
struct Block {
    low: [f64; 2],
    high: [f64; 2],
    is_solid: bool,
}

/// An office.
pub struct Office {
    /// Its map: the cells whose centers are solid.
    pub grid: Grid,
    blocks: Vec<Block>,
    /// Grown by the robot.
    room: RayGrid,
    size: GridSize,
}

fn number(value: &toml::Value) -> usize {
    value.as_integer().unwrap() as usize
}

fn grid_of(size: GridSize, occupied: &[u8]) -> Grid {
    let cells: Vec<f32> =
        occupied.iter().map(|cell| if *cell == 1 { Grid::CERTAIN } else { -Grid::CERTAIN }).collect();
    let header = GridHeader {
        width: size.width as u32,
        height: size.height as u32,
        resolution_m: CELL_M,
        origin: [0.0; 3],
        occupied_above: Grid::OCCUPIED_ABOVE,
        free_below: Grid::FREE_BELOW,
    };
    Grid::new(header, cells.into()).unwrap()
}

impl Office {
    /// The office whose every wall stands where the map has it.
    pub fn exact(name: &str) -> Office {
        Office::placed(name, &mut || 0.0)
    }

    /// One of the offices that have this map: each face of each wall is up to half a cell from where the map has it.
    pub fn like(name: &str, seed: u64) -> Office {
        let mut rng = stream(seed, "walls");
        Office::placed(name, &mut || CELL_M * rng.random_range(-0.499..0.499))
    }

    fn placed(name: &str, off_m: &mut dyn FnMut() -> f64) -> Office {
        let file: toml::Table =
            toml::from_str(include_str!("../../../tests/data/natural_landmark/maps.toml")).unwrap();
        let maps = file["map"].as_array().unwrap();
        let map = maps.iter().find(|map| map["name"].as_str() == Some(name)).unwrap();
        let size = GridSize::new(number(&map["columns"]), number(&map["lines"]));
        let rectangles = map["rectangles"].as_array().unwrap().iter();
        let rectangles: Vec<[usize; 5]> =
            rectangles.map(|rectangle| [0, 1, 2, 3, 4].map(|k| number(&rectangle[k]))).collect();
        let office = Office::of(size, &rectangles, off_m);
        let n_occupied = office.grid.cells.iter().filter(|cell| **cell > 0.0).count();
        assert_eq!(n_occupied, number(&map["occupied_cells"]), "{name}");
        office
    }

    /// Line, column, height, width (cells, lines from the top) and whether it is solid, in order.
    pub fn of(size: GridSize, rectangles: &[[usize; 5]], off_m: &mut dyn FnMut() -> f64) -> Office {
        let mut occupied = vec![0_u8; size.n_cells()];
        let mut blocks = Vec::new();
        for [line, column, height, width, value] in rectangles.iter().copied() {
            for line in line..line + height {
                for column in column..column + width {
                    occupied[size.index(column, size.height - 1 - line)] = value as u8;
                }
            }
            let mut face = |cells: usize| cells as f64 * CELL_M + off_m();
            // A door goes through the whole wall, wherever its faces are.
            let beyond = |n: usize| if value == 0 && n <= 3 { CELL_M } else { 0.0 };
            let (beside, above) = (beyond(width), beyond(height));
            let low = [face(column) - beside, face(size.height - line - height) - above];
            let high = [face(column + width) + beside, face(size.height - line) + above];
            blocks.push(Block { low, high, is_solid: value == 1 });
        }
        let field = rumbo_kit::distance_field::squared_distance_field(size, &occupied);
        let grown: Vec<u8> = field.iter().map(|squared| u8::from(*squared <= 36)).collect();
        Office { grid: grid_of(size, &occupied), blocks, room: RayGrid::new(size, &grown), size }
    }

    /// A corridor along x that is longer than a laser looks, 2 m wide, and the line in its middle.
    pub fn corridor(length_m: f64, seed: u64) -> (Office, f64) {
        let n = (length_m / CELL_M) as usize;
        let rectangles = [[0, 0, 2, n, 1], [42, 0, 2, n, 1], [0, 0, 44, 2, 1], [0, n - 2, 44, 2, 1]];
        let mut rng = stream(seed, "walls");
        let mut off_m = || CELL_M * rng.random_range(-0.499..0.499);
        (Office::of(GridSize::new(n, 44), &rectangles, &mut off_m), 1.1)
    }

    fn is_solid(&self, [x, y]: [f64; 2]) -> bool {
        let holds = |block: &&Block| {
            (block.low[0]..=block.high[0]).contains(&x) && (block.low[1]..=block.high[1]).contains(&y)
        };
        self.blocks.iter().rev().find(holds).is_some_and(|block| block.is_solid)
    }

    /// The way to the first wall; infinite from `reach_m` on.
    pub fn range_m(&self, [x, y]: [f64; 2], angle_rad: f64, reach_m: f64) -> f64 {
        let (sin, cos) = angle_rad.sin_cos();
        let mut borders = vec![0.0, reach_m];
        for block in &self.blocks {
            let slab = |low: f64, high: f64, from: f64, along: f64| {
                let [a, b] = [(low - from) / along, (high - from) / along];
                (a.min(b), a.max(b))
            };
            let (x_in, x_out) = slab(block.low[0], block.high[0], x, cos);
            let (y_in, y_out) = slab(block.low[1], block.high[1], y, sin);
            let (enter, leave) = (x_in.max(y_in), x_out.min(y_out));
            if enter < leave && leave > 0.0 && enter < reach_m {
                borders.extend([enter, leave].into_iter().filter(|way| (0.0..reach_m).contains(way)));
            }
        }
        borders.sort_by(f64::total_cmp);
        let pieces = borders.windows(2).filter(|ends| ends[1] - ends[0] > 1e-9);
        let mut walls = pieces.filter(|ends| {
            let middle = (ends[0] + ends[1]) / 2.0;
            self.is_solid([x + middle * cos, y + middle * sin])
        });
        walls.next().map_or(f64::INFINITY, |ends| ends[0])
    }

    /// A place with room for the robot.
    pub fn free_place(&self, rng: &mut Rng) -> Pose2 {
        loop {
            let [col, row] = [self.size.width, self.size.height].map(|n| rng.random_range(0..n));
            if !self.room.is_occupied(col as i64, row as i64) {
                let yaw = rng.random_range(0.0..TAU);
                return pose2((col as f64 + 0.5) * CELL_M, (row as f64 + 0.5) * CELL_M, yaw);
            }
        }
    }

    /// Poses half a second apart: turn in place, go straight, again, until the way is long enough.
    pub fn route(&self, length_m: f64, rng: &mut Rng) -> Vec<Pose2> {
        let start = self.free_place(rng);
        let (mut x, mut y, mut yaw) = (start.translation.x, start.translation.y, start.rotation.angle());
        let mut poses = vec![start];
        let mut driven_m = 0.0;
        while driven_m < length_m {
            let next: f64 = yaw + rng.random_range(-2.0..2.0);
            let ray = Ray::at_angle(x / CELL_M, y / CELL_M, next);
            let free_m = self.room.cast(&ray, 200.0) * CELL_M - 0.05;
            if free_m < 0.3 && rng.random::<f64>() < 0.95 {
                continue;
            }
            while (next - yaw).abs() > 1e-9 {
                yaw += (next - yaw).clamp(-STEP_RAD, STEP_RAD);
                poses.push(pose2(x, y, yaw));
            }
            let mut left_m = free_m.clamp(0.0, 3.0).min(length_m - driven_m);
            driven_m += left_m;
            while left_m > 1e-9 {
                let step_m = left_m.min(STEP_M);
                left_m -= step_m;
                x += step_m * yaw.cos();
                y += step_m * yaw.sin();
                poses.push(pose2(x, y, yaw));
            }
        }
        poses
    }
}

#[test]
fn rays_meet_the_walls_of_an_exact_office_where_the_map_has_them_and_others_within_a_cell() {
    for name in ["5x5", "10x10", "20x20"] {
        let (office, other) = (Office::exact(name), Office::like(name, 1));
        let occupied: Vec<u8> = office.grid.cells.iter().map(|cell| u8::from(*cell > 0.0)).collect();
        let rays = RayGrid::new(office.size, &occupied);
        let (mut n_near, n) = (0, 2000);
        for k in 0..n {
            let place = office.free_place(&mut stream(k, "place"));
            let (at, yaw) = ([place.translation.x, place.translation.y], place.rotation.angle());
            let by_map = rays.cast(&Ray::at_angle(at[0] / CELL_M, at[1] / CELL_M, yaw), 160.0) * CELL_M;
            let exact = office.range_m(at, yaw, 8.0).min(8.0);
            assert!((exact - by_map).abs() < 1e-6, "{name}: {exact} for {by_map}");
            n_near += usize::from((other.range_m(at, yaw, 8.0).min(8.0) - by_map).abs() < 0.1);
        }
        assert!(n_near > n as usize * 9 / 10, "{name}: {n_near}");
    }
}
