//! Robot and walls, and how surely all of them are known together.

use super::covariance::Covariance;
use nalgebra::{Matrix2, Matrix3, Matrix5, SMatrix, Vector5};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use std::f64::consts::PI;

/// Numbers of the robot: x, y (m), theta (rad), v (m/s), omega (rad/s).
pub const ROBOT: usize = 5;

/// The joint state.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// x, y, theta of the middle of the axle in the map, its speed and turn.
    pub robot: Vector5<f64>,
    /// Errors of the odometer, as many as are estimated.
    pub odometer: Vec<f64>,
    /// Distance (may be negative) and normal of each wall: `[rho, phi]`.
    pub walls: Vec<[f64; 2]>,
    /// Covariance of all of it, in this order.
    pub covariance: Covariance,
}

/// The same angle in (-pi, pi].
pub(super) fn wrapped(angle_rad: f64) -> f64 {
    let wrapped = wrap_angle(angle_rad);
    if wrapped == -PI { PI } else { wrapped }
}

impl State {
    /// A robot without walls.
    pub fn new(robot: Vector5<f64>, covariance: &Matrix5<f64>) -> State {
        let mut state =
            State { robot, odometer: Vec::new(), walls: Vec::new(), covariance: Covariance::zeros(ROBOT) };
        state.covariance.view_mut().copy_from(covariance);
        state
    }

    /// Numbers that are no walls: those of the robot and of its odometer.
    pub fn n_moving(&self) -> usize {
        ROBOT + self.odometer.len()
    }

    /// Where the numbers of a wall begin.
    pub fn column_of(&self, wall: usize) -> usize {
        self.n_moving() + 2 * wall
    }

    /// The robot in the map.
    pub fn pose(&self) -> Pose2 {
        pose2(self.robot[0], self.robot[1], self.robot[2])
    }

    /// Covariance of x, y, theta.
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.view().fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// Covariance of two walls' numbers with each other.
    pub fn between(&self, one: usize, other: usize) -> Matrix2<f64> {
        let (row, col) = (self.column_of(one), self.column_of(other));
        self.covariance.view().fixed_view::<2, 2>(row, col).into_owned()
    }

    /// Covariance of the robot's numbers with a wall's.
    pub fn robot_with(&self, wall: usize) -> SMatrix<f64, ROBOT, 2> {
        self.covariance.view().fixed_view::<ROBOT, 2>(0, self.column_of(wall)).into_owned()
    }

    /// Adds a wall that has nothing to do with the rest.
    pub fn add_known(&mut self, line: [f64; 2], covariance: &Matrix2<f64>) {
        let at = self.column_of(self.walls.len());
        self.covariance.grow(2);
        self.covariance.view_mut().fixed_view_mut::<2, 2>(at, at).copy_from(covariance);
        self.walls.push([line[0], wrapped(line[1])]);
    }

    /// Adds a wall that depends on the robot (`by_robot`) and on a measurement with this covariance (`by_sighting` goes
    /// through it already).
    pub fn add_seen(&mut self, line: [f64; 2], by_robot: &SMatrix<f64, 2, ROBOT>, noise: &Matrix2<f64>) {
        let at = self.column_of(self.walls.len());
        self.covariance.grow(2);
        let mut covariance = self.covariance.view_mut();
        let with_rest = by_robot * covariance.view((0, 0), (ROBOT, at));
        let own = with_rest.fixed_columns::<ROBOT>(0) * by_robot.transpose() + noise;
        covariance.view_mut((at, 0), (2, at)).copy_from(&with_rest);
        covariance.view_mut((0, at), (at, 2)).copy_from(&with_rest.transpose());
        covariance.fixed_view_mut::<2, 2>(at, at).copy_from(&((own + own.transpose()) * 0.5));
        self.walls.push([line[0], wrapped(line[1])]);
    }

    /// Forgets a wall; the last one takes its place.
    pub fn swap_remove(&mut self, wall: usize) {
        self.covariance.swap_remove_pair(self.column_of(wall));
        self.walls.swap_remove(wall);
    }

    /// The robot may move with any speed and turn of these deviations, whatever was known of them.
    pub(super) fn forget_motion(&mut self, deviations: [f64; 2]) {
        let mut covariance = self.covariance.view_mut();
        for (k, deviation) in (3..).zip(deviations) {
            self.robot[k] = 0.0;
            covariance.row_mut(k).fill(0.0);
            covariance.column_mut(k).fill(0.0);
            covariance[(k, k)] = deviation * deviation;
        }
    }

    /// The robot is elsewhere, and what it knew of its place says nothing of the walls any more.
    pub(super) fn place(&mut self, robot: Vector5<f64>, spread: &Matrix5<f64>) {
        self.robot = robot;
        let mut covariance = self.covariance.view_mut();
        covariance.rows_mut(0, ROBOT).fill(0.0);
        covariance.columns_mut(0, ROBOT).fill(0.0);
        covariance.fixed_view_mut::<ROBOT, ROBOT>(0, 0).copy_from(spread);
    }

    /// Angles in (-pi, pi].
    pub(super) fn wrap(&mut self) {
        self.robot[2] = wrapped(self.robot[2]);
        for line in &mut self.walls {
            line[1] = wrapped(line[1]);
        }
    }

    /// Every number is finite.
    pub fn is_finite(&self) -> bool {
        self.robot.iter().chain(&self.odometer).chain(self.walls.iter().flatten()).all(|v| v.is_finite())
            && self.covariance.view().iter().all(|v| v.is_finite())
    }
}
