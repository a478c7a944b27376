//! What sensors see: fans of beams, depth pictures and sound cones, exact and without noise.

use rumbo_core::frames::{Point2, Pose3};
use rumbo_core::messages::Intrinsics;

use super::place::{Place, View};
use super::solid::{Ray, Solid, Vector};
use super::sound::echo;

/// A fan of beams in the plane of the sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fan {
    /// Bearing of the first beam.
    pub first_bearing_rad: f64,
    /// From one beam to the next.
    pub bearing_step_rad: f64,
    /// How many.
    pub n_beams: usize,
}

/// A ring of sound cones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ring<'a> {
    /// Bearing of each cone's axis.
    pub bearings_rad: &'a [f64],
    /// Full opening of a cone.
    pub cone_rad: f64,
    /// Transducers sit this far from the ring's center.
    pub ring_radius_m: f64,
}

/// Memory of the world's eyes, kept so that a warm scan allocates nothing.
#[derive(Debug, Default)]
pub struct Eyes {
    fans: Vec<((f64, usize), Vec<Vector>)>,
    movers: Vec<Solid>,
    shots: Vec<(Ray, f64)>,
    /// Meters of answer for each cell of a shot's way.
    scales: Vec<f64>,
    ranges_m: Vec<f32>,
}

/// A mount whose axes rise less than this looks along the floor.
const LEVEL: f64 = 1e-12;
/// A robot has fewer kinds of scanners; more fans than this means that one changes all the time.
const MOST_FANS: usize = 32;
/// Stands for "straight up or down" where a direction over the floor is needed.
const STEEPEST: f64 = 1e-9;
/// Rays of a sound cone lie at most this far apart.
const CONE_STEP_RAD: f64 = std::f64::consts::PI / 180.0;

/// A ray, and meters of range for each cell of way over the floor.
struct Beam {
    ray: Ray,
    meters_per_cell: f64,
}

fn beam(place: &Place, map_from_sensor: &Pose3, direction: &nalgebra::Vector3<f64>) -> Beam {
    let origin = map_from_sensor.translation.vector;
    let direction = map_from_sensor.rotation * direction;
    let over_floor = direction.xy().norm();
    let along = if over_floor > STEEPEST { direction.xy() / over_floor } else { Vector::x() };
    let over_floor = over_floor.max(STEEPEST);
    let slope = if direction.z.abs() < LEVEL { 0.0 } else { direction.z / over_floor };
    Beam {
        ray: Ray {
            from: place.cells_from_map(Point2::new(origin.x, origin.y)),
            along: place.lattice_from_map.rotation * along,
            z: origin.z / place.resolution_m,
            slope,
        },
        meters_per_cell: place.resolution_m / over_floor,
    }
}

/// Heights that rays of a mount may meet: one for a level mount, all otherwise.
fn view_of(map_from_sensor: &Pose3, with_glass: bool) -> View {
    let up = map_from_sensor.rotation * nalgebra::Vector3::z();
    let z_m = map_from_sensor.translation.z;
    if up.xy().norm() < LEVEL {
        View { z_min_m: z_m, z_max_m: z_m, with_glass }
    } else {
        View { z_min_m: f64::NEG_INFINITY, z_max_m: f64::INFINITY, with_glass }
    }
}

impl Eyes {
    /// Distances along a fan of beams of light.
    pub fn beams(
        &mut self,
        place: &mut Place,
        map_from_sensor: &Pose3,
        fan: Fan,
        max_range_m: f64,
    ) -> &[f32] {
        let view = view_of(map_from_sensor, false);
        let number = self.look(place, view);
        let is_level = view.z_min_m == view.z_max_m;
        let fan_idx = self.fan(fan);
        // A level fan needs one pose: its beams differ by their direction only.
        let first =
            nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), fan.first_bearing_rad);
        let map_from_sensor = &(map_from_sensor * first);
        let ahead = beam(place, map_from_sensor, &nalgebra::Vector3::x());
        let left = place.lattice_from_map.rotation * (map_from_sensor.rotation * nalgebra::Vector3::y()).xy();
        let reach = max_range_m / place.resolution_m;
        self.shots.clear();
        self.scales.clear();
        for direction in &self.fans[fan_idx].1 {
            if is_level {
                let along = ahead.ray.along * direction.x + left * direction.y;
                self.shots.push((Ray { along, slope: 0.0, ..ahead.ray }, reach));
                self.scales.push(place.resolution_m);
            } else {
                let beam = beam(place, map_from_sensor, &direction.push(0.0));
                self.shots.push((beam.ray, max_range_m / beam.meters_per_cell));
                self.scales.push(beam.meters_per_cell);
            }
        }
        self.shoot(place, number);
        &self.ranges_m
    }

    /// Casts all shots; ranges come out in the same order.
    fn shoot(&mut self, place: &Place, lattice_number: usize) {
        self.ranges_m.clear();
        self.ranges_m.resize(self.shots.len(), f32::INFINITY);
        let (shots, movers, scales, ranges_m) = (&self.shots, &self.movers, &self.scales, &mut self.ranges_m);
        place.lattice(lattice_number).cast_all(shots, |number, hit| {
            let (ray, reach) = &shots[number];
            ranges_m[number] = (nearest(hit.map(|hit| hit.way), movers, ray, *reach) * scales[number]) as f32;
        });
    }

    /// Depths along the optical axis, row by row from the top.
    pub fn depths(
        &mut self,
        place: &mut Place,
        map_from_sensor: &Pose3,
        camera: &Intrinsics,
        max_range_m: f64,
    ) -> &[f32] {
        let all_heights = View { z_min_m: f64::NEG_INFINITY, z_max_m: f64::INFINITY, with_glass: false };
        let number = self.look(place, all_heights);
        self.shots.clear();
        self.scales.clear();
        for row in 0..camera.height {
            let up = (camera.center_px[1] - f64::from(row)) / camera.focal_px[1];
            for col in 0..camera.width {
                let left = (camera.center_px[0] - f64::from(col)) / camera.focal_px[0];
                let direction = nalgebra::Vector3::new(1.0, left, up);
                let length = direction.norm();
                let beam = beam(place, map_from_sensor, &(direction / length));
                let meters_of_depth = beam.meters_per_cell / length;
                self.shots.push((beam.ray, max_range_m / meters_of_depth));
                self.scales.push(meters_of_depth);
            }
        }
        self.shoot(place, number);
        &self.ranges_m
    }

    /// Nearest echo in each cone of a ring, from the transducer's face.
    pub fn cones(
        &mut self,
        place: &mut Place,
        map_from_sensor: &Pose3,
        ring: Ring<'_>,
        max_range_m: f64,
    ) -> &[f32] {
        let z_m = map_from_sensor.translation.z;
        let number = self.look(place, View { z_min_m: z_m, z_max_m: z_m, with_glass: true });
        let lattice = place.lattice(number);
        // An even number of steps, so that one ray is the axis.
        let n_steps = 2 * (ring.cone_rad / CONE_STEP_RAD / 2.0).ceil().max(1.0) as usize;
        let reach = max_range_m / place.resolution_m;
        self.ranges_m.clear();
        for &bearing_rad in ring.bearings_rad {
            let out = nalgebra::Vector3::new(bearing_rad.cos(), bearing_rad.sin(), 0.0) * ring.ring_radius_m;
            let face = map_from_sensor * nalgebra::Translation3::from(out);
            let mut shortest = f64::INFINITY;
            for step in 0..=n_steps {
                let off_axis_rad = ring.cone_rad * (step as f64 / n_steps as f64 - 0.5);
                let (sin, cos) = (bearing_rad + off_axis_rad).sin_cos();
                let beam = beam(place, &face, &nalgebra::Vector3::new(cos, sin, 0.0));
                let ray = Ray { slope: 0.0, ..beam.ray };
                shortest = shortest.min(echo(lattice, &self.movers, ray, reach).unwrap_or(f64::INFINITY));
            }
            self.ranges_m.push((shortest * place.resolution_m) as f32);
        }
        &self.ranges_m
    }

    /// Gets the lattice of a view and copies what moves in it.
    fn look(&mut self, place: &mut Place, view: View) -> usize {
        self.movers.clear();
        self.movers.extend(place.movers(view));
        place.prepare(view)
    }

    /// Directions of a fan, seen from its first beam; made once for each step and number.
    fn fan(&mut self, fan: Fan) -> usize {
        let shape = (fan.bearing_step_rad, fan.n_beams);
        self.fans.iter().position(|(known, _)| *known == shape).unwrap_or_else(|| {
            if self.fans.len() >= MOST_FANS {
                self.fans.clear();
            }
            let direction = |idx: usize| {
                let (sin, cos) = (fan.bearing_step_rad * idx as f64).sin_cos();
                Vector::new(cos, sin)
            };
            self.fans.push((shape, (0..fan.n_beams).map(direction).collect()));
            self.fans.len() - 1
        })
    }
}

/// The nearest of a static hit, what moves, and the floor; infinite beyond the reach.
fn nearest(fixed: Option<f64>, movers: &[Solid], ray: &Ray, reach: f64) -> f64 {
    let mut way = fixed.unwrap_or(f64::INFINITY);
    if ray.slope < 0.0 && ray.z > 0.0 {
        way = way.min(-ray.z / ray.slope);
    }
    for mover in movers {
        if let Some(hit) = mover.hit(ray) {
            way = way.min(hit);
        }
    }
    if way <= reach { way } else { f64::INFINITY }
}

#[cfg(test)]
mod tests;
