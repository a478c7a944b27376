//! Prediction: constant velocity, driven by unknown accelerations (section 2.1 of the source).

use super::state::{ROBOT, State, wrapped};
use nalgebra::{Matrix5, SMatrix, Vector5};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How a step is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Integration {
    /// Along the heading in the middle of the step.
    #[default]
    Midpoint,
    /// Along the heading at its begin, as printed: on a curve off by `v omega T²/2` a step, always to the same side.
    Euler,
}

/// How the robot may move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionModel {
    /// How a step is integrated.
    pub integration: Integration,
    /// Standard deviation of the acceleration, constant over a step, m/s² (sigma_a).
    pub acceleration_m_s2: f64,
    /// The same of the turn, rad/s² (sigma_alpha).
    pub turn_acceleration_rad_s2: f64,
    /// Side slip: standard deviation after one second, meters (sigma_lat); not in the source.
    pub lateral_m: f64,
}

impl Default for MotionModel {
    fn default() -> Self {
        MotionModel {
            integration: Integration::Midpoint,
            acceleration_m_s2: 0.5,
            turn_acceleration_rad_s2: 0.3,
            lateral_m: 0.0,
        }
    }
}

impl MotionModel {
    /// Where the robot is after a step of `t` seconds, and how that changes with where it was (F).
    pub fn step(&self, robot: &Vector5<f64>, t: f64) -> (Vector5<f64>, Matrix5<f64>) {
        let [x, y, theta, v, omega] = (*robot).into();
        let (sin, cos) = self.direction(robot, t).sin_cos();
        let next = Vector5::new(x + t * v * cos, y + t * v * sin, wrapped(theta + t * omega), v, omega);
        let mut by_robot = Matrix5::identity();
        (by_robot[(0, 2)], by_robot[(0, 3)]) = (-t * v * sin, t * cos);
        (by_robot[(1, 2)], by_robot[(1, 3)]) = (t * v * cos, t * sin);
        by_robot[(2, 4)] = t;
        if self.integration == Integration::Midpoint {
            by_robot[(0, 4)] = -t * t / 2.0 * v * sin;
            by_robot[(1, 4)] = t * t / 2.0 * v * cos;
        }
        (next, by_robot)
    }

    /// How the place after a step changes with its length.
    pub fn by_time(&self, robot: &Vector5<f64>, t: f64) -> Vector5<f64> {
        let (v, omega) = (robot[3], robot[4]);
        let (sin, cos) = self.direction(robot, t).sin_cos();
        let swing = match self.integration {
            Integration::Midpoint => t * v * omega / 2.0,
            Integration::Euler => 0.0,
        };
        Vector5::new(v * cos - swing * sin, v * sin + swing * cos, omega, 0.0, 0.0)
    }

    /// How the robot answers to the accelerations of a step (Gamma).
    pub fn by_accelerations(&self, robot: &Vector5<f64>, t: f64) -> SMatrix<f64, ROBOT, 2> {
        let (sin, cos) = self.direction(robot, t).sin_cos();
        let half = t * t / 2.0;
        SMatrix::from_row_slice(&[half * cos, 0.0, half * sin, 0.0, 0.0, half, t, 0.0, 0.0, t])
    }

    fn direction(&self, robot: &Vector5<f64>, t: f64) -> f64 {
        match self.integration {
            Integration::Midpoint => robot[2] + t * robot[4] / 2.0,
            Integration::Euler => robot[2],
        }
    }

    /// Noise of a step (Gamma Q Gamma^T, and side slip).
    fn noise(&self, robot: &Vector5<f64>, t: f64) -> Matrix5<f64> {
        let gamma = self.by_accelerations(robot, t);
        let [a, alpha] = [self.acceleration_m_s2, self.turn_acceleration_rad_s2].map(|sigma| sigma * sigma);
        let along = gamma.column(0) * gamma.column(0).transpose() * a;
        let turning = gamma.column(1) * gamma.column(1).transpose() * alpha;
        let (sin, cos) = self.direction(robot, t).sin_cos();
        let across = Vector5::new(-sin, cos, 0.0, 0.0, 0.0);
        along + turning + across * across.transpose() * (self.lateral_m * self.lateral_m * t)
    }

    /// Moves the state on by `t` seconds: the walls stay, and so does their covariance. O(n).
    pub fn predict(&self, state: &mut State, t: f64) {
        let (next, by_robot) = self.step(&state.robot, t);
        let noise = self.noise(&state.robot, t);
        state.robot = next;
        let n_columns = state.covariance.size();
        let mut covariance = state.covariance.view_mut();
        let own = covariance.fixed_view::<ROBOT, ROBOT>(0, 0).into_owned();
        let own = by_robot * own * by_robot.transpose() + noise;
        covariance.fixed_view_mut::<ROBOT, ROBOT>(0, 0).copy_from(&((own + own.transpose()) * 0.5));
        for col in ROBOT..n_columns {
            let cross: Vector5<f64> = by_robot * covariance.fixed_view::<ROBOT, 1>(0, col);
            covariance.fixed_view_mut::<ROBOT, 1>(0, col).copy_from(&cross);
            covariance.fixed_view_mut::<1, ROBOT>(col, 0).copy_from(&cross.transpose());
        }
    }
}
