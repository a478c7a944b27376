//! An extended Kalman filter of position, yaw and the bias of the measured yaw.
//!
//! Thrun, Burgard, Fox, *Probabilistic Robotics* (2005), table 3.3, over the state of [`super::motion`]; updates in the
//! form of Joseph (Bucy and Joseph 1968), so that the covariance stays one.

use nalgebra::{Matrix2, Matrix3, Matrix4, SMatrix, SVector, Vector2};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};

use super::motion::{
    State, antenna_by_state, antenna_m, measured_yaw_by_state, measured_yaw_rad, moved, moved_by_state,
    new_errors,
};
use super::pulled::Taken;
use super::seen_fix::SeenFix;

/// 99.9 % of the chi-square distribution with two degrees of freedom: fixes.
const FIX_GATE: f64 = 13.815_5;
/// The same with one: yaws.
const YAW_GATE: f64 = 10.827_6;

/// How the filter works.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EkfSettings {
    /// Standard deviation of the bias of the measured yaw at the start, radians.
    pub bias_deviation_rad: f64,
    /// What the bias does by itself: its standard deviation after a second, radians; it grows with the square root.
    pub bias_walk_rad: f64,
    /// After so many refused fixes, or yaws, in a row the next one is right.
    pub reset_after: u32,
}

/// The belief.
#[derive(Debug, Clone, PartialEq)]
pub struct Ekf {
    settings: EkfSettings,
    /// Most likely state.
    pub mean: State,
    /// Its covariance.
    pub covariance: Matrix4<f64>,
    n_refused_fixes: u32,
    n_refused_yaws: u32,
}

impl Ekf {
    /// At a pose that does not come from the measured yaw: a start that somebody named, or an alignment with fixes.
    pub fn at(settings: EkfSettings, pose: &Pose2, covariance: &Matrix3<f64>) -> Ekf {
        let mean = State::new(pose.translation.x, pose.translation.y, pose.rotation.angle(), 0.0);
        let mut full = Matrix4::zeros();
        full.fixed_view_mut::<3, 3>(0, 0).copy_from(covariance);
        full[(3, 3)] = settings.bias_deviation_rad.powi(2);
        Ekf { settings, mean, covariance: full, n_refused_fixes: 0, n_refused_yaws: 0 }
    }

    /// At a fix, with the measured yaw (and its variance): what the yaw is off by, the bias is off by too.
    pub fn at_fix(settings: EkfSettings, fix: &SeenFix, yaw_rad: f64, yaw_variance_rad2: f64) -> Ekf {
        let origin = State::new(0.0, 0.0, yaw_rad, 0.0);
        let base_m = fix.antenna_m - antenna_m(&origin, &fix.lever_now_m);
        let mean = State::new(base_m.x, base_m.y, yaw_rad, 0.0);
        let bias_variance = settings.bias_deviation_rad.powi(2);
        let yaw_variance = yaw_variance_rad2 + bias_variance;
        // The lever turns with the yaw.
        let by_yaw = -antenna_by_state(&mean, &fix.lever_now_m).column(2).into_owned();
        let mut covariance = Matrix4::zeros();
        let position = Matrix2::from_diagonal(&fix.variance_m2) + by_yaw * yaw_variance * by_yaw.transpose();
        covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&position);
        for (row, with_yaw, with_bias) in [
            (0, by_yaw.x * yaw_variance, -by_yaw.x * bias_variance),
            (1, by_yaw.y * yaw_variance, -by_yaw.y * bias_variance),
            (2, yaw_variance, -bias_variance),
            (3, -bias_variance, bias_variance),
        ] {
            covariance[(row, 2)] = with_yaw;
            covariance[(2, row)] = with_yaw;
            covariance[(row, 3)] = with_bias;
            covariance[(3, row)] = with_bias;
        }
        Ekf { settings, mean, covariance, n_refused_fixes: 0, n_refused_yaws: 0 }
    }

    /// The base in the map.
    pub fn pose(&self) -> Pose2 {
        pose2(self.mean[0], self.mean[1], self.mean[2])
    }

    /// Covariance of x, y, yaw.
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// A step of the odometer with these standard deviations over a meter or radian.
    pub fn advance(&mut self, step: &Pose2, noise: [f64; 3]) {
        let through = moved_by_state(&self.mean, step);
        self.covariance =
            through * self.covariance * through.transpose() + new_errors(&self.mean, step, noise);
        self.mean = moved(&self.mean, step);
        self.tidy();
    }

    /// Time passes for the bias.
    pub fn age(&mut self, seconds: f64) {
        self.covariance[(3, 3)] += self.settings.bias_walk_rad.powi(2) * seconds.max(0.0);
    }

    /// The robot may have gone and turned this far without anybody knowing.
    pub fn widen(&mut self, reach_m: f64, reach_rad: f64) {
        let reach = State::new(reach_m, reach_m, reach_rad, 0.0);
        self.covariance += Matrix4::from_diagonal(&reach.component_mul(&reach));
    }

    /// A fix.
    pub fn take_fix(&mut self, fix: &SeenFix) -> Taken {
        let off_m: Vector2<f64> = fix.antenna_m - antenna_m(&self.mean, &fix.lever_now_m);
        let by_state = antenna_by_state(&self.mean, &fix.lever_now_m);
        let noise = Matrix2::from_diagonal(&fix.variance_m2);
        if self.correct(&off_m, &by_state, &noise, FIX_GATE) {
            self.n_refused_fixes = 0;
            return Taken::Used;
        }
        if self.n_refused_fixes < self.settings.reset_after {
            self.n_refused_fixes += 1;
            return Taken::Refused;
        }
        // Yaw and bias stay what they are: what was wrong is the place.
        self.mean[0] += off_m.x;
        self.mean[1] += off_m.y;
        self.covariance.fixed_view_mut::<2, 4>(0, 0).fill(0.0);
        self.covariance.fixed_view_mut::<4, 2>(0, 0).fill(0.0);
        self.covariance.fixed_view_mut::<2, 2>(0, 0).copy_from(&noise);
        self.n_refused_fixes = 0;
        Taken::Placed
    }

    /// A measured yaw and its variance.
    pub fn take_yaw(&mut self, yaw_rad: f64, variance_rad2: f64) -> Taken {
        let off_rad = wrap_angle(yaw_rad - measured_yaw_rad(&self.mean));
        let off = SVector::<f64, 1>::new(off_rad);
        let noise = SMatrix::<f64, 1, 1>::new(variance_rad2);
        if self.correct(&off, &measured_yaw_by_state(), &noise, YAW_GATE) {
            self.n_refused_yaws = 0;
            return Taken::Used;
        }
        if self.n_refused_yaws < self.settings.reset_after {
            self.n_refused_yaws += 1;
            return Taken::Refused;
        }
        // The unit was restarted: it has another bias now, of which nobody knows anything.
        self.mean[3] = wrap_angle(self.mean[3] + off_rad);
        self.covariance.fixed_view_mut::<1, 4>(3, 0).fill(0.0);
        self.covariance.fixed_view_mut::<4, 1>(0, 3).fill(0.0);
        self.covariance[(3, 3)] = self.settings.bias_deviation_rad.powi(2);
        self.n_refused_yaws = 0;
        Taken::Placed
    }

    /// An update by a measurement that is `off` from what is expected; false where that is beyond the gate.
    fn correct<const N: usize>(
        &mut self,
        off: &SVector<f64, N>,
        by_state: &SMatrix<f64, N, 4>,
        noise: &SMatrix<f64, N, N>,
        gate: f64,
    ) -> bool {
        let expected = by_state * self.covariance * by_state.transpose() + noise;
        let Some(inverse) = expected.try_inverse() else { return false };
        let distance = (off.transpose() * inverse * off)[(0, 0)];
        if distance.is_nan() || distance > gate {
            return false;
        }
        let gain: SMatrix<f64, 4, N> = self.covariance * by_state.transpose() * inverse;
        self.mean += gain * off;
        let left = Matrix4::identity() - gain * by_state;
        self.covariance = left * self.covariance * left.transpose() + gain * noise * gain.transpose();
        self.tidy();
        true
    }

    fn tidy(&mut self) {
        self.mean[2] = wrap_angle(self.mean[2]);
        self.mean[3] = wrap_angle(self.mean[3]);
        self.covariance = (self.covariance + self.covariance.transpose()) / 2.0;
    }
}
