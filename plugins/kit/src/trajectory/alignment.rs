//! The transform that lays an estimate over the truth.

use nalgebra::{Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use rumbo_core::frames::{Point3, Pose3};
use thiserror::Error;

use super::PosePair;

/// How an estimate is laid over the truth before it is judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Alignment {
    /// As it is: both are in the same frame.
    None,
    /// The first pose of the estimate onto the first of the truth.
    First,
    /// Moved, and turned about the vertical axis: what a robot on a floor may choose freely.
    Yaw,
    /// Moved and turned in space: Horn, "Closed-form solution of absolute orientation using unit quaternions" (1987).
    #[default]
    Se3,
    /// Moved, turned and scaled, for a camera that does not know the size of things: Umeyama, "Least-squares estimation
    /// of transformation parameters between two point patterns" (1991).
    #[doc(alias = "umeyama")]
    Sim3,
}

/// A rigid transform after a change of scale.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// Lengths of the estimate are multiplied by it.
    pub scale: f64,
    /// Rotation and translation behind it.
    pub truth_from_estimate: Pose3,
}

impl Similarity {
    /// A pose of the estimate in the frame of the truth.
    pub fn apply(&self, estimate: &Pose3) -> Pose3 {
        let scaled = estimate.translation.vector * self.scale;
        self.truth_from_estimate * Pose3::from_parts(Translation3::from(scaled), estimate.rotation)
    }
}

/// Why no alignment is better than all others.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum AlignmentError {
    /// There is no pair of poses.
    #[error("there is no pair of poses to align")]
    NoPairs,
    /// All positions of one trajectory are the same.
    #[error(
        "{which} stays in one place, so that its direction is not known; align with `first` or `none`, or give a \
         longer trajectory"
    )]
    OnePlace {
        /// The truth or the estimate.
        which: &'static str,
    },
    /// All positions lie on one line.
    #[error(
        "the positions lie on one line, so that a turn about it is not known; align with `yaw`, `first` or `none`"
    )]
    OnOneLine,
}

/// Second moments that are smaller than the largest by this factor are zero but for rounding.
const ROUNDING: f64 = 1e-12;

/// The transform that makes the sum of squared distances between positions least (but [`Alignment::None`] and
/// [`Alignment::First`], which look at no more than the first pair).
///
/// # Errors
/// [`AlignmentError`] where the positions do not decide.
pub fn align(pairs: &[PosePair], how: Alignment) -> Result<Similarity, AlignmentError> {
    let first = pairs.first().ok_or(AlignmentError::NoPairs)?;
    let rigid = |truth_from_estimate| Similarity { scale: 1.0, truth_from_estimate };
    match how {
        Alignment::None => Ok(rigid(Pose3::identity())),
        Alignment::First => Ok(rigid(first.truth * first.estimate.inverse())),
        Alignment::Yaw => Ok(Moments::of(pairs)?.about_vertical()),
        Alignment::Se3 => Moments::of(pairs)?.in_space(false),
        Alignment::Sim3 => Moments::of(pairs)?.in_space(true),
    }
}

/// Means and second moments of the positions.
struct Moments {
    truth_mean: Vector3<f64>,
    estimate_mean: Vector3<f64>,
    /// Mean squared distance of the estimate from its mean, m².
    estimate_variance: f64,
    /// Mean outer product of truth and estimate, both from their means (Umeyama's Σxy).
    covariance: Matrix3<f64>,
}

impl Moments {
    fn of(pairs: &[PosePair]) -> Result<Moments, AlignmentError> {
        let n = pairs.len() as f64;
        let mean = |of: fn(&PosePair) -> Vector3<f64>| pairs.iter().map(of).sum::<Vector3<f64>>() / n;
        let truth_mean = mean(|pair| pair.truth.translation.vector);
        let estimate_mean = mean(|pair| pair.estimate.translation.vector);
        let (mut truth_variance, mut estimate_variance) = (0.0, 0.0);
        let mut covariance = Matrix3::zeros();
        for pair in pairs {
            let truth = pair.truth.translation.vector - truth_mean;
            let estimate = pair.estimate.translation.vector - estimate_mean;
            truth_variance += truth.norm_squared() / n;
            estimate_variance += estimate.norm_squared() / n;
            covariance += truth * estimate.transpose() / n;
        }
        let stays =
            |variance: f64, mean: &Vector3<f64>| variance <= ROUNDING * ROUNDING * mean.norm_squared();
        for (which, variance, mean) in
            [("the truth", truth_variance, &truth_mean), ("the estimate", estimate_variance, &estimate_mean)]
        {
            if stays(variance, mean) {
                return Err(AlignmentError::OnePlace { which });
            }
        }
        Ok(Moments { truth_mean, estimate_mean, estimate_variance, covariance })
    }

    /// The yaw that makes the sum of dot products in the plane greatest.
    fn about_vertical(&self) -> Similarity {
        let c = &self.covariance;
        let yaw_rad = (c.m21 - c.m12).atan2(c.m11 + c.m22);
        self.joined(1.0, UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw_rad))
    }

    /// Umeyama, equations 40 to 42.
    fn in_space(&self, with_scale: bool) -> Result<Similarity, AlignmentError> {
        let svd = self.covariance.svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Err(AlignmentError::OnOneLine) };
        let [largest, second, _] = svd.singular_values.into();
        if second <= ROUNDING * largest {
            return Err(AlignmentError::OnOneLine);
        }
        // A mirror image fits best where the product is negative; the next best is a rotation.
        let handedness = (u.determinant() * v_t.determinant()).signum();
        let signs = Vector3::new(1.0, 1.0, handedness);
        let rotation = Rotation3::from_matrix_unchecked(u * Matrix3::from_diagonal(&signs) * v_t);
        let scale = if with_scale { svd.singular_values.dot(&signs) / self.estimate_variance } else { 1.0 };
        Ok(self.joined(scale, UnitQuaternion::from_rotation_matrix(&rotation)))
    }

    /// The translation follows from the means.
    fn joined(&self, scale: f64, rotation: UnitQuaternion<f64>) -> Similarity {
        let turned = rotation * Point3::from(self.estimate_mean * scale);
        let translation = Translation3::from(self.truth_mean - turned.coords);
        Similarity { scale, truth_from_estimate: Pose3::from_parts(translation, rotation) }
    }
}
