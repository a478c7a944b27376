mod circular;
mod oracles;
mod properties;
mod rooms;
mod vectors;

use super::*;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use std::f64::consts::{FRAC_PI_2, PI};

/// Walls from end to end, meters.
type Walls = Vec<[[f64; 2]; 2]>;

/// A half turn ahead with steps of so many degrees.
fn half_turn(step_deg: f64) -> BeamFan {
    BeamFan {
        first_bearing_rad: -FRAC_PI_2,
        bearing_step_rad: step_deg.to_radians(),
        min_range_m: 0.05,
        max_range_m: 8.0,
    }
}

/// The exact range along a bearing; infinite where nothing is met.
fn range_to(walls: &Walls, bearing_rad: f64) -> f64 {
    let (sin, cos) = bearing_rad.sin_cos();
    let meets = |[a, b]: &[[f64; 2]; 2]| {
        let (along, across) = ([b[0] - a[0], b[1] - a[1]], cos * (b[1] - a[1]) - sin * (b[0] - a[0]));
        let range = (a[0] * along[1] - a[1] * along[0]) / across;
        let share = (a[0] * sin - a[1] * cos) / across;
        (across != 0.0 && range > 0.0 && (0.0..=1.0).contains(&share)).then_some(range)
    };
    walls.iter().filter_map(meets).fold(f64::INFINITY, f64::min)
}

fn scan(walls: &Walls, fan: &BeamFan, n: usize) -> Vec<f64> {
    (0..n).map(|k| range_to(walls, fan.first_bearing_rad + fan.bearing_step_rad * k as f64)).collect()
}

/// A standard normal number from uniform ones (Box and Muller 1958).
fn normal(rng: &mut Xoshiro256PlusPlus) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (2.0 * PI * v).cos()
}

fn turned([x, y]: [f64; 2], angle: f64) -> [f64; 2] {
    let (sin, cos) = angle.sin_cos();
    [cos * x - sin * y, sin * x + cos * y]
}

/// A room of 6 m by 4 m, seen from inside, with a box in it.
fn room(angle: f64) -> Walls {
    let outline = |points: &[[f64; 2]]| -> Walls {
        (0..points.len()).map(|k| [points[k], points[(k + 1) % points.len()]]).collect()
    };
    let mut walls = outline(&[[4.0, -1.5], [4.0, 2.5], [-2.0, 2.5], [-2.0, -1.5]]);
    walls.extend(outline(&[[1.5, -0.1], [2.3, -0.1], [2.3, 0.5], [1.5, 0.5]]));
    walls.iter().map(|ends| ends.map(|end| turned(end, angle))).collect()
}

fn extract(settings: LandmarkSettings, fan: &BeamFan, ranges: &[f64]) -> Vec<Landmark> {
    Extractor::new(settings).extract(fan, ranges.iter().copied()).to_vec()
}

fn with_hough() -> LandmarkSettings {
    LandmarkSettings { wall_fit: WallFit::Hough, ..LandmarkSettings::default() }
}
