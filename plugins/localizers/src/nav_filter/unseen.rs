//! What a scan does not tell: between two walls, the way along them.

use nalgebra::{Matrix2, Matrix3, Vector2};

/// A scan tells nothing of the way in a direction that it does not see: so far, meters.
const UNKNOWN_M: f64 = 1.0;

/// Where a step is less sure than `seen_within_m`, it says nothing. Returns whether there is such a direction: a match that is
/// hardly held along a wall is wrong by more than its residuals show.
pub fn forget_unseen(covariance: &mut Matrix3<f64>, seen_within_m: f64) -> bool {
    let place = covariance.fixed_view::<2, 2>(0, 0).into_owned();
    let parts = place.symmetric_eigen();
    let mut unseen = Matrix2::zeros();
    for (variance, direction) in parts.eigenvalues.iter().zip(parts.eigenvectors.column_iter()) {
        if *variance > seen_within_m.powi(2) {
            unseen += direction * direction.transpose() * UNKNOWN_M.powi(2);
        }
    }
    covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&(place + unseen));
    unseen != Matrix2::zeros()
}

/// The speed at which a robot usually drives, as a measurement of its velocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UsualSpeed {
    /// Forward, m/s.
    pub forward_m_s: f64,
    /// Standard deviation of the mean over a second, m/s.
    pub deviation_m_s: f64,
}

/// It says nothing about the velocity to the side, m/s.
const ANY_M_S: f64 = 100.0;

impl UsualSpeed {
    /// Forward and left, with its covariance, where it is used every so many seconds.
    pub fn velocity(&self, every_s: f64) -> (Vector2<f64>, Matrix2<f64>) {
        let forward2 = self.deviation_m_s.powi(2) / every_s.max(1e-3);
        let covariance = Matrix2::from_diagonal(&Vector2::new(forward2, ANY_M_S.powi(2)));
        (Vector2::new(self.forward_m_s, 0.0), covariance)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between walls at 30 degrees: sure across them, not along.
    #[test]
    fn what_is_hardly_held_is_not_held_and_the_rest_stays() {
        let turn = nalgebra::Rotation2::new(30f64.to_radians());
        let inner = turn.matrix()
            * Matrix2::new(0.02f64.powi(2), 0.0, 0.0, 0.005f64.powi(2))
            * turn.matrix().transpose();
        let mut covariance = Matrix3::identity() * 1e-6;
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&inner);
        let before = covariance;
        assert!(!forget_unseen(&mut covariance, 0.03));
        assert_eq!(covariance, before);
        assert!(forget_unseen(&mut covariance, 0.01));
        let place = turn.matrix().transpose() * covariance.fixed_view::<2, 2>(0, 0) * turn.matrix();
        assert!((place[(0, 0)].sqrt() - 1.0).abs() < 1e-3 && (place[(1, 1)].sqrt() - 0.005).abs() < 1e-9);
        assert_eq!(covariance[(2, 2)], 1e-6);
    }

    #[test]
    fn a_usual_speed_says_as_much_in_a_second_however_often_it_is_used() {
        let usual = UsualSpeed { forward_m_s: 0.5, deviation_m_s: 0.1 };
        for every_s in [0.01, 0.05, 0.5] {
            let (velocity, covariance) = usual.velocity(every_s);
            assert_eq!(velocity, Vector2::new(0.5, 0.0));
            assert!((covariance[(0, 0)] * every_s - 0.01).abs() < 1e-12);
        }
    }
}
