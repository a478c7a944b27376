//! Walls and boxes as segments, and distances to them by brute force.

use rumbo_core::frames::Point2;

/// A place.
#[derive(Debug, Clone)]
pub struct Place {
    segments: Vec<[Point2; 2]>,
}

fn numbers(value: &toml::Value) -> Vec<f64> {
    let number = |value: &toml::Value| value.as_float().unwrap_or_else(|| value.as_integer().unwrap() as f64);
    value.as_array().unwrap().iter().map(number).collect()
}

impl Place {
    /// A place without anything.
    pub fn empty() -> Place {
        Place { segments: Vec::new() }
    }

    /// The arena of 5 m by 5 m.
    pub fn arena() -> Place {
        Place::read(include_str!("../data/dc_arena_world.toml"))
    }

    /// The office of 20 m by 20 m.
    pub fn office() -> Place {
        Place::read(include_str!("../data/dc_office_world.toml"))
    }

    fn read(text: &str) -> Place {
        let table: toml::Table = toml::from_str(text).unwrap();
        let mut place = Place::empty();
        for wall in table["world"]["segments"].as_array().unwrap() {
            let wall = numbers(wall);
            place.segments.push([Point2::new(wall[0], wall[1]), Point2::new(wall[2], wall[3])]);
        }
        for solid in table["box"].as_array().unwrap() {
            let (center, size) = (numbers(&solid["center"]), numbers(&solid["size"]));
            let corner =
                |x: f64, y: f64| Point2::new(center[0] + x * size[0] / 2.0, center[1] + y * size[1] / 2.0);
            let corners = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            place.segments.extend((0..4).map(|k| [corners[k], corners[(k + 1) % 4]]));
        }
        place
    }

    /// Along a ray to the first wall, meters; infinite where there is none.
    pub fn range_m(&self, from: Point2, bearing_rad: f64) -> f64 {
        let along = nalgebra::Vector2::new(bearing_rad.cos(), bearing_rad.sin());
        let hit = |[a, b]: &[Point2; 2]| {
            let (wall, to_a) = (b - a, a - from);
            let cross = along.perp(&wall);
            let (range_m, share) = (to_a.perp(&wall) / cross, to_a.perp(&along) / cross);
            (cross.abs() > 1e-12 && range_m >= 0.0 && (0.0..=1.0).contains(&share)).then_some(range_m)
        };
        self.segments.iter().filter_map(hit).fold(f64::INFINITY, f64::min)
    }

    /// To the nearest wall, meters.
    pub fn clearance_m(&self, at: Point2) -> f64 {
        let to = |[a, b]: &[Point2; 2]| {
            let wall = b - a;
            let share = ((at - a).dot(&wall) / wall.norm_squared()).clamp(0.0, 1.0);
            (a + wall * share - at).norm()
        };
        self.segments.iter().map(to).fold(f64::INFINITY, f64::min)
    }
}
