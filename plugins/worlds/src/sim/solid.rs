//! Upright solids: a footprint in the plane, from one height to another. Rays, distances and mirrors of them.
//!
//! Coordinates and heights share one unit of length, which is the caller's.

use nalgebra::{Point2, Vector2};

/// A point of the plane.
pub type Point = Point2<f64>;
/// A direction or offset in the plane.
pub type Vector = Vector2<f64>;

/// The outline of a solid on the floor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Footprint {
    /// A wall without thickness.
    Segment {
        /// One end.
        from: Point,
        /// The other end.
        to: Point,
    },
    /// A round column, a leg.
    Disc {
        /// Center.
        center: Point,
        /// Radius.
        radius: f64,
    },
    /// A turned rectangle.
    Rectangle {
        /// Center.
        center: Point,
        /// Unit vector along its first edge.
        axis: Vector,
        /// Half of its two edges.
        half: Vector,
    },
}

/// A footprint with heights and material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solid {
    /// Outline on the floor.
    pub footprint: Footprint,
    /// Lower face.
    pub z_min: f64,
    /// Upper face.
    pub z_max: f64,
    /// Light passes, sound is mirrored.
    pub is_glass: bool,
}

/// A ray over the plane that rises by `slope` per unit of way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub from: Point,
    /// Unit vector of its way over the plane.
    pub along: Vector,
    /// Height at the start.
    pub z: f64,
    /// Rise per unit of way over the plane.
    pub slope: f64,
}

impl Ray {
    /// A ray that keeps its height.
    pub fn level(from: Point, along: Vector, z: f64) -> Self {
        Self { from, along, z, slope: 0.0 }
    }

    /// The part of the way, if any, on which the ray is between two heights.
    pub fn between(&self, z_min: f64, z_max: f64) -> Option<(f64, f64)> {
        if self.slope == 0.0 {
            return (z_min..=z_max).contains(&self.z).then_some((f64::NEG_INFINITY, f64::INFINITY));
        }
        let (a, b) = ((z_min - self.z) / self.slope, (z_max - self.z) / self.slope);
        Some((a.min(b), a.max(b)))
    }
}

fn cross(a: Vector, b: Vector) -> f64 {
    a.x * b.y - a.y * b.x
}

impl Footprint {
    /// A box's outline.
    pub fn rectangle(center: Point, size: Vector, yaw_rad: f64) -> Self {
        Self::Rectangle { center, axis: Vector::new(yaw_rad.cos(), yaw_rad.sin()), half: size / 2.0 }
    }

    /// Center and radius of a disc around the footprint.
    pub fn bounding_disc(&self) -> (Point, f64) {
        match *self {
            Self::Segment { from, to } => (nalgebra::center(&from, &to), (to - from).norm() / 2.0),
            Self::Disc { center, radius } => (center, radius),
            Self::Rectangle { center, half, .. } => (center, half.norm()),
        }
    }

    /// Corners of the outline, one after the other; none for a disc.
    pub fn corners(&self) -> impl Iterator<Item = Point> + use<> {
        let (corners, n_corners) = match *self {
            Self::Segment { from, to } => ([from, to, from, from], 2),
            Self::Disc { center, .. } => ([center; 4], 0),
            Self::Rectangle { center, axis, half } => {
                let (u, v) = (axis * half.x, Vector::new(-axis.y, axis.x) * half.y);
                ([center - u - v, center + u - v, center + u + v, center - u + v], 4)
            }
        };
        corners.into_iter().take(n_corners)
    }

    /// Where a line enters and leaves the footprint, as ways along it; equal for a thin wall.
    fn crossing(&self, from: Point, along: Vector) -> Option<(f64, f64)> {
        match *self {
            Self::Segment { from: a, to: b } => {
                let edge = b - a;
                let across = cross(along, edge);
                let to_a = a - from;
                // A ray in the wall's own plane meets its edge, which has no width.
                if across == 0.0 {
                    return None;
                }
                let share = cross(to_a, along) / across;
                let way = cross(to_a, edge) / across;
                (-1e-12..=1.0 + 1e-12).contains(&share).then_some((way, way))
            }
            Self::Disc { center, radius } => {
                let to_center = center - from;
                let (middle, off) = (to_center.dot(&along), cross(along, to_center));
                let half = radius * radius - off * off;
                (half >= 0.0).then(|| (middle - half.sqrt(), middle + half.sqrt()))
            }
            Self::Rectangle { center, axis, half } => {
                let start = local(from - center, axis);
                let dir = local(along, axis);
                let mut span = (f64::NEG_INFINITY, f64::INFINITY);
                for (start, dir, half) in [(start.x, dir.x, half.x), (start.y, dir.y, half.y)] {
                    if dir == 0.0 {
                        if start.abs() > half {
                            return None;
                        }
                        continue;
                    }
                    let (a, b) = ((-half - start) / dir, (half - start) / dir);
                    span = (span.0.max(a.min(b)), span.1.min(a.max(b)));
                }
                (span.0 <= span.1).then_some(span)
            }
        }
    }

    /// Signed distance from a point, negative inside.
    pub fn distance(&self, point: Point) -> f64 {
        match *self {
            Self::Segment { from, to } => (point - nearest_on_segment(from, to, point)).norm(),
            Self::Disc { center, radius } => (point - center).norm() - radius,
            Self::Rectangle { center, axis, half } => {
                let beyond = local(point - center, axis).abs() - half;
                beyond.map(|b| b.max(0.0)).norm() + beyond.max().min(0.0)
            }
        }
    }

    /// The point of the footprint's outline or inside that is nearest to `point`.
    pub fn nearest(&self, point: Point) -> Point {
        match *self {
            Self::Segment { from, to } => nearest_on_segment(from, to, point),
            Self::Disc { center, radius } => {
                let out = point - center;
                center + out * (radius / out.norm().max(radius).max(f64::MIN_POSITIVE))
            }
            Self::Rectangle { center, axis, half } => {
                let inside = local(point - center, axis).zip_map(&half, |part, half| part.clamp(-half, half));
                center + axis * inside.x + Vector::new(-axis.y, axis.x) * inside.y
            }
        }
    }

    /// Unit normal of the outline where it is hit at `point`.
    pub fn normal(&self, point: Point) -> Vector {
        let normal = match *self {
            Self::Segment { from, to } => Vector::new(from.y - to.y, to.x - from.x),
            Self::Disc { center, .. } => point - center,
            Self::Rectangle { center, axis, half } => {
                let out = local(point - center, axis);
                if out.x.abs() - half.x > out.y.abs() - half.y { axis } else { Vector::new(-axis.y, axis.x) }
            }
        };
        normal / normal.norm().max(f64::MIN_POSITIVE)
    }
}

fn local(offset: Vector, axis: Vector) -> Vector {
    Vector::new(offset.dot(&axis), cross(axis, offset))
}

/// The point of a segment that is nearest to `point`.
pub fn nearest_on_segment(from: Point, to: Point, point: Point) -> Point {
    let edge = to - from;
    let share = ((point - from).dot(&edge) / edge.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    from + edge * share
}

impl Solid {
    /// Way over the plane to the first point where the ray is in the solid; zero when it starts inside.
    pub fn hit(&self, ray: &Ray) -> Option<f64> {
        let (low, high) = ray.between(self.z_min, self.z_max)?;
        let (enter, leave) = self.footprint.crossing(ray.from, ray.along)?;
        let (enter, leave) = (enter.max(low), leave.min(high));
        (leave >= 0.0 && enter <= leave).then(|| enter.max(0.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn solid(footprint: Footprint, z_min: f64, z_max: f64) -> Solid {
        Solid { footprint, z_min, z_max, is_glass: false }
    }

    fn level(x: f64, y: f64, dx: f64, dy: f64) -> Ray {
        Ray::level(Point::new(x, y), Vector::new(dx, dy).normalize(), 0.3)
    }

    #[test]
    fn a_wall_is_hit_from_both_sides_and_not_beside_its_ends() {
        let wall =
            solid(Footprint::Segment { from: Point::new(2.0, -1.0), to: Point::new(2.0, 1.0) }, 0.0, 2.0);
        assert_eq!(wall.hit(&level(0.0, 0.0, 1.0, 0.0)), Some(2.0));
        assert_eq!(wall.hit(&level(5.0, 0.5, -1.0, 0.0)), Some(3.0));
        assert_eq!(wall.hit(&level(0.0, 0.0, -1.0, 0.0)), None);
        assert_eq!(wall.hit(&level(0.0, 1.1, 1.0, 0.0)), None);
        assert!((wall.hit(&level(0.0, 0.0, 2.0, 1.0)).unwrap() - 5f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn discs_and_turned_boxes_are_entered_at_their_skin() {
        let disc = solid(Footprint::Disc { center: Point::new(3.0, 0.6), radius: 1.0 }, 0.0, 2.0);
        assert!((disc.hit(&level(0.0, 0.0, 1.0, 0.0)).unwrap() - 2.2).abs() < 1e-12);
        assert_eq!(disc.hit(&level(3.0, 0.5, 1.0, 0.0)), Some(0.0), "from inside");
        let diamond =
            Footprint::rectangle(Point::new(3.0, 0.0), Vector::new(2.0, 2.0), std::f64::consts::FRAC_PI_4);
        let hit = solid(diamond, 0.0, 2.0).hit(&level(0.0, 0.0, 1.0, 0.0)).unwrap();
        assert!((hit - (3.0 - 2f64.sqrt())).abs() < 1e-12);
        assert_eq!(solid(diamond, 0.0, 2.0).hit(&level(0.0, 1.5, 1.0, 0.0)), None);
    }

    #[test]
    fn a_table_top_is_missed_from_below_and_met_from_above() {
        let top = solid(Footprint::rectangle(Point::new(3.0, 0.0), Vector::new(2.0, 2.0), 0.0), 0.70, 0.75);
        assert_eq!(top.hit(&level(0.0, 0.0, 1.0, 0.0)), None);
        let down = Ray { z: 1.75, slope: -0.4, ..level(0.0, 0.0, 1.0, 0.0) };
        assert!((top.hit(&down).unwrap() - 2.5).abs() < 1e-12, "the upper face at x = 2.5");
        let up = Ray { z: 0.0, slope: 0.35, ..level(0.0, 0.0, 1.0, 0.0) };
        assert!((top.hit(&up).unwrap() - 2.0).abs() < 1e-12, "the side face at x = 2");
        let over = Ray { slope: -0.1, ..down };
        assert_eq!(top.hit(&over), None);
    }

    #[test]
    fn distances_are_signed_and_nearest_points_lie_on_the_outline() {
        let rectangle = Footprint::rectangle(Point::new(0.0, 0.0), Vector::new(4.0, 2.0), 0.0);
        for (x, y, expected) in [(5.0, 0.0, 3.0), (5.0, 5.0, 5.0), (1.0, 0.5, -0.5), (0.0, -3.0, 2.0)] {
            assert!((rectangle.distance(Point::new(x, y)) - expected).abs() < 1e-12, "{x} {y}");
        }
        assert_eq!(rectangle.nearest(Point::new(5.0, 0.5)), Point::new(2.0, 0.5));
        let disc = Footprint::Disc { center: Point::new(1.0, 0.0), radius: 0.5 };
        assert!((disc.nearest(Point::new(3.0, 0.0)) - Point::new(1.5, 0.0)).norm() < 1e-12);
        assert_eq!(disc.distance(Point::new(1.0, 0.0)), -0.5);
        assert_eq!(rectangle.normal(Point::new(2.0, 0.3)), Vector::new(1.0, 0.0));
        assert_eq!(rectangle.normal(Point::new(0.3, -1.0)), Vector::new(0.0, 1.0));
    }
}
