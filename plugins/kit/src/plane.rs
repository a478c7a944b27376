//! The plane that holds the most of a cloud of points: random sample consensus (Fischler and Bolles, *Random sample
//! consensus*, Communications of the ACM 24, 1981), then least squares over what lies near it.

use nalgebra::{Matrix3, SymmetricEigen, Vector3};
use rumbo_core::rng::{Rng, RngExt as _};

/// All points `p` with `normal · p = offset_m`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Of length 1.
    pub normal: Vector3<f64>,
    /// Distance from the origin along the normal, meters.
    pub offset_m: f64,
}

impl Plane {
    /// Distance of a point from the plane, on the normal's side positive, meters.
    pub fn height_m(&self, point_m: &Vector3<f64>) -> f64 {
        self.normal.dot(point_m) - self.offset_m
    }
}

/// What to look for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneSearch {
    /// So near a point belongs to a plane, meters.
    pub tolerance_m: f64,
    /// Triples of points that are tried.
    pub n_trials: usize,
    /// About where the normal points.
    pub about: Vector3<f64>,
    /// The normal is within this angle of `about`, radians.
    pub within_rad: f64,
}

/// A plane and how well it fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlaneFit {
    /// The plane; its normal is on the side of [`PlaneSearch::about`].
    pub plane: Plane,
    /// Points within the tolerance.
    pub n_near: usize,
    /// Root mean square of their distances, meters.
    pub deviation_m: f64,
}

/// Rounds of least squares; each takes the points near the plane of the round before.
const N_ROUNDS: usize = 5;

/// The plane with the most points near it; none where no triple of points lies on such a plane. Points must be finite.
pub fn largest_plane(points_m: &[Vector3<f64>], search: &PlaneSearch, rng: &mut Rng) -> Option<PlaneFit> {
    let about = search.about.try_normalize(0.0)?;
    let least_cos = search.within_rad.cos();
    let n_near = |plane: &Plane| {
        points_m.iter().filter(|point| plane.height_m(point).abs() <= search.tolerance_m).count()
    };
    let mut best: Option<(usize, Plane)> = None;
    for _ in 0..search.n_trials {
        let Some(plane) = through_three(points_m, &about, rng) else { continue };
        if plane.normal.dot(&about) < least_cos {
            continue;
        }
        let n = n_near(&plane);
        if best.is_none_or(|(most, _)| n > most) {
            best = Some((n, plane));
        }
    }
    let (_, mut plane) = best?;
    for _ in 0..N_ROUNDS {
        let near = points_m.iter().filter(|point| plane.height_m(point).abs() <= search.tolerance_m);
        let Some(refined) = least_squares(near, &about) else { break };
        if refined.normal.dot(&about) < least_cos {
            break;
        }
        plane = refined;
    }
    let near = points_m.iter().map(|point| plane.height_m(point));
    let near: Vec<f64> = near.filter(|height_m| height_m.abs() <= search.tolerance_m).collect();
    let deviation_m = (near.iter().map(|h| h * h).sum::<f64>() / near.len().max(1) as f64).sqrt();
    Some(PlaneFit { plane, n_near: near.len(), deviation_m })
}

fn through_three(points_m: &[Vector3<f64>], about: &Vector3<f64>, rng: &mut Rng) -> Option<Plane> {
    if points_m.len() < 3 {
        return None;
    }
    let mut any = || points_m.get(rng.random_range(0..points_m.len()));
    let (a, b, c) = (any()?, any()?, any()?);
    // Points on one line say nothing.
    let normal = (b - a).cross(&(c - a)).try_normalize(1e-9)?;
    Some(facing(normal, a, about))
}

/// The plane that is nearest to points: through their mean, across the direction in which they spread the least.
fn least_squares<'p>(
    points_m: impl Iterator<Item = &'p Vector3<f64>> + Clone,
    about: &Vector3<f64>,
) -> Option<Plane> {
    let n = points_m.clone().count();
    if n < 3 {
        return None;
    }
    let mean = points_m.clone().sum::<Vector3<f64>>() / n as f64;
    let spread = points_m.fold(Matrix3::zeros(), |sum, point| {
        let off = point - mean;
        sum + off * off.transpose()
    });
    let eigen = SymmetricEigen::new(spread);
    let least = eigen.eigenvalues.imin();
    let normal = eigen.eigenvectors.column(least).into_owned().try_normalize(0.0)?;
    Some(facing(normal, &mean, about))
}

fn facing(normal: Vector3<f64>, through: &Vector3<f64>, about: &Vector3<f64>) -> Plane {
    let normal = if normal.dot(about) < 0.0 { -normal } else { normal };
    Plane { normal, offset_m: normal.dot(through) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::rng::stream;

    /// A floor tilted by known angles with noise of a centimeter, a larger wall, and points anywhere.
    fn room(rng: &mut Rng) -> (Vec<Vector3<f64>>, Plane) {
        let normal = Vector3::new(0.1, -0.05, 1.0).normalize();
        let floor = Plane { normal, offset_m: -0.8 };
        let mut points = Vec::new();
        for _ in 0..2000 {
            let (x, y) = (rng.random_range(-2.0..2.0), rng.random_range(0.5..4.0));
            let noise_m: f64 = rng.random_range(-0.01..0.01);
            let z = (floor.offset_m + noise_m - normal.x * x - normal.y * y) / normal.z;
            points.push(Vector3::new(x, y, z));
        }
        for _ in 0..3000 {
            points.push(Vector3::new(rng.random_range(-2.0..2.0), 4.0, rng.random_range(-0.8..2.0)));
        }
        for _ in 0..1000 {
            let mut any = || rng.random_range(-2.0..3.0);
            points.push(Vector3::new(any(), any(), any()));
        }
        (points, floor)
    }

    const SEARCH: PlaneSearch = PlaneSearch {
        tolerance_m: 0.03,
        n_trials: 2000,
        about: Vector3::new(0.0, 0.0, 1.0),
        within_rad: 0.5,
    };

    #[test]
    fn the_floor_is_found_though_the_wall_is_larger() {
        for seed in 0..20 {
            let mut rng = stream(seed, "room");
            let (points, floor) = room(&mut rng);
            let fit = largest_plane(&points, &SEARCH, &mut rng).unwrap();
            let off_rad = fit.plane.normal.angle(&floor.normal);
            assert!(
                off_rad < 0.003 && (fit.plane.offset_m - floor.offset_m).abs() < 0.005,
                "{seed}: {fit:?}"
            );
            assert!((2000..2200).contains(&fit.n_near), "{fit:?}");
            // Evenly spread noise of ±1 cm has a deviation of 1 cm / √3; the points that are anywhere add some.
            assert!((0.0055..0.009).contains(&fit.deviation_m), "{fit:?}");
        }
    }

    #[test]
    fn the_normal_is_on_the_side_that_is_asked_for() {
        let mut rng = stream(1, "room");
        let (points, floor) = room(&mut rng);
        let upside_down = PlaneSearch { about: -SEARCH.about, ..SEARCH };
        let fit = largest_plane(&points, &upside_down, &mut rng).unwrap();
        assert!(fit.plane.normal.angle(&-floor.normal) < 0.003);
        assert!((fit.plane.offset_m + floor.offset_m).abs() < 0.005, "{fit:?}");
        let wall = PlaneSearch { about: Vector3::y(), ..SEARCH };
        let fit = largest_plane(&points, &wall, &mut rng).unwrap();
        assert!(fit.plane.normal.angle(&Vector3::y()) < 0.003 && (fit.plane.offset_m - 4.0).abs() < 0.005);
    }

    #[test]
    fn nothing_is_found_where_there_is_no_plane() {
        let mut rng = stream(1, "room");
        let line: Vec<Vector3<f64>> = (0..50).map(|k| Vector3::new(f64::from(k), 0.0, 0.0)).collect();
        for points in [&line[..0], &line[..2], &line] {
            assert_eq!(largest_plane(points, &SEARCH, &mut rng), None);
        }
        let (points, _) = room(&mut rng);
        let nowhere = PlaneSearch { about: Vector3::zeros(), ..SEARCH };
        assert_eq!(largest_plane(&points, &nowhere, &mut rng), None);
        // A cloud that only has a wall.
        let steep = PlaneSearch { within_rad: 0.1, ..SEARCH };
        let wall: Vec<_> = points.iter().filter(|point| point.y == 4.0).copied().collect();
        assert_eq!(largest_plane(&wall, &steep, &mut rng), None);
    }
}
