//! Raised floor: ramps and steps. How high it is, how high a wheel stands on it, where a ray meets it.
//!
//! A patch of raised floor is a rectangle with a plane on top, solid below. Everything here is in closed form.

use rumbo_core::frames::Pose2;
use rumbo_kit::world_file::{Ramp, WorldScene};

use super::solid::{Point, Ray, Vector};

/// A ramp or step in one frame and one unit of length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Patch {
    center: Point,
    axis: Vector,
    half: Vector,
    /// Height in the middle.
    z_middle: f64,
    /// Rise per unit of way along the axis.
    slope: f64,
}

impl Patch {
    fn of(ramp: &Ramp) -> Self {
        Self {
            center: ramp.center.into(),
            axis: Vector::new(ramp.yaw_rad.cos(), ramp.yaw_rad.sin()),
            half: Vector::from(ramp.size) / 2.0,
            z_middle: (ramp.z_from_m + ramp.z_to_m) / 2.0,
            slope: (ramp.z_to_m - ramp.z_from_m) / ramp.size[0],
        }
    }

    /// The same patch in another frame, with lengths in another unit.
    fn seen_from(&self, frame_from_map: &Pose2, units_per_m: f64) -> Self {
        Self {
            center: (frame_from_map * self.center) * units_per_m,
            axis: frame_from_map.rotation * self.axis,
            half: self.half * units_per_m,
            z_middle: self.z_middle * units_per_m,
            slope: self.slope,
        }
    }

    /// A point or direction along the patch's own axes.
    fn local(&self, offset: Vector) -> Vector {
        Vector::new(offset.dot(&self.axis), self.axis.x * offset.y - self.axis.y * offset.x)
    }

    /// The patch's corners, counter-clockwise.
    fn corners(&self) -> [Point; 4] {
        let (u, v) = (self.axis * self.half.x, Vector::new(-self.axis.y, self.axis.x) * self.half.y);
        [self.center - u - v, self.center + u - v, self.center + u + v, self.center - u + v]
    }

    /// Height of the top over a point; `None` beside the patch.
    fn height(&self, point: Point) -> Option<f64> {
        let at = self.local(point - self.center);
        let is_inside = at.x.abs() <= self.half.x && at.y.abs() <= self.half.y;
        is_inside.then_some(self.z_middle + self.slope * at.x)
    }

    /// Height of the middle of a ball that rests on the patch over a point; `None` out of its reach. The sum of the plane's
    /// height and the ball's is concave, so its greatest value is where its free maximum lies, moved into the rectangle.
    fn ball_center(&self, point: Point, radius: f64) -> Option<f64> {
        let at = self.local(point - self.center);
        let across = at.y.clamp(-self.half.y, self.half.y) - at.y;
        let cut = radius * radius - across * across;
        if cut < 0.0 {
            return None;
        }
        let free = at.x + cut.sqrt() * self.slope / self.slope.hypot(1.0);
        let along = free.clamp(-self.half.x, self.half.x);
        let rest = cut - (along - at.x) * (along - at.x);
        (rest >= 0.0).then(|| self.z_middle + self.slope * along + rest.sqrt())
    }

    /// Way to where a ray enters the patch; 0 from inside.
    fn hit(&self, ray: &Ray) -> Option<f64> {
        let (from, along) = (self.local(ray.from - self.center), self.local(ray.along));
        let mut span = (0.0f64, f64::INFINITY);
        for (from, along, half) in [(from.x, along.x, self.half.x), (from.y, along.y, self.half.y)] {
            if along == 0.0 {
                if from.abs() > half {
                    return None;
                }
                continue;
            }
            let (a, b) = ((-half - from) / along, (half - from) / along);
            span = (span.0.max(a.min(b)), span.1.min(a.max(b)));
        }
        let over_top = ray.z - self.z_middle - self.slope * from.x;
        let gains = ray.slope - self.slope * along.x;
        if gains == 0.0 {
            if over_top > 0.0 {
                return None;
            }
        } else if gains < 0.0 {
            span.0 = span.0.max(-over_top / gains);
        } else {
            span.1 = span.1.min(-over_top / gains);
        }
        (span.0 <= span.1).then_some(span.0)
    }
}

/// All raised floor of a place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Terrain {
    /// In the map, meters.
    patches: Vec<Patch>,
    /// In the lattice, cells.
    in_cells: Vec<Patch>,
}

/// Edges are looked at in pieces of at most this length, meters.
const PIECE_M: f64 = 0.02;
/// Both sides of an edge are looked at this far from it, meters.
const BESIDE_M: f64 = 1e-3;

impl Terrain {
    /// The raised floor of a scene, for rays in a lattice.
    pub fn new(scene: &WorldScene, lattice_from_map: &Pose2, resolution_m: f64) -> Self {
        let patches: Vec<Patch> = scene.ramps.iter().map(Patch::of).collect();
        let in_cells =
            patches.iter().map(|patch| patch.seen_from(lattice_from_map, 1.0 / resolution_m)).collect();
        Self { patches, in_cells }
    }

    /// The floor is level everywhere.
    pub fn is_flat(&self) -> bool {
        self.patches.is_empty()
    }

    /// Height of the floor over a point of the map, meters.
    pub fn height_m(&self, point: Point) -> f64 {
        self.patches.iter().filter_map(|patch| patch.height(point)).fold(0.0, f64::max)
    }

    /// Height of the middle of a ball on the floor over a point of the map, meters.
    pub fn ball_center_m(&self, point: Point, radius_m: f64) -> f64 {
        self.patches.iter().filter_map(|patch| patch.ball_center(point, radius_m)).fold(radius_m, f64::max)
    }

    /// Way, in cells, to where a ray in the lattice meets raised floor.
    pub fn hit(&self, ray: &Ray) -> Option<f64> {
        self.in_cells.iter().filter_map(|patch| patch.hit(ray)).reduce(f64::min)
    }

    /// Edges that stop a robot: where the floor changes by more than `max_step_m`, and all edges of what is steeper than
    /// `max_slope_rad`. In the map, meters; exact to 2 cm along an edge.
    pub fn barriers(&self, max_step_m: f64, max_slope_rad: f64) -> Vec<[Point; 2]> {
        let mut barriers = Vec::new();
        for patch in &self.patches {
            let is_too_steep = patch.slope.abs() > max_slope_rad.tan() + 1e-9;
            let corners = patch.corners();
            for idx in 0..4 {
                let (from, to) = (corners[idx], corners[(idx + 1) % 4]);
                let edge = to - from;
                let out = Vector::new(edge.y, -edge.x).normalize() * BESIDE_M;
                let n_pieces = (edge.norm() / PIECE_M).ceil().max(1.0) as usize;
                let bars = |piece: usize| {
                    let at = from + edge * ((piece as f64 + 0.5) / n_pieces as f64);
                    let rise_m = self.height_m(at - out) - self.height_m(at + out);
                    is_too_steep || rise_m.abs() > max_step_m + 1e-9
                };
                runs(n_pieces, bars, |first, end| {
                    let at = |piece: usize| from + edge * (piece as f64 / n_pieces as f64);
                    barriers.push([at(first), at(end)]);
                });
            }
        }
        barriers
    }
}

/// Calls `run(first, end)` for each unbroken row of numbers below `n` for which `holds`.
fn runs(n: usize, holds: impl Fn(usize) -> bool, mut run: impl FnMut(usize, usize)) {
    let mut first = None;
    for number in 0..=n {
        match (first, number < n && holds(number)) {
            (None, true) => first = Some(number),
            (Some(begun), false) => {
                run(begun, number);
                first = None;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
