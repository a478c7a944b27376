//! Levels and scans to match.

use super::super::*;
use crate::GridSize;
use rand::RngExt;
use rumbo_core::frames::{Point2, Pose2, pose2};

pub struct Scene {
    pub cells: Vec<f32>,
    pub size: GridSize,
    pub resolution_m: f64,
    pub map_from_level: Pose2,
    pub points: ScanPoints,
    pub walls: Vec<[f64; 4]>,
}

impl Scene {
    /// Any numbers in the cells, half of them untouched, and any points.
    pub fn random(seed: u64, origin: [f64; 3], n_points: usize) -> Scene {
        let mut rng = rumbo_core::rng::stream(seed, "scene");
        let size = GridSize::new(83, 61);
        let cell = |rng: &mut rumbo_core::rng::Rng| {
            if rng.random::<bool>() { (rng.random::<f32>() - 0.5) * 9.0 } else { 0.0 }
        };
        let cells = (0..size.n_cells()).map(|_| cell(&mut rng)).collect();
        let mut points = ScanPoints::default();
        for _ in 0..n_points {
            let [x, y] = [0, 1].map(|_| (rng.random::<f32>() - 0.5) * 6.0);
            points.push(x, y, 0.2 + rng.random::<f32>());
        }
        let map_from_level = pose2(origin[0], origin[1], origin[2]);
        Scene { cells, size, resolution_m: 0.1, map_from_level, points, walls: Vec::new() }
    }

    /// A room of 8 m x 6 m with a box in it.
    pub fn room(resolution_m: f64) -> Scene {
        let walls = vec![
            [-4.013, -3.021, 4.017, -3.021],
            [4.017, -3.021, 4.017, 3.008],
            [4.017, 3.008, -4.013, 3.008],
            [-4.013, 3.008, -4.013, -3.021],
            [1.51, 1.0, 2.53, 1.93],
            [2.53, 1.93, 3.0, 1.2],
        ];
        Scene::drawn(walls, resolution_m)
    }

    /// Two walls along x, longer than the map.
    pub fn corridor(resolution_m: f64) -> Scene {
        Scene::drawn(vec![[-40.0, -1.022, 40.0, -1.022], [-40.0, 1.224, 40.0, 1.224]], resolution_m)
    }

    /// Cells that a wall passes are sure, the others free.
    pub fn drawn(walls: Vec<[f64; 4]>, resolution_m: f64) -> Scene {
        let size = GridSize::new((12.0 / resolution_m) as usize, (10.0 / resolution_m) as usize);
        let mut cells = vec![-3.0; size.n_cells()];
        for [x0, y0, x1, y1] in &walls {
            for k in 0..=20_000 {
                let part = f64::from(k) / 20_000.0;
                let [x, y] =
                    [x0 + part * (x1 - x0) + 6.0, y0 + part * (y1 - y0) + 5.0].map(|m| m / resolution_m);
                if x >= 0.0 && y >= 0.0 && x < size.width as f64 && y < size.height as f64 {
                    cells[size.index(x as usize, y as usize)] = 4.0;
                }
            }
        }
        let map_from_level = pose2(-6.0, -5.0, 0.0);
        Scene { cells, size, resolution_m, map_from_level, points: ScanPoints::default(), walls }
    }

    pub fn level(&self) -> GridLevel<'_> {
        GridLevel::new(&self.cells, self.size, self.resolution_m, self.map_from_level.inverse()).unwrap()
    }

    /// Points on the walls as beams all around find them, up to 6 m.
    pub fn seen_from(&self, map_from_base: &Pose2, n_beams: usize) -> ScanPoints {
        let mut points = ScanPoints::default();
        for k in 0..n_beams {
            let bearing = (k as f64 + 0.5) * std::f64::consts::TAU / n_beams as f64;
            let (from, to) =
                (map_from_base.translation.vector, map_from_base * Point2::new(bearing.cos(), bearing.sin()));
            let ahead = to.coords - from;
            let nearest = self.walls.iter().filter_map(|[x0, y0, x1, y1]| {
                let (wx, wy) = (x1 - x0, y1 - y0);
                let determinant = ahead.x * wy - ahead.y * wx;
                let range = ((x0 - from.x) * wy - (y0 - from.y) * wx) / determinant;
                let part = ((x0 - from.x) * ahead.y - (y0 - from.y) * ahead.x) / determinant;
                (range > 0.0 && (0.0..=1.0).contains(&part)).then_some(range)
            });
            let range = nearest.fold(f64::INFINITY, f64::min);
            if range < 6.0 {
                points.push((range * bearing.cos()) as f32, (range * bearing.sin()) as f32, 1.0);
            }
        }
        points
    }
}
