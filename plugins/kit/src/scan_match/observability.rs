//! Which directions a scan says nothing about: along a corridor, in open space, around a round room.

use super::covariance::moved;
use super::linearized::Linearized;
use super::step::difference;
use nalgebra::{Matrix3, SymmetricEigen, UnitComplex, Vector3};
use rumbo_core::frames::Pose2;

/// When a direction counts as not seen (section of its name in Zhang, Kaess, Singh, ICRA 2016: degeneracy).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ObservabilitySettings {
    /// Less than this share of the best seen direction.
    pub ratio: f64,
    /// Or less than this a point, 1/m².
    pub floor_per_m2: f64,
}

impl Default for ObservabilitySettings {
    fn default() -> Self {
        ObservabilitySettings { ratio: 1e-3, floor_per_m2: 1e-6 }
    }
}

/// The axes that directions without evidence mostly lie along.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BlindAxes {
    /// Along x of the map.
    pub x: bool,
    /// Along y of the map.
    pub y: bool,
    /// The heading.
    pub yaw: bool,
}

/// Directions of a scan's evidence and how strong it is, with yaw scaled to lengths.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Observability {
    /// Meters a radian of yaw: the scan's extent (rho). D is 1, 1, 1 / rho.
    pub extent_m: f64,
    /// Eigenvalues of D H D, ascending, 1/m².
    pub evidence: Vector3<f64>,
    /// Its eigenvectors as columns.
    pub directions: Matrix3<f64>,
    /// Which of them the scan sees.
    pub seen: [bool; 3],
}

impl Observability {
    /// Takes the evidence of a scan apart.
    pub fn of(linearized: &Linearized, extent_m: f64, settings: &ObservabilitySettings) -> Observability {
        let scaled = scaled(&linearized.hessian, extent_m);
        let eigen = SymmetricEigen::new(scaled);
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let evidence = Vector3::from_fn(|k, _| eigen.eigenvalues[order[k]].max(0.0));
        let directions = Matrix3::from_fn(|row, k| eigen.eigenvectors[(row, order[k])]);
        let least = (settings.ratio * evidence[2]).max(settings.floor_per_m2 * linearized.weight);
        let seen = [0, 1, 2].map(|k| evidence[k] >= least && evidence[k] > 0.0);
        Observability { extent_m, evidence, directions, seen }
    }

    /// The same, but nothing where every direction is seen for sure: told from the determinant, without taking the
    /// evidence apart.
    pub fn unless_complete(
        linearized: &Linearized,
        extent_m: f64,
        settings: &ObservabilitySettings,
    ) -> Option<Observability> {
        let scaled = scaled(&linearized.hessian, extent_m);
        let trace = scaled.trace();
        // The least eigenvalue is the determinant over the product of the others, which is at most a quarter of the
        // square of the trace; the largest is at most the trace.
        let at_least = 4.0 * scaled.determinant() / (trace * trace);
        let enough = (settings.ratio * trace).max(settings.floor_per_m2 * linearized.weight);
        if at_least > enough {
            return None;
        }
        let found = Observability::of(linearized, extent_m, settings);
        (!found.is_complete()).then_some(found)
    }

    /// The same directions as seen from axes in which these are turned.
    pub fn turned(&self, turn: &UnitComplex<f64>) -> Observability {
        let mut axes = Matrix3::identity();
        axes.fixed_view_mut::<2, 2>(0, 0).copy_from(turn.to_rotation_matrix().matrix());
        Observability { directions: axes * self.directions, ..*self }
    }

    /// What other evidence says along each direction, 1/m².
    pub(super) fn evidence_of(&self, hessian: &Matrix3<f64>) -> Vector3<f64> {
        let scaled = scaled(hessian, self.extent_m);
        Vector3::from_fn(|k, _| {
            let direction = self.directions.column(k);
            direction.dot(&(scaled * direction))
        })
    }

    /// Every direction is seen.
    pub fn is_complete(&self) -> bool {
        self.seen == [true; 3]
    }

    /// No direction is seen.
    pub fn is_empty(&self) -> bool {
        self.seen == [false; 3]
    }

    /// D as a vector.
    fn scale(&self) -> Vector3<f64> {
        Vector3::new(1.0, 1.0, 1.0 / self.extent_m)
    }

    /// `D Σ factor(k) v_k v_k^T D`.
    pub(super) fn compose(&self, factor: impl Fn(usize) -> f64) -> Matrix3<f64> {
        let scale = Matrix3::from_diagonal(&self.scale());
        let factors = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| factor(k)));
        scale * self.directions * factors * self.directions.transpose() * scale
    }

    /// What of a difference of poses lies along directions that are seen.
    pub fn seen_part(&self, difference: &Vector3<f64>) -> Vector3<f64> {
        let scale = self.scale();
        let scaled = difference.component_div(&scale);
        let mut sum = Vector3::zeros();
        for (direction, _) in self.directions.column_iter().zip(self.seen).filter(|(_, seen)| *seen) {
            sum += direction * direction.dot(&scaled);
        }
        sum.component_mul(&scale)
    }

    /// A pose, but along directions that are not seen where it was expected.
    pub fn held(&self, expected: &Pose2, pose: &Pose2) -> Pose2 {
        if self.is_complete() { *pose } else { moved(expected, &self.seen_part(&difference(expected, pose))) }
    }

    /// Onto what is seen, with yaw scaled to lengths (P).
    fn projection(&self) -> Matrix3<f64> {
        let kept = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| f64::from(u8::from(self.seen[k]))));
        self.directions * kept * self.directions.transpose()
    }

    /// The evidence without what looks like evidence along directions that are not seen: `D^-1 Σ_seen λ v v^T D^-1` and
    /// `D^-1 Σ_seen v v^T D b`.
    pub(super) fn seen_evidence(&self, linearized: &Linearized) -> (Matrix3<f64>, Vector3<f64>) {
        self.only_seen(&linearized.hessian, &linearized.descent)
    }

    /// The same of other evidence, which these directions need not take apart: `D^-1 P D H D P D^-1` and `D^-1 P D b`, where P
    /// projects on what is seen.
    pub fn only_seen(&self, hessian: &Matrix3<f64>, descent: &Vector3<f64>) -> (Matrix3<f64>, Vector3<f64>) {
        if self.is_complete() {
            return (*hessian, *descent);
        }
        let inverse = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, self.extent_m));
        let project = self.projection();
        let within = project * scaled(hessian, self.extent_m) * project;
        let along = project * descent.component_mul(&self.scale());
        (inverse * within * inverse, inverse * along)
    }

    /// One along each direction that is not seen, so that a system that knows nothing of them can be solved.
    pub(super) fn blind_identity(&self) -> Matrix3<f64> {
        let inverse = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, self.extent_m));
        let blind = Matrix3::from_diagonal(&Vector3::from_fn(|k, _| f64::from(u8::from(!self.seen[k]))));
        inverse * self.directions * blind * self.directions.transpose() * inverse
    }

    /// A covariance of x, y, yaw, but along directions that are not seen (unit vectors, yaw scaled to lengths) with the variances
    /// that are said of them, m².
    pub fn with_blind(
        &self,
        covariance: &Matrix3<f64>,
        variance_m2: impl Fn(Vector3<f64>) -> f64,
    ) -> Matrix3<f64> {
        let inverse = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, self.extent_m));
        let scale = Matrix3::from_diagonal(&self.scale());
        let project = self.projection();
        let seen = scale * project * inverse * covariance * inverse * project * scale;
        let along = |k: usize| variance_m2(self.directions.column(k).into_owned());
        seen + self.compose(|k| if self.seen[k] { 0.0 } else { along(k) })
    }

    /// Axes by the largest component of each direction that is not seen.
    pub fn blind_axes(&self) -> BlindAxes {
        let mut axes = BlindAxes::default();
        for (direction, _) in self.directions.column_iter().zip(self.seen).filter(|(_, seen)| !seen) {
            match direction.component_mul(&self.scale()).iamax() {
                0 => axes.x = true,
                1 => axes.y = true,
                _ => axes.yaw = true,
            }
        }
        axes
    }

    /// A standard deviation along what is not seen, given the prior's covariance, meters (yaw scaled to lengths).
    pub fn blind_deviation_m(&self, covariance: &Matrix3<f64>) -> f64 {
        let inverse = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, self.extent_m));
        let scaled = inverse * covariance * inverse;
        let along = |direction: Vector3<f64>| direction.dot(&(scaled * direction)).max(0.0).sqrt();
        let blind = self.directions.column_iter().zip(self.seen).filter(|(_, seen)| !seen);
        blind.map(|(direction, _)| along(direction.into_owned())).fold(0.0, f64::max)
    }
}

fn scaled(hessian: &Matrix3<f64>, extent_m: f64) -> Matrix3<f64> {
    let scale = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0 / extent_m));
    scale * hessian * scale
}
