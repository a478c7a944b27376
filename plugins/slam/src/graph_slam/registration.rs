//! Where was this scan taken, as seen from that one? Registration of surfaces.
//!
//! Segal, Haehnel, Thrun, "Generalized-ICP" (2009), in the plane: between a point and the nearest one of the reference
//! the distance counts by the noise of both across their surfaces, and hardly along them. Differs from the source:
//! pairs that disagree count less (Geman-McClure), pairs of surfaces that face different ways not at all, and
//! correspondences come from a table. Unlike matching against cells of a grid it has no cell size to lose accuracy by.

use super::nearest::NearestTable;
use super::surface::{SurfacePoint, Turn};
use nalgebra::{Matrix3, UnitComplex, Vector3};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use rumbo_kit::scan_match::{Observability, ScanShape, ShapePoint};

/// How surfaces are registered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RegistrationSettings {
    /// Noise of a point across its surface, meters.
    pub across_m: f64,
    /// How far a point may lie from its partner along the surface, meters.
    pub along_m: f64,
    /// Noise of a point that lies on no surface, meters.
    pub loose_m: f64,
    /// Pairs that are farther apart than this count for nothing at the end, meters.
    pub gate_m: f64,
    /// Deviations at which a pair counts a quarter.
    pub kernel_c: f64,
}

/// What is known before looking.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Expected<'a> {
    /// Where the scan is expected.
    pub reference_from_scan: Pose2,
    /// How surely, in the reference's axes; zero where nothing shall pull it there.
    pub information: Matrix3<f64>,
    /// Squared error, in units of that information, at which it pulls with half its weight: what is expected may be
    /// quite wrong.
    pub half_at: f64,
    /// Pairs may be so far apart at the beginning, meters.
    pub first_gate_m: f64,
    /// What the scan tells by its own shape: along directions that no point tells which lies on the reference, no pair counts.
    pub shape: Option<&'a ScanShape>,
    /// Of a direction on which pairs that agree fully say less than so many would, on surfaces that face it with the noise of every
    /// point, they are not believed where they would move a scan that has such a shape far; with zero they are, if there are any.
    pub least_pairs: f64,
}

/// A scan in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Registered {
    /// The scan's base in the reference's frame.
    pub reference_from_scan: Pose2,
    /// What the pairs say of x, y, turn, in the reference's axes; without what was known before.
    pub information: Matrix3<f64>,
    /// Share of the scan's points that have a partner.
    pub overlap: f64,
    /// Mean weight of these pairs: how well they agree.
    pub agreement: f64,
    /// Number of pairs.
    pub n_pairs: usize,
    /// Directions, in the reference's axes, that what both know does not tell; none where it tells all.
    pub blind: Option<Observability>,
}

impl Registered {
    /// How well the scan lies on the reference: share of its points that agree, 0 to 1.
    pub fn fit(&self) -> f64 {
        self.overlap * self.agreement
    }
}

/// Points are known to the reference where it has a point this near, shares of how far apart pairs may be at the beginning.
const KNOWN_SHARE: f64 = 0.5;

/// Where few points tell a direction, fewer pairs than this may be of other things: the back of a box and its front.
pub(crate) const LEAST_PAIRS: f64 = 2.0;
/// So few move a scan no farther than this beside where it would be without them, meters; how far they turn it is left to them.
const FEW_MOVE_M: f64 = 0.1;

const MOST_ROUNDS: usize = 25;
/// A smaller step is the last one, meters and radians.
const LEAST_STEP: f64 = 2e-4;

/// Finds the pose of `scan` in the reference from where it is expected.
pub(crate) fn register(
    reference: &NearestTable,
    scan: &[SurfacePoint],
    expected: &Expected<'_>,
    settings: &RegistrationSettings,
) -> Option<Registered> {
    let prior = &expected.reference_from_scan;
    let known_m = KNOWN_SHARE * expected.first_gate_m.max(settings.gate_m);
    let blind = expected.shape.and_then(|shape| shape.blind_where(known_to(reference, prior, known_m)));
    let found = register_but(blind, reference, scan, expected, settings)?;
    let Some(shape) = expected.shape.filter(|_| blind.is_none()) else { return Some(found) };
    let least_1_m2 = expected.least_pairs / (2.0 * settings.across_m * settings.across_m);
    let Some(untold) = shape.untold_by(&found.information, least_1_m2) else { return Some(found) };
    let untold = untold.turned(&found.reference_from_scan.rotation.inverse());
    // A scan that has no place without so few of its pairs has none.
    let held = register_but(Some(untold), reference, scan, expected, settings)?;
    let moved = held.reference_from_scan.inverse() * found.reference_from_scan;
    Some(if moved.translation.vector.norm() > FEW_MOVE_M { held } else { found })
}

/// Along directions, in the scan's axes, that cannot be told it is where it is expected.
fn register_but(
    blind: Option<Observability>,
    reference: &NearestTable,
    scan: &[SurfacePoint],
    expected: &Expected<'_>,
    settings: &RegistrationSettings,
) -> Option<Registered> {
    let prior = &expected.reference_from_scan;
    let mut pose = Vector3::new(prior.translation.x, prior.translation.y, prior.rotation.angle());
    let start = pose;
    let mut gate_m = expected.first_gate_m.max(settings.gate_m);
    let blind_at = |pose: &Vector3<f64>| blind.map(|blind| blind.turned(&UnitComplex::new(pose.z)));
    for round in 0..MOST_ROUNDS {
        let pull = Pull::at(reference, scan, &pose, gate_m, settings).told(blind_at(&pose));
        let mut off = pose - start;
        off.z = wrap_angle(off.z);
        let back = expected.information / (1.0 + off.dot(&(expected.information * off)) / expected.half_at);
        let hessian = pull.hessian + back;
        let gradient = pull.gradient + back * off;
        let damped = hessian + Matrix3::from_diagonal(&(hessian.diagonal() * 1e-6).add_scalar(1e-3));
        let step = -(damped.cholesky()?.solve(&gradient));
        if !step.iter().all(|v| v.is_finite()) || pull.n_pairs < 3 {
            return None;
        }
        pose += step;
        pose.z = wrap_angle(pose.z);
        let is_narrow = gate_m <= settings.gate_m;
        if is_narrow && round > 1 && step.amax() < LEAST_STEP {
            break;
        }
        gate_m = (gate_m * 0.7).max(settings.gate_m);
    }
    let pull = Pull::at(reference, scan, &pose, settings.gate_m, settings).told(blind_at(&pose));
    Some(Registered {
        reference_from_scan: pose2(pose.x, pose.y, pose.z),
        information: pull.hessian,
        overlap: pull.n_pairs as f64 / scan.len().max(1) as f64,
        agreement: pull.weights / pull.n_pairs.max(1) as f64,
        n_pairs: pull.n_pairs,
        blind: blind_at(&pose),
    })
}

/// Says of points of a scan that was taken here whether the reference has a point of the same surface within this distance.
fn known_to(
    reference: &NearestTable,
    reference_from_scan: &Pose2,
    within_m: f64,
) -> impl Fn(&ShapePoint) -> bool {
    let turn = Turn::new(reference_from_scan);
    move |point| {
        let at = turn.place(point.at);
        // Whether a wall ends there the reference cannot say: it may have seen no more of it.
        !point.is_end
            && reference.at(at).is_some_and(|near| {
                let is_same = point.normal.filter(|_| near.is_flat()).is_none_or(|normal| {
                    let normal = turn.direction(normal);
                    normal[0] * near.normal[0] + normal[1] * near.normal[1] >= LEAST_FACING
                });
                f64::from((near.at[0] - at[0]).hypot(near.at[1] - at[1])) <= within_m && is_same
            })
    }
}

/// Sums over all pairs at one pose.
#[derive(Debug, Clone, Copy)]
struct Pull {
    hessian: Matrix3<f64>,
    gradient: Vector3<f64>,
    weights: f64,
    n_pairs: usize,
}

impl Pull {
    /// Without what pairs say along directions that cannot be told.
    fn told(self, blind: Option<Observability>) -> Pull {
        let Some(blind) = blind else { return self };
        let (hessian, gradient) = blind.only_seen(&self.hessian, &self.gradient);
        Pull { hessian, gradient, ..self }
    }

    fn at(
        reference: &NearestTable,
        scan: &[SurfacePoint],
        pose: &Vector3<f64>,
        gate_m: f64,
        settings: &RegistrationSettings,
    ) -> Pull {
        let turn = Turn::new(&pose2(pose.x, pose.y, pose.z));
        let noise = Noise::new(settings);
        let (gate, c2) = ((gate_m * gate_m) as f32, (settings.kernel_c * settings.kernel_c) as f32);
        // Pairs far apart in the first rounds shall pull: the kernel is as wide as the gate.
        let widened = ((gate_m / settings.gate_m).powi(2) as f32).max(1.0);
        let mut sums = [0f32; 9];
        let (mut weights, mut n_pairs) = (0.0, 0);
        for point in scan {
            let moved = point.seen_from(&turn);
            let Some(partner) = reference.at(moved.at) else { continue };
            let [dx, dy] = [moved.at[0] - partner.at[0], moved.at[1] - partner.at[1]];
            let facing = moved.normal[0] * partner.normal[0] + moved.normal[1] * partner.normal[1];
            let is_other_way = moved.is_flat() && partner.is_flat() && facing < LEAST_FACING;
            if is_other_way || dx * dx + dy * dy > gate {
                continue;
            }
            let [a, b, d] = noise.information(&moved, partner);
            let (px, py) = (a * dx + b * dy, b * dx + d * dy);
            let chi2 = dx * px + dy * py;
            let weight = (c2 * widened / (c2 * widened + chi2)).powi(2);
            // How the point moves when the scan turns.
            let (tx, ty) = (-(moved.at[1] - pose.y as f32), moved.at[0] - pose.x as f32);
            let (ax, ay) = (a * tx + b * ty, b * tx + d * ty);
            for (sum, part) in
                sums.iter_mut().zip([a, b, ax, d, ay, tx * ax + ty * ay, px, py, tx * px + ty * py])
            {
                *sum += weight * part;
            }
            weights += f64::from(weight);
            n_pairs += 1;
        }
        let [xx, xy, xt, yy, yt, tt, gx, gy, gt] = sums.map(f64::from);
        let hessian = Matrix3::new(xx, xy, xt, xy, yy, yt, xt, yt, tt);
        Pull { hessian, gradient: Vector3::new(gx, gy, gt), weights, n_pairs }
    }
}

/// Surfaces that face more than 50 degrees apart are different ones.
const LEAST_FACING: f32 = 0.64;

struct Noise {
    across: f32,
    along: f32,
    loose: f32,
}

impl Noise {
    fn new(settings: &RegistrationSettings) -> Noise {
        let square = |v: f64| (v * v) as f32;
        let RegistrationSettings { across_m, along_m, loose_m, .. } = *settings;
        Noise { across: square(across_m), along: square(along_m), loose: square(loose_m) }
    }

    /// xx, xy, yy of a point's covariance.
    fn covariance(&self, point: &SurfacePoint) -> [f32; 3] {
        let [x, y] = point.normal;
        if !point.is_flat() {
            return [self.loose, 0.0, self.loose];
        }
        let across = self.across + point.variance_m2;
        let along = self.along.max(across);
        let more = across - along;
        [along + more * x * x, more * x * y, along + more * y * y]
    }

    /// xx, xy, yy of the inverse of the sum of both covariances.
    fn information(&self, a: &SurfacePoint, b: &SurfacePoint) -> [f32; 3] {
        let (a, b) = (self.covariance(a), self.covariance(b));
        let [xx, xy, yy] = [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
        let inverse = 1.0 / (xx * yy - xy * xy);
        [yy * inverse, -xy * inverse, xx * inverse]
    }
}
