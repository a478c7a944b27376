//! A Kalman filter of constant velocity in the plane; both axes are alike, so they share one covariance.

use nalgebra::Vector2;
use rumbo_core::frames::Point2;

/// Position and velocity with the covariance of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConstantVelocity {
    /// Position.
    pub position: Point2,
    /// Velocity, m/s.
    pub velocity: Vector2<f64>,
    /// Variance of the position, of the velocity, and what they have in common.
    variances: [f64; 3],
}

impl ConstantVelocity {
    /// Somebody of whom only the place is known.
    pub fn at(position: Point2, deviation_m: f64, deviation_m_s: f64) -> ConstantVelocity {
        let variances = [deviation_m.powi(2), deviation_m_s.powi(2), 0.0];
        ConstantVelocity { position, velocity: Vector2::zeros(), variances }
    }

    /// Standard deviation of the velocity along one axis, m/s.
    pub fn speed_deviation_m_s(&self) -> f64 {
        self.variances[1].sqrt()
    }

    /// Time passes, with white acceleration of this intensity, (m/s²)²·s.
    pub fn predict(&mut self, seconds: f64, intensity: f64) {
        let [place, speed, both] = self.variances;
        self.position += self.velocity * seconds;
        self.variances = [
            place + 2.0 * seconds * both + seconds.powi(2) * speed + intensity * seconds.powi(3) / 3.0,
            speed + intensity * seconds,
            both + seconds * speed + intensity * seconds.powi(2) / 2.0,
        ];
    }

    /// The position was measured.
    pub fn update(&mut self, measured: Point2, deviation_m: f64) {
        let [place, speed, both] = self.variances;
        let innovation = measured - self.position;
        let spread = place + deviation_m.powi(2);
        let (place_gain, speed_gain) = (place / spread, both / spread);
        self.position += innovation * place_gain;
        self.velocity += innovation * speed_gain;
        self.variances = [place * (1.0 - place_gain), speed - speed_gain * both, both * (1.0 - place_gain)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, RowVector2};
    use rand::RngExt;
    use rumbo_core::rng;

    /// The textbook's matrices, one axis at a time.
    #[test]
    fn both_axes_go_as_the_matrices_say() {
        let mut rng = rng::stream(3, "filter");
        let mut filter = ConstantVelocity::at(Point2::new(1.0, -2.0), 0.1, 1.0);
        let mut means = [Vector2::new(1.0, 0.0), Vector2::new(-2.0, 0.0)];
        let mut covariance = Matrix2::new(0.01, 0.0, 0.0, 1.0);
        for _ in 0..200 {
            let (dt, q, r) =
                (rng.random_range(0.05..0.5), rng.random_range(0.1..2.0), rng.random_range(0.05..0.3));
            let measured = Point2::new(rng.random_range(-5.0..5.0), rng.random_range(-5.0..5.0));
            filter.predict(dt, q);
            filter.update(measured, r);
            let f = Matrix2::new(1.0, dt, 0.0, 1.0);
            let noise = Matrix2::new(dt.powi(3) / 3.0, dt.powi(2) / 2.0, dt.powi(2) / 2.0, dt) * q;
            let h = RowVector2::new(1.0, 0.0);
            let predicted = f * covariance * f.transpose() + noise;
            let gain = predicted * h.transpose() / ((h * predicted * h.transpose())[0] + r * r);
            covariance = (Matrix2::identity() - gain * h) * predicted;
            for (mean, at) in means.iter_mut().zip([measured.x, measured.y]) {
                *mean = f * *mean;
                *mean += gain * (at - mean[0]);
            }
            let off = (filter.position - Point2::new(means[0][0], means[1][0])).norm()
                + (filter.velocity - Vector2::new(means[0][1], means[1][1])).norm();
            assert!(off < 1e-9, "{off}");
            assert!((filter.speed_deviation_m_s() - covariance[(1, 1)].sqrt()).abs() < 1e-9);
        }
    }
}
