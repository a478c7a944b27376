//! How far a hull is from the nearest thing, exactly: rings of cells around it, empty stretches skipped.
//! All lengths here are in cells.

use rumbo_core::robot::Hull;

use super::lattice::{Kind, Lattice};
use super::solid::{Footprint, Point, Vector, nearest_on_segment};

/// A robot's outline, placed.
#[derive(Debug, Clone)]
pub struct PlacedHull {
    /// Corners, counter-clockwise; none for a disc.
    corners: Vec<Point>,
    center: Point,
    outer: f64,
}

/// The nearest thing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Distance from the hull, negative where it overlaps.
    pub distance: f64,
    /// Where on the thing.
    pub at: Point,
}

impl PlacedHull {
    /// A hull that is not placed yet.
    pub fn new(hull: &Hull) -> Self {
        let corners = if let Hull::Polygon(corners) = hull { corners.clone() } else { Vec::new() };
        Self { corners, center: Point::origin(), outer: hull.outer_radius_m() }
    }

    /// Puts the hull somewhere, keeping its memory: `place` maps the base frame (meters) to cells.
    pub fn put(&mut self, hull: &Hull, cells_per_meter: f64, place: impl Fn(Point) -> Point) {
        self.center = place(Point::origin());
        self.outer = hull.outer_radius_m() * cells_per_meter;
        if let Hull::Polygon(corners) = hull {
            self.corners.clear();
            self.corners.extend(corners.iter().map(|corner| place(*corner)));
        }
    }

    /// Signed distance to a footprint, and where on it.
    pub fn to(&self, footprint: &Footprint) -> Nearest {
        if self.corners.is_empty() {
            let distance = footprint.distance(self.center) - self.outer;
            return Nearest { distance, at: footprint.nearest(self.center) };
        }
        if let Footprint::Disc { center, radius } = *footprint {
            let (distance, at) = self.to_point(center);
            let out = at - center;
            return Nearest {
                distance: distance - radius,
                at: center + out * (radius / out.norm().max(radius).max(f64::MIN_POSITIVE)),
            };
        }
        self.to_outline(footprint)
    }

    fn edges(&self) -> impl Iterator<Item = (Point, Point)> {
        self.corners.iter().copied().zip(self.corners.iter().copied().cycle().skip(1))
    }

    /// Signed distance from a point to the hull, and the nearest point of the hull's outline.
    fn to_point(&self, point: Point) -> (f64, Point) {
        let (mut nearest, mut at, mut inside) = (f64::INFINITY, point, false);
        for (a, b) in self.edges() {
            let foot = nearest_on_segment(a, b, point);
            if (foot - point).norm() < nearest {
                (nearest, at) = ((foot - point).norm(), foot);
            }
            if (a.y > point.y) != (b.y > point.y)
                && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
            {
                inside = !inside;
            }
        }
        (if inside { -nearest } else { nearest }, at)
    }

    /// Between straight outlines the smallest distance is at a corner of one of them, unless they cross.
    fn to_outline(&self, footprint: &Footprint) -> Nearest {
        let mut best = Nearest { distance: f64::INFINITY, at: self.center };
        let mut take = |distance: f64, at: Point| {
            if distance < best.distance {
                best = Nearest { distance, at };
            }
        };
        for corner in footprint.corners() {
            take(self.to_point(corner).0, corner);
        }
        for corner in &self.corners {
            take(footprint.distance(*corner), footprint.nearest(*corner));
        }
        let (first, last) =
            (footprint.corners(), footprint.corners().skip(1).chain(footprint.corners().take(1)));
        for (from, to) in first.zip(last) {
            for (a, b) in self.edges() {
                if let Some(at) = meeting(a, b, from, to) {
                    take(0.0, at);
                }
            }
        }
        best
    }
}

/// Where two segments cross.
fn meeting(a: Point, b: Point, c: Point, d: Point) -> Option<Point> {
    let cross = |u: Vector, v: Vector| u.x * v.y - u.y * v.x;
    let across = cross(b - a, d - c);
    if across == 0.0 {
        return None;
    }
    let (along_a, along_c) = (cross(c - a, d - c) / across, cross(c - a, b - a) / across);
    ((0.0..=1.0).contains(&along_a) && (0.0..=1.0).contains(&along_c)).then(|| a + (b - a) * along_a)
}

/// The square of a wall's cell.
fn cell_square(col: i64, row: i64) -> Footprint {
    Footprint::Rectangle {
        center: Point::new(col as f64 + 0.5, row as f64 + 0.5),
        axis: Vector::new(1.0, 0.0),
        half: Vector::new(0.5, 0.5),
    }
}

impl Lattice {
    /// Calls `visit` with footprint and heights of everything that may be nearer to the hull than the distance `visit` last
    /// returned; nearer rings of cells come first.
    pub fn around(&self, hull: &PlacedHull, mut visit: impl FnMut(&Footprint, [f64; 2]) -> f64) {
        let (col, row) = (hull.center.x.floor() as i64, hull.center.y.floor() as i64);
        let (width, height) = (self.width as i64, self.height as i64);
        let inside = (0..width).contains(&col) && (0..height).contains(&row);
        let first = if inside { self.free_rings(self.cell(col as i32, row as i32)) as i64 } else { 0 };
        let last = [col, width - 1 - col, row, height - 1 - row].map(i64::abs).into_iter().max().unwrap_or(0);
        let mut best = f64::INFINITY;
        for ring in first..=last {
            // The ring's cells are at least ring - 1 from the center, and the hull reaches out by its outer radius.
            if (ring - 1) as f64 - hull.outer > best {
                return;
            }
            let sides = [
                (row - ring, col - ring, col + ring, true),
                (row + ring, col - ring, col + ring, true),
                (col - ring, row - ring + 1, row + ring - 1, false),
                (col + ring, row - ring + 1, row + ring - 1, false),
            ];
            let n_sides = if ring == 0 { 1 } else { 4 };
            for &(line, from, to, is_row) in &sides[..n_sides] {
                best = self.along_side(line, from, to, is_row, best, &mut visit);
            }
        }
    }

    /// One side of a ring; empty squares are leapt over.
    fn along_side(
        &self,
        line: i64,
        from: i64,
        to: i64,
        is_row: bool,
        mut best: f64,
        visit: &mut impl FnMut(&Footprint, [f64; 2]) -> f64,
    ) -> f64 {
        let (lines, length) = if is_row { (self.height, self.width) } else { (self.width, self.height) };
        if !(0..lines as i64).contains(&line) {
            return best;
        }
        let mut at = from.max(0);
        while at <= to.min(length as i64 - 1) {
            let (col, row) = if is_row { (at, line) } else { (line, at) };
            let cell = self.cell(col as i32, row as i32);
            let leap = self.leap[0][cell];
            if leap > 0 {
                at += i64::from(leap);
                continue;
            }
            if matches!(self.kind(cell), Kind::Wall | Kind::WalledAndListed) {
                best = visit(&cell_square(col, row), [0.0, self.wall_height]);
            }
            for &solid in self.solids_in(cell) {
                let solid = &self.solids[solid as usize];
                best = visit(&solid.footprint, [solid.z_min, solid.z_max]);
            }
            at += 1;
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    use super::*;
    use crate::sim::solid::Solid;

    fn nearest(lattice: &Lattice, hull: &PlacedHull) -> f64 {
        let mut best = f64::INFINITY;
        lattice.around(hull, |footprint, _| {
            best = best.min(hull.to(footprint).distance);
            best
        });
        best
    }

    fn disc(radius: f64, at: Point) -> PlacedHull {
        let hull = Hull::Disc { radius_m: radius };
        let mut placed = PlacedHull::new(&hull);
        placed.put(&hull, 1.0, |point| at + point.coords);
        placed
    }

    /// The slow twin measures every cell and every solid.
    #[test]
    fn rings_find_the_nearest_of_all() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for world in 0..40 {
            let size = rng.random_range(6..70usize);
            let share = [0.0, 0.001, 0.02, 0.2][world % 4];
            let walls: Vec<bool> = (0..size * size).map(|_| rng.random_bool(share)).collect();
            let mut any = |low: f64| {
                Point::new(rng.random_range(low..size as f64 - low), rng.random_range(low..size as f64 - low))
            };
            let mut footprints = Vec::new();
            for _ in 0..world % 3 {
                footprints.push(Footprint::Segment { from: any(0.0), to: any(0.0) });
            }
            if world % 2 == 1 {
                footprints.push(Footprint::Disc { center: any(2.0), radius: 1.5 });
            }
            let upright = |footprint| Solid { footprint, z_min: 0.0, z_max: 1.0, is_glass: false };
            let solids = footprints.into_iter().map(upright).collect();
            let lattice = Lattice::new((size, size), 1.0, solids, |col, row| walls[row * size + col]);
            for shot in 0..60 {
                let at = Point::new(
                    rng.random_range(-4.0..size as f64 + 4.0),
                    rng.random_range(-4.0..size as f64 + 4.0),
                );
                let hull = if shot % 2 == 0 { disc(1.7, at) } else { bar(at, rng.random_range(-3.0..3.0)) };
                let cells = (0..size * size).filter(|&cell| walls[cell]);
                let slow = cells
                    .map(|cell| cell_square((cell % size) as i64, (cell / size) as i64))
                    .chain(lattice.solids.iter().map(|solid| solid.footprint))
                    .map(|footprint| hull.to(&footprint).distance)
                    .fold(f64::INFINITY, f64::min);
                let fast = nearest(&lattice, &hull);
                assert!(
                    fast == slow || (fast - slow).abs() < 1e-12,
                    "world {world}: {fast} but {slow} at {at}"
                );
            }
        }
    }

    /// A bar of 4 by 1 around the base.
    fn bar(at: Point, yaw_rad: f64) -> PlacedHull {
        let hull =
            Hull::Polygon([[-1.0, -0.5], [3.0, -0.5], [3.0, 0.5], [-1.0, 0.5]].map(Point::from).to_vec());
        let mut placed = PlacedHull::new(&hull);
        placed.put(&hull, 1.0, |point| at + nalgebra::Rotation2::new(yaw_rad) * point.coords);
        placed
    }

    #[test]
    fn a_bar_is_measured_from_its_hull_by_hand() {
        let hull = bar(Point::new(0.0, 0.0), 0.0);
        let wall = Footprint::Segment { from: Point::new(5.0, -9.0), to: Point::new(5.0, 9.0) };
        assert_eq!(hull.to(&wall).distance, 2.0);
        let turned = bar(Point::new(0.0, 0.0), std::f64::consts::PI);
        assert!((turned.to(&wall).distance - 4.0).abs() < 1e-12);
        let through = Footprint::Segment { from: Point::new(1.0, -9.0), to: Point::new(1.0, 9.0) };
        assert!(hull.to(&through).distance <= 0.0);
        let column = Footprint::Disc { center: Point::new(6.0, 4.5), radius: 1.0 };
        let nearest = hull.to(&column);
        assert!((nearest.distance - 4.0).abs() < 1e-12, "corner (3, 0.5) to (6, 4.5) is 5");
        assert!((nearest.at - Point::new(5.4, 3.7)).norm() < 1e-12);
        let inside = Footprint::Disc { center: Point::new(1.0, 0.0), radius: 0.1 };
        assert!((hull.to(&inside).distance + 0.6).abs() < 1e-12);
    }

    #[test]
    fn a_disc_is_measured_from_its_rim() {
        let wall = Footprint::Segment { from: Point::new(5.0, -9.0), to: Point::new(5.0, 9.0) };
        assert_eq!(
            disc(2.0, Point::new(0.0, 0.0)).to(&wall),
            Nearest { distance: 3.0, at: Point::new(5.0, 0.0) }
        );
        assert_eq!(disc(2.0, Point::new(4.0, 0.0)).to(&wall).distance, -1.0);
    }
}
