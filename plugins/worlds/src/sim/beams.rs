//! What sensors see: fans of beams, depth pictures and sound cones, exact and without noise.

use rumbo_core::frames::{Point2, Pose3};
use rumbo_core::messages::Intrinsics;

use super::lattice::Lattice;
use super::place::{Place, View};
use super::solid::{Ray, Solid, Vector};
use super::sound::echo;
use super::terrain::Terrain;

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
fn view_of(place: &Place, map_from_sensor: &Pose3, with_glass: bool) -> View {
    if is_level(map_from_sensor) {
        place.view_at(map_from_sensor.translation.z, with_glass)
    } else {
        View { with_glass, ..View::ALL_HEIGHTS }
    }
}

fn is_level(map_from_sensor: &Pose3) -> bool {
    (map_from_sensor.rotation * nalgebra::Vector3::z()).xy().norm() < LEVEL
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
        let number = self.look(place, view_of(place, map_from_sensor, false));
        let is_level = is_level(map_from_sensor);
        let fan_idx = self.fan(fan);
        // A level fan needs one pose: its beams differ by their direction only.
        let first =
            nalgebra::UnitQuaternion::from_axis_angle(&nalgebra::Vector3::z_axis(), fan.first_bearing_rad);
        let map_from_sensor = &(map_from_sensor * first);
        let ahead = beam(place, map_from_sensor, &nalgebra::Vector3::x());
        let left = place.lattice_from_map.rotation * (map_from_sensor.rotation * nalgebra::Vector3::y()).xy();
        let reach = max_range_m / place.resolution_m;
        let directions = &self.fans[fan_idx].1;
        let level_ray = |idx: usize| {
            let along = ahead.ray.along * directions[idx].x + left * directions[idx].y;
            (Ray { along, slope: 0.0, ..ahead.ray }, reach)
        };
        let tilted_ray = |idx: usize| {
            let beam = beam(place, map_from_sensor, &directions[idx].push(0.0));
            (beam.ray, max_range_m / beam.meters_per_cell)
        };
        let lattice = place.lattice(number);
        let (movers, terrain) = (&self.movers, &place.terrain);
        let shoot = Shoot { lattice, movers, terrain, max_range_m, n_rays: fan.n_beams };
        if is_level {
            shoot.rays(level_ray, &mut self.ranges_m)
        } else {
            shoot.rays(tilted_ray, &mut self.ranges_m)
        }
        &self.ranges_m
    }

    /// Depths along the optical axis, row by row from the top.
    pub fn depths(
        &mut self,
        place: &mut Place,
        map_from_sensor: &Pose3,
        camera: &Intrinsics,
        max_range_m: f64,
    ) -> &[f32] {
        let number = self.look(place, View::ALL_HEIGHTS);
        let ray_of = |idx: usize| {
            let (row, col) = (idx / camera.width as usize, idx % camera.width as usize);
            let up = (camera.center_px[1] - row as f64) / camera.focal_px[1];
            let left = (camera.center_px[0] - col as f64) / camera.focal_px[0];
            let direction = nalgebra::Vector3::new(1.0, left, up);
            let length = direction.norm();
            let beam = beam(place, map_from_sensor, &(direction / length));
            (beam.ray, max_range_m * length / beam.meters_per_cell)
        };
        let n_rays = camera.width as usize * camera.height as usize;
        let (lattice, movers, terrain) = (place.lattice(number), &self.movers, &place.terrain);
        let shoot = Shoot { lattice, movers, terrain, max_range_m, n_rays };
        shoot.rays(ray_of, &mut self.ranges_m);
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
        let number = self.look(place, view_of(place, map_from_sensor, true));
        let lattice = place.lattice(number);
        let is_level = is_level(map_from_sensor);
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
                let (ray, way_per_cell) = if is_level {
                    (Ray { slope: 0.0, ..beam.ray }, 1.0)
                } else {
                    (beam.ray, beam.meters_per_cell / place.resolution_m)
                };
                let heard = echo(lattice, &self.movers, ray, reach / way_per_cell);
                // Ramps and steps return sound as walls do; from the plain floor it glances off.
                let raised = place.terrain.hit(&ray).filter(|way| *way <= reach / way_per_cell);
                for way in [heard, raised].into_iter().flatten() {
                    shortest = shortest.min(way * way_per_cell);
                }
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

/// Many rays into one lattice.
struct Shoot<'a> {
    lattice: &'a Lattice,
    movers: &'a [Solid],
    terrain: &'a Terrain,
    max_range_m: f64,
    n_rays: usize,
}

impl Shoot<'_> {
    /// Ranges of all rays; `ray_of` gives each with the reach, in cells of way, that stands for the largest range.
    fn rays(&self, ray_of: impl Fn(usize) -> (Ray, f64), ranges_m: &mut Vec<f32>) {
        ranges_m.clear();
        ranges_m.resize(self.n_rays, f32::INFINITY);
        self.lattice.cast_all(self.n_rays, ray_of, |number, ray, reach, hit| {
            let way = self.nearest(hit.map(|hit| hit.way), ray, reach);
            if way > 0.0 && way < f64::INFINITY {
                ranges_m[number] = (way * (self.max_range_m / reach)) as f32;
            } else {
                ranges_m[number] = way as f32;
            }
        });
    }

    /// The nearest of a static hit, what moves, and the floor; infinite beyond the reach.
    fn nearest(&self, fixed: Option<f64>, ray: &Ray, reach: f64) -> f64 {
        let mut way = fixed.unwrap_or(f64::INFINITY);
        if ray.slope < 0.0 && ray.z > 0.0 {
            way = way.min(-ray.z / ray.slope);
        }
        for mover in self.movers {
            if let Some(hit) = mover.hit(ray) {
                way = way.min(hit);
            }
        }
        way = way.min(self.terrain.hit(ray).unwrap_or(f64::INFINITY));
        if way <= reach { way } else { f64::INFINITY }
    }
}

#[cfg(test)]
mod tests;
