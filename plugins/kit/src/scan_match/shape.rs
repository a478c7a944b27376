//! Which way a scan cannot tell by its own shape, whatever the map it is laid on: along the walls of a bare corridor, around the
//! middle of a round room.
//!
//! The cells of a map do not show that: beams that graze a wall hit it farther apart than cells are wide, so that the wall is
//! drawn as a row of dots, and the noise of near walls makes cells of different strength. Both look like evidence along the wall.
//! So the scan itself is asked: each point tells the way across the straight line through its neighbors, and nothing along it
//! (Censi, *On achievable accuracy for range-finder localization*, ICRA 2007, for surfaces); a point on no straight line tells
//! both. The directions come from the sum of what all points tell, by the rule for degenerate directions of Zhang, Kaess, Singh
//! (ICRA 2016), less what noise in the lines pretends.

use super::linearized::Linearized;
use super::lines::{Line, lines_of};
use super::observability::{Observability, ObservabilitySettings};
use super::points::ScanPoints;
use nalgebra::{Matrix2, Matrix2x3, Matrix3, Vector2};

/// Fewer points than this that tell a direction are none; noise bends a line now and then.
const LEAST_POINTS: f64 = 1.0;
/// So many make sure of a place that may be a wrong one.
const PROOF_POINTS: f64 = 10.0;
/// Evidence that is no more than so many times what noise pretends is none.
const PRETENDED_TIMES: f64 = 3.0;
/// Where no direction is told by few points, so many of them may be left out.
const FEW_SHARE: f64 = 0.5 * WEAK_SHARE;
/// A direction that is told by so large a share of what the best one is, and by twice the points that it needs, is told for sure.
const SURE_RATIO: f64 = 0.01;
/// The end of a wall counts as so many points that tell the way along it.
const END_POINTS: f64 = 5.0;

/// Walls whose normals are less than 13 degrees apart are the same: the square of the cosine.
const SAME_WALL: f64 = 0.95;
/// A direction that so large a share of the points tells is told whichever of them count.
const TOLD_SHARE: f64 = 0.3;
/// A direction that a smaller share tells hangs on few of them.
const WEAK_SHARE: f64 = 0.1;

/// What points tell of x, y and yaw, and what of that the noise in their lines pretends.
#[derive(Debug, Clone, Copy, Default)]
struct Told {
    evidence: Matrix3<f64>,
    pretended: Matrix3<f64>,
}

/// A point of a scan, in the base frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapePoint {
    /// Place, meters.
    pub at: [f32; 2],
    /// The normal of the line through its neighbors, toward the sensor.
    pub normal: Option<[f32; 2]>,
    /// The wall on which it lies ends here.
    pub is_end: bool,
}

/// What is needed of a scan to say what it tells by itself; which of its points count depends on what they are laid on. It is not
/// kept of scans that tell all directions many times over.
#[derive(Debug, Clone, PartialEq)]
pub struct ScanShape {
    /// In order of bearing.
    points: Vec<ShapePoint>,
    extent_m: f64,
    is_weak: bool,
    /// No direction hangs on few points or on ends of walls.
    is_plenty: bool,
}

impl ScanShape {
    /// Of points in order of bearing around this sensor. `ends_wall` says of a point and the normal's projection at it whether the
    /// surface could be seen farther on and is not there.
    pub(super) fn of(
        points: &ScanPoints,
        sensor: [f32; 2],
        ends_wall: impl Fn(usize, &Matrix2<f64>) -> bool,
    ) -> Option<ScanShape> {
        let places: Vec<[f32; 2]> = points.iter().map(|[x, y, _]| [x, y]).collect();
        let extent_m = points.extent_m();
        let unless_told = |told: &Told, share: f64| {
            let many_times = ObservabilitySettings { floor_per_m2: share, ratio: 0.0 };
            Observability::unless_complete(&linearized(told, places.len()), extent_m, &many_times)
        };
        // Ends of walls only add to it, and take most of the time.
        let lines = lines_of(&places)?;
        let without_ends = told(&places, &lines, |_, _| false);
        unless_told(&without_ends, TOLD_SHARE)?;
        let is_plenty = unless_told(&without_ends, WEAK_SHARE).is_none();
        let mut shape = Vec::with_capacity(places.len());
        let told = told(&places, &lines, |idx, across| {
            let is_end = ends_wall(idx, across);
            let at = places.get(idx).copied().unwrap_or_default();
            shape.push(ShapePoint { at, normal: normal_of(across, at, sensor), is_end });
            is_end
        });
        unless_told(&told, TOLD_SHARE)?;
        let is_weak = unless_told(&told, WEAK_SHARE).is_some();
        Some(ScanShape { points: shape, extent_m, is_weak, is_plenty })
    }

    /// In order of bearing.
    pub fn points(&self) -> &[ShapePoint] {
        &self.points
    }

    /// Few of the points tell some direction.
    pub fn is_weak(&self) -> bool {
        self.is_weak
    }

    /// Directions, in the base frame, of which the scan tells something and nothing; none where it tells all of them.
    pub fn blind(&self) -> Option<Observability> {
        self.blind_where(|_| true)
    }

    /// The same of those points alone whose surface is known where the scan is laid: what is seen for the first time tells nothing
    /// of where the robot is. Nothing where none is.
    pub fn blind_where(&self, is_known: impl Fn(&ShapePoint) -> bool) -> Option<Observability> {
        let known = self.known(is_known);
        // What is told many times over is told without a few.
        let n_unknown = self.points.len() - known.len();
        if self.is_plenty && n_unknown as f64 <= FEW_SHARE * self.points.len() as f64 {
            return None;
        }
        let shape = self.taken_apart(&known, LEAST_POINTS)?;
        (!shape.is_complete() && !shape.is_empty()).then_some(shape)
    }

    /// Those points alone tell all directions, and none of them by a few only.
    pub fn proves_where(&self, is_known: impl Fn(&ShapePoint) -> bool) -> bool {
        let shape = self.taken_apart(&self.known(is_known), PROOF_POINTS);
        shape.is_some_and(|shape| shape.is_complete())
    }

    /// Directions of which this information of x, y and yaw says less than so much (1/m², yaw by the scan's extent), in the axes of the
    /// information; none where it says enough of all.
    pub fn untold_by(&self, information: &Matrix3<f64>, least_1_m2: f64) -> Option<Observability> {
        let evidence = Linearized { hessian: *information, weight: 1.0, ..Linearized::default() };
        let rule = ObservabilitySettings { floor_per_m2: least_1_m2, ratio: 0.0 };
        Observability::unless_complete(&evidence, self.extent_m, &rule)
    }

    fn known(&self, is_known: impl Fn(&ShapePoint) -> bool) -> Vec<&ShapePoint> {
        self.points.iter().filter(|point| is_known(point)).collect()
    }

    /// What these points tell by at least so many of them; nothing where there are no lines among them.
    fn taken_apart(&self, known: &[&ShapePoint], least_points: f64) -> Option<Observability> {
        let places: Vec<[f32; 2]> = known.iter().map(|point| point.at).collect();
        // Without what stands before a wall, the line at a point may be another one.
        let is_same = |normal: &[f32; 2], across: &Matrix2<f64>| {
            let normal = Vector2::from(*normal).cast::<f64>();
            normal.dot(&(across * normal)) > SAME_WALL
        };
        let ends_wall = |idx: usize, across: &Matrix2<f64>| {
            let normal = known.get(idx).filter(|point| point.is_end).and_then(|point| point.normal);
            normal.is_some_and(|normal| is_same(&normal, across))
        };
        let told = told(&places, &lines_of(&places)?, ends_wall);
        Some(taken_apart(&told, places.len(), self.extent_m, least_points))
    }
}

/// What is projected on, toward the sensor; none where nothing is.
fn normal_of(across: &Matrix2<f64>, at: [f32; 2], sensor: [f32; 2]) -> Option<[f32; 2]> {
    let [x, y] = [across[(0, 0)], across[(1, 1)]].map(|square| square.max(0.0).sqrt() as f32);
    let y = y.copysign(across[(0, 1)] as f32);
    let is_away = (sensor[0] - at[0]) * x + (sensor[1] - at[1]) * y < 0.0;
    (across.trace() > 0.5).then_some(if is_away { [-x, -y] } else { [x, y] })
}

fn linearized(told: &Told, n_points: usize) -> Linearized {
    Linearized { hessian: told.evidence, weight: n_points as f64, ..Linearized::default() }
}

/// Which directions are told by at least so many points, and by more than noise pretends.
fn taken_apart(told: &Told, n_points: usize, extent_m: f64, least_points: f64) -> Observability {
    let evidence = linearized(told, n_points);
    let floor_per_m2 = least_points / evidence.weight;
    let rule = ObservabilitySettings { floor_per_m2, ..ObservabilitySettings::default() };
    let mut shape = Observability::of(&evidence, extent_m, &rule);
    // Most scans tell everything, whatever noise pretends.
    if shape.evidence[0] >= (SURE_RATIO * shape.evidence[2]).max(2.0 * least_points) {
        return shape;
    }
    let noise = shape.evidence_of(&told.pretended);
    for (k, seen) in shape.seen.iter_mut().enumerate() {
        *seen &= shape.evidence[k] > PRETENDED_TIMES * noise[k];
    }
    shape
}

/// Sums over all points. `ends_wall` is asked of every point in turn.
fn told(
    points: &[[f32; 2]],
    lines: &[Option<Line>],
    mut ends_wall: impl FnMut(usize, &Matrix2<f64>) -> bool,
) -> Told {
    let mut told = Told::default();
    for (idx, ([x, y], line)) in points.iter().zip(lines).enumerate() {
        let arm = Matrix2x3::new(1.0, 0.0, -f64::from(*y), 0.0, 1.0, f64::from(*x));
        let is_end = ends_wall(idx, &line.map_or_else(Matrix2::zeros, |line| line.across));
        let Some(line) = line else {
            told.evidence += arm.transpose() * arm * 0.5;
            continue;
        };
        let along = Matrix2::identity() - line.across;
        let end = if is_end { END_POINTS } else { 0.0 };
        told.evidence += arm.transpose() * (line.across + along * end) * arm;
        told.pretended += arm.transpose() * along * arm * line.normal_rad2;
    }
    told
}
