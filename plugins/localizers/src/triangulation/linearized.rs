//! Sightings as linear equations of the state, and what they do to its covariance.

use super::sighting::{Residual, Sighting};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rumbo_core::frames::{Pose2, wrap_angle};

/// Where offsets of places begin in the state: after the pose and the odometer's errors.
pub const OFFSETS: usize = 6;

/// Sightings, linearized at a state; two rows each.
pub struct Rows {
    by_state: DMatrix<f64>,
    by_state_covariance: DMatrix<f64>,
    /// From what the prior lets expect.
    innovation: DVector<f64>,
}

impl Rows {
    /// At `state`, which the iteration has reached from `prior`, whose covariance is given.
    pub fn at(
        sightings: &[&Sighting],
        (prior, state): (&DVector<f64>, &DVector<f64>),
        covariance: &DMatrix<f64>,
        base_from_sensor: &Pose2,
    ) -> Rows {
        let (n, n_rows) = (state.len(), 2 * sightings.len());
        let mut by_state = DMatrix::zeros(n_rows, n);
        let mut innovation = DVector::zeros(n_rows);
        let mut moved = state - prior;
        moved[2] = wrap_angle(moved[2]);
        for (k, sighting) in sightings.iter().enumerate() {
            let Residual { off, by_pose, by_offset } = residual_at(sighting, state, base_from_sensor);
            by_state.fixed_view_mut::<2, 3>(2 * k, 0).copy_from(&by_pose);
            let mut ahead = off + by_pose * moved.fixed_rows::<3>(0);
            if let Some(at) = sighting.slot.map(|slot| OFFSETS + 2 * slot) {
                by_state.fixed_view_mut::<2, 2>(2 * k, at).copy_from(&by_offset);
                ahead += by_offset * moved.fixed_rows::<2>(at);
            }
            innovation.fixed_rows_mut::<2>(2 * k).copy_from(&ahead);
        }
        let by_state_covariance = &by_state * covariance;
        Rows { by_state, by_state_covariance, innovation }
    }

    /// What was seen less what the prior lets expect.
    pub fn innovation(&self) -> &DVector<f64> {
        &self.innovation
    }

    /// How many standard deviations the first sighting is off, as far as the prior is known.
    pub fn first_deviations(&self, sighting: &Sighting) -> f64 {
        let spread = &self.by_state_covariance * self.by_state.transpose();
        let spread = spread.fixed_view::<2, 2>(0, 0).into_owned() + sighting.covariance;
        deviations(&self.innovation.fixed_rows::<2>(0).into_owned(), &spread)
    }

    /// The gain and the covariance afterwards; `weights` of sightings count down outliers, and all have a covariance so
    /// many times (`factor`) theirs.
    pub fn gain(
        &self,
        covariance: &DMatrix<f64>,
        sightings: &[&Sighting],
        weights: &[f64],
        factor: f64,
    ) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let mut spread = &self.by_state_covariance * self.by_state.transpose();
        for (k, (sighting, weight)) in sightings.iter().zip(weights).enumerate() {
            let mut part = spread.fixed_view_mut::<2, 2>(2 * k, 2 * k);
            part += sighting.covariance * (factor / *weight);
        }
        let inverse_times = spread.cholesky()?.solve(&self.by_state_covariance);
        let shrunk = covariance - self.by_state_covariance.transpose() * &inverse_times;
        Some((inverse_times.transpose(), shrunk))
    }
}

/// A sighting at a state.
pub fn residual_at(sighting: &Sighting, state: &DVector<f64>, base_from_sensor: &Pose2) -> Residual {
    let pose = state.fixed_rows::<3>(0).into_owned();
    let offset =
        sighting.slot.map_or(Vector2::zeros(), |slot| state.fixed_rows::<2>(OFFSETS + 2 * slot).into_owned());
    sighting.residual(&pose, &offset, base_from_sensor)
}

/// How many standard deviations off; without bound where the covariance is none.
pub fn deviations(off: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    covariance.try_inverse().map_or(f64::INFINITY, |inverse| off.dot(&(inverse * off)).max(0.0).sqrt())
}
