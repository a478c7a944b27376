//! Offices, scans in them, and trials of global localization: what benches, tests and figures share.
#![allow(dead_code, unused_imports)]

mod alike;
mod course;
mod generated;

pub use alike::{FIRST_ROOM_M, ROOM_TO_ROOM_M};
pub use course::{Course, Ending, Said};

use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_core::map::{Grid, GridHeader};
use rumbo_core::rng::{Rng, stream};
use rumbo_core::stages::GiveUp;
use rumbo_core::time::Time;
use rumbo_kit::GridSize;
use rumbo_kit::landmark_model::{LandmarkModel, Progress, Surroundings};
use rumbo_kit::landmarks::BeamFan;
use rumbo_kit::ray::{Ray, RayGrid};
use rumbo_localizers::landmark_relaxation::LandmarkRelaxationParams;
use rumbo_localizers::landmark_relaxation::locator::{Locator, Verdict};
use rumbo_localizers::landmark_relaxation::matching::Knowledge;
use rumbo_localizers::landmark_relaxation::sighting::Sighting;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Edge of a cell, meters.
pub const CELL_M: f64 = 0.05;

/// A map with what is needed to look around in it.
pub struct Office {
    /// The map.
    pub grid: Grid,
    rays: RayGrid,
    size: GridSize,
    occupied: Vec<u8>,
}

impl Office {
    /// One of the three office maps.
    pub fn named(name: &str) -> Office {
        let file: toml::Table =
            toml::from_str(include_str!("../../tests/data/natural_landmark/maps.toml")).unwrap();
        let maps = file["map"].as_array().unwrap();
        let map = maps.iter().find(|map| map["name"].as_str() == Some(name)).unwrap();
        let number = |value: &toml::Value| value.as_integer().unwrap() as usize;
        let size = GridSize::new(number(&map["columns"]), number(&map["lines"]));
        let mut occupied = vec![0_u8; size.n_cells()];
        for rectangle in map["rectangles"].as_array().unwrap() {
            let [line, column, height, width, value] = [0, 1, 2, 3, 4].map(|k| number(&rectangle[k]));
            for line in line..line + height {
                for column in column..column + width {
                    occupied[size.index(column, size.height - 1 - line)] = value as u8;
                }
            }
        }
        let n_occupied = occupied.iter().filter(|cell| **cell == 1).count();
        assert_eq!(n_occupied, number(&map["occupied_cells"]), "{name}");
        Office::of(size, occupied, &[])
    }

    /// Lines of text, the upper first: `#` is occupied, `?` unknown; every letter is a square of `n` cells.
    pub fn drawn(n: usize, text: &str) -> Office {
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        let size = GridSize::new(lines[0].len() * n, lines.len() * n);
        let letter = |idx: usize| {
            let (col, row) = size.col_row(idx);
            lines[lines.len() - 1 - row / n].as_bytes()[col / n]
        };
        let occupied = (0..size.n_cells()).map(|idx| u8::from(letter(idx) == b'#')).collect();
        let unknown: Vec<usize> = (0..size.n_cells()).filter(|idx| letter(*idx) == b'?').collect();
        Office::of(size, occupied, &unknown)
    }

    fn of(size: GridSize, occupied: Vec<u8>, unknown: &[usize]) -> Office {
        let mut cells: Vec<f32> =
            occupied.iter().map(|cell| if *cell == 1 { Grid::CERTAIN } else { -Grid::CERTAIN }).collect();
        unknown.iter().for_each(|idx| cells[*idx] = 0.0);
        let header = GridHeader {
            width: size.width as u32,
            height: size.height as u32,
            resolution_m: CELL_M,
            origin: [0.0; 3],
            occupied_above: Grid::OCCUPIED_ABOVE,
            free_below: Grid::FREE_BELOW,
        };
        let rays = RayGrid::new(size, &occupied);
        Office { grid: Grid::new(header, cells.into()).unwrap(), rays, size, occupied }
    }

    /// The same surroundings with another map of them.
    pub fn with_map(self, grid: Grid) -> Office {
        Office { grid, ..self }
    }

    /// What a localizer with these parameters knows of the map.
    pub fn knowledge(&self, params: &LandmarkRelaxationParams) -> Knowledge {
        let surroundings = Surroundings::new(&self.grid);
        let (progress, give_up) = (Progress::default(), GiveUp::default());
        let model = LandmarkModel::build(&surroundings, &params.model(), &progress, &give_up).unwrap();
        Knowledge { grid: self.grid.clone(), surroundings, model }
    }

    /// Somewhere on free floor, 0.30 m from everything, turned anyhow.
    pub fn pose(&self, rng: &mut Rng) -> Pose2 {
        loop {
            let [x, y] = [self.size.width, self.size.height].map(|n| rng.random_range(0.0..n as f64));
            if self.is_open(x, y, 0.30 / CELL_M) {
                return pose2(x * CELL_M, y * CELL_M, rng.random_range(-PI..PI));
            }
        }
    }

    /// No occupied cell within so many cells.
    pub fn is_open(&self, x: f64, y: f64, radius: f64) -> bool {
        let reach = radius.ceil() as i64 + 1;
        let near = |d_col: i64, d_row: i64| {
            let (col, row) = (x.floor() as i64 + d_col, y.floor() as i64 + d_row);
            let (dx, dy) = (
                (col as f64 - x).max(x - (col + 1) as f64).max(0.0),
                (row as f64 - y).max(y - (row + 1) as f64).max(0.0),
            );
            let is_inside =
                col >= 0 && row >= 0 && col < self.size.width as i64 && row < self.size.height as i64;
            dx.hypot(dy) <= radius && (!is_inside || self.rays.is_occupied(col, row))
        };
        !(-reach..=reach).any(|d_row| (-reach..=reach).any(|d_col| near(d_col, d_row)))
    }

    /// Occupied, one byte a cell.
    pub fn occupied(&self) -> &[u8] {
        &self.occupied
    }

    /// The range to the first thing along a ray, meters.
    pub fn range_m(&self, sensor: &Pose2, bearing_rad: f64, boxes: &[[f64; 4]]) -> f64 {
        let [col, row] = [sensor.translation.x / CELL_M, sensor.translation.y / CELL_M];
        let angle = sensor.rotation.angle() + bearing_rad;
        let wall_m = self.rays.cast(&Ray::at_angle(col, row, angle), 1e4) * CELL_M;
        let along = [angle.cos(), angle.sin()];
        let from = [sensor.translation.x, sensor.translation.y];
        boxes.iter().filter_map(|sides| to_box(from, along, sides)).fold(wall_m, f64::min)
    }
}

/// Where a ray enters a box with sides x0, y0, x1, y1.
fn to_box(from: [f64; 2], along: [f64; 2], sides: &[f64; 4]) -> Option<f64> {
    let (mut enter, mut leave) = (0.0_f64, f64::INFINITY);
    for axis in 0..2 {
        let (a, b) = ((sides[axis] - from[axis]) / along[axis], (sides[axis + 2] - from[axis]) / along[axis]);
        enter = enter.max(a.min(b));
        leave = leave.min(a.max(b));
    }
    (enter < leave).then_some(enter)
}

/// Three boxes of 0.30 m with a corner 0.6 to 2.0 m from the robot.
pub fn boxes(robot: &Pose2, rng: &mut Rng) -> Vec<[f64; 4]> {
    let one = |rng: &mut Rng| {
        let (angle, distance): (f64, f64) = (rng.random_range(0.0..TAU), rng.random_range(0.6..2.0));
        let (x, y) =
            (robot.translation.x + distance * angle.cos(), robot.translation.y + distance * angle.sin());
        let (to_x, to_y) = (x + 0.3 * angle.cos().signum(), y + 0.3 * angle.sin().signum());
        [x.min(to_x), y.min(to_y), x.max(to_x), y.max(to_y)]
    };
    (0..3).map(|_| one(rng)).collect()
}

/// What stands around that the map does not show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clutter {
    /// Nothing.
    None,
    /// Three boxes, see [`boxes`].
    Boxes,
    /// Things that hide half of the view, half a meter away.
    HalfHidden,
    /// A straight partition that hides half of the view, 0.4 m away and 6 m long: of 180 degrees it leaves 15.
    HalfWalled,
}

impl Clutter {
    /// Boxes around a robot.
    pub fn around(self, robot: &Pose2, rng: &mut Rng) -> Vec<[f64; 4]> {
        let first: f64 = rng.random_range(0.0..TAU);
        let hiding = |k: usize| {
            let angle = first + PI / 6.0 * k as f64;
            let (x, y) = (robot.translation.x + 0.7 * angle.cos(), robot.translation.y + 0.7 * angle.sin());
            [x - 0.18, y - 0.18, x + 0.18, y + 0.18]
        };
        match self {
            Clutter::None => Vec::new(),
            Clutter::Boxes => boxes(robot, rng),
            Clutter::HalfHidden => (0..6).map(hiding).collect(),
            Clutter::HalfWalled => {
                let side =
                    [[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]][(first / TAU * 4.0) as usize % 4];
                let [x, y] = [0, 1].map(|k| [robot.translation.x, robot.translation.y][k] + 0.43 * side[k]);
                let [wide, high] = [0, 1].map(|k| if side[k] == 0.0 { 3.0 } else { 0.03 });
                vec![[x - wide, y - high, x + wide, y + high]]
            }
        }
    }
}

/// A laser.
#[derive(Debug, Clone, Copy)]
pub struct Laser {
    /// Where it sits.
    pub base_from_sensor: Pose2,
    /// Its beams.
    pub fan: BeamFan,
    /// How many.
    pub n_beams: usize,
    /// Standard deviation of a range, meters.
    pub deviation_m: f64,
}

impl Laser {
    /// Half a turn ahead in half degrees, as a SICK LMS 200 has.
    pub fn lms200() -> Laser {
        let fan = BeamFan {
            first_bearing_rad: -FRAC_PI_2,
            bearing_step_rad: 0.5_f64.to_radians(),
            min_range_m: 0.05,
            max_range_m: 8.0,
        };
        Laser { base_from_sensor: Pose2::identity(), fan, n_beams: 361, deviation_m: 0.01 }
    }

    /// All around in single degrees.
    pub fn round() -> Laser {
        let half = Laser::lms200();
        let fan = BeamFan { first_bearing_rad: -PI, bearing_step_rad: 1_f64.to_radians(), ..half.fan };
        Laser { fan, n_beams: 360, ..half }
    }

    /// What it sees from a pose of the base.
    pub fn ranges_m(&self, office: &Office, base: &Pose2, boxes: &[[f64; 4]], rng: &mut Rng) -> Vec<f64> {
        let sensor = base * self.base_from_sensor;
        let range = |k: usize| {
            let bearing = self.fan.first_bearing_rad + self.fan.bearing_step_rad * k as f64;
            let noise: f64 = StandardNormal.sample(rng);
            let range_m = office.range_m(&sensor, bearing, boxes);
            if range_m >= self.fan.max_range_m { f64::INFINITY } else { range_m + self.deviation_m * noise }
        };
        (0..self.n_beams).map(range).collect()
    }

    /// A scan with what is known of it.
    pub fn sighting(&self, ranges_m: Vec<f64>, odom_from_base: Pose2, seconds: f64) -> Sighting {
        Sighting {
            stamp: Time::from_secs(seconds),
            odom_from_base,
            base_from_sensor: self.base_from_sensor,
            fan: self.fan,
            ranges_m,
        }
    }

    /// Looks, turns half around (which the odometer misjudges by `turn_error_rad`), and looks again; ends at `pose`.
    pub fn look_around(
        &self,
        office: &Office,
        pose: &Pose2,
        boxes: &[[f64; 4]],
        turn_error_rad: f64,
        rng: &mut Rng,
    ) -> Vec<Sighting> {
        let newest = self.sighting(self.ranges_m(office, pose, boxes, rng), Pose2::identity(), 60.0);
        if self.fan.bearing_step_rad * self.n_beams as f64 >= TAU - 0.1 {
            return vec![newest];
        }
        let before = pose * Pose2::rotation(PI);
        let odom_from_base = Pose2::rotation(PI + turn_error_rad);
        vec![self.sighting(self.ranges_m(office, &before, boxes, rng), odom_from_base, 0.0), newest]
    }
}

/// What came of a trial.
#[derive(Debug, Clone, Copy)]
pub struct Outcome {
    /// A single place was named.
    pub is_found: bool,
    /// Several were.
    pub is_ambiguous: bool,
    /// Distance from the truth, meters.
    pub off_m: f64,
    /// Error of the heading, degrees.
    pub off_deg: f64,
    /// Squared error in terms of the claimed covariance.
    pub nees: f64,
    /// How much speaks for the place.
    pub score: f64,
    /// Cells after the filter.
    pub n_cells: usize,
}

impl Outcome {
    /// Found within 0.10 m.
    pub fn is_success(&self) -> bool {
        self.is_found && self.off_m <= 0.10
    }

    /// A wrong place was named as the only one.
    pub fn is_wrong(&self) -> bool {
        self.is_found && self.off_m > 0.10
    }
}

/// One trial: somewhere in the office, with or without things that the map does not show.
pub fn trial(
    office: &Office,
    known: &Knowledge,
    params: &LandmarkRelaxationParams,
    laser: &Laser,
    clutter: Clutter,
    seed: u64,
) -> Outcome {
    let mut rng = stream(seed, "relocalization");
    let pose = office.pose(&mut rng);
    let around = clutter.around(&pose, &mut rng);
    let normal: f64 = StandardNormal.sample(&mut rng);
    let sightings = laser.look_around(office, &pose, &around, 0.02 * normal, &mut rng);
    let mut locator = Locator::new(params.locator(), stream(seed, "noise"));
    let verdict = locator.locate(known, &sightings, None);
    let mut outcome = Outcome {
        is_found: false,
        is_ambiguous: matches!(verdict, Verdict::Ambiguous(_)),
        off_m: f64::INFINITY,
        off_deg: f64::INFINITY,
        nees: f64::NAN,
        score: f64::NAN,
        n_cells: locator.report().n_cells,
    };
    if let Verdict::Found(place) = verdict {
        let way = place.map_from_base.translation.vector - pose.translation.vector;
        let turn = wrap_angle(place.map_from_base.rotation.angle() - pose.rotation.angle());
        let off = nalgebra::Vector3::new(way.x, way.y, turn);
        outcome.is_found = true;
        outcome.score = place.score;
        outcome.off_m = way.norm();
        outcome.off_deg = turn.abs().to_degrees();
        outcome.nees = place.covariance.try_inverse().map_or(f64::NAN, |inverse| off.dot(&(inverse * off)));
    }
    outcome
}
