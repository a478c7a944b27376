//! How fast the base goes, and how far off it may be: one filter for both.
//!
//! A velocity that is off moves the base wrongly for as long as it is carried on, so errors of place and of velocity belong
//! together: along a corridor the doubt grows with time, not with its root, and the next thing that shows the way takes back
//! what was wrong. Stochastic cloning (Roumeliotis and Burdick 2002): the pose of the key scan is a part of the state, since
//! scans are measured from there.

use super::prediction::Guess;
use nalgebra::{Matrix3, SMatrix, UnitComplex, Vector3};
use rumbo_core::frames::{Pose2, Twist};

/// How velocities change, and how sure matches are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Agility {
    /// Of a speed within a second, m/s (standard deviation).
    pub speed_m_s: f64,
    /// Of a turning rate within a second, rad/s.
    pub turn_rad_s: f64,
    /// What the robot can do: m/s and rad/s.
    pub fastest: [f64; 2],
    /// What no match is surer than, meters and radians.
    pub floor: [f64; 2],
}

type Errors = SMatrix<f64, 9, 9>;
type Gain = SMatrix<f64, 9, 3>;

/// Where the errors stand: of the key scan's pose in the odometer's axes, of the base's in the key scan's, and of the velocity
/// in the base's.
const KEY: usize = 0;
const BASE: usize = 3;
const TWIST: usize = 6;

/// Velocity and covariance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Drift {
    agility: Agility,
    twist: Twist,
    covariance: Errors,
}

/// What a scan corrects: x, y, yaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Correction {
    /// Of the key scan's pose, in the odometer's axes.
    pub key: Vector3<f64>,
    /// Of the base's pose, in the key scan's axes.
    pub base: Vector3<f64>,
}

impl Drift {
    /// Of a base at a pose with this covariance of x, y, yaw, that may go as fast as it can.
    pub fn new(agility: Agility, covariance: &Matrix3<f64>) -> Drift {
        let mut drift = Drift { agility, twist: Twist::ZERO, covariance: Errors::zeros() };
        drift.covariance.fixed_view_mut::<3, 3>(KEY, KEY).copy_from(covariance);
        drift.forget_velocity();
        drift
    }

    /// How fast the base probably goes.
    pub fn twist(&self) -> Twist {
        self.twist
    }

    /// Covariance of the velocity: forward, left, turn.
    pub fn twist_covariance(&self) -> Matrix3<f64> {
        self.block(TWIST, TWIST)
    }

    /// Covariance of the base's x, y, yaw in the key scan's axes.
    pub fn base_covariance(&self) -> Matrix3<f64> {
        self.block(BASE, BASE)
    }

    /// Covariance of the base's x, y, yaw in the odometer's axes.
    pub fn covariance(mut self, odom_from_key: &Pose2, key_from_base: &Pose2) -> Matrix3<f64> {
        self.add_floor();
        let (by_key, by_base) = by_parts(odom_from_key, key_from_base);
        let mut both = SMatrix::<f64, 3, 9>::zeros();
        both.fixed_view_mut::<3, 3>(0, KEY).copy_from(&by_key);
        both.fixed_view_mut::<3, 3>(0, BASE).copy_from(&by_base);
        let sum = both * self.covariance * both.transpose();
        (sum + sum.transpose()) * 0.5
    }

    fn block(&self, row: usize, column: usize) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(row, column).into_owned()
    }

    /// The base may go anywhere from now on, as fast as it can; most probably it stands.
    pub fn forget_velocity(&mut self) {
        self.twist = Twist::ZERO;
        let [fastest_m_s, fastest_rad_s] = self.agility.fastest;
        for (axis, fastest) in [fastest_m_s, fastest_m_s, fastest_rad_s].into_iter().enumerate() {
            self.set_velocity(axis, fastest * fastest);
        }
    }

    /// A part of the velocity has this variance, and nothing to do with any other error.
    fn set_velocity(&mut self, axis: usize, variance: f64) {
        let idx = TWIST + axis;
        self.covariance.row_mut(idx).fill(0.0);
        self.covariance.column_mut(idx).fill(0.0);
        self.covariance[(idx, idx)] = variance;
    }

    /// After a time in which the base probably moved like this.
    pub fn predicted(mut self, key_from_base: &Pose2, guess: &Guess, seconds: f64) -> Drift {
        if guess.is_anywhere {
            self.forget_velocity();
        }
        let [fastest_m_s, fastest_rad_s] = self.agility.fastest;
        let Agility { speed_m_s, turn_rad_s, .. } = self.agility;
        let axes = [(speed_m_s, fastest_m_s), (speed_m_s, fastest_m_s), (turn_rad_s, fastest_rad_s)];
        for (axis, (changes, fastest)) in axes.into_iter().enumerate() {
            self.age_velocity(axis, changes * changes * seconds, fastest * fastest);
        }
        if let Some(deviation_rad_s) = guess.turn_deviation_rad_s {
            self.set_velocity(2, deviation_rad_s.powi(2));
            self.twist.turn_rad_s = guess.step.rotation.angle() / seconds;
        }
        let (by_base, by_step) = by_parts(key_from_base, &guess.step);
        let mut change = Errors::identity();
        change.fixed_view_mut::<3, 3>(BASE, BASE).copy_from(&by_base);
        if guess.is_by_velocity {
            let by_twist = by_step * by_twist(&guess.step, seconds);
            change.fixed_view_mut::<3, 3>(BASE, TWIST).copy_from(&by_twist);
        }
        self.covariance = change * self.covariance * change.transpose();
        let noise = by_step * guess.covariance * by_step.transpose();
        let base = self.block(BASE, BASE) + noise;
        self.covariance.fixed_view_mut::<3, 3>(BASE, BASE).copy_from(&base);
        self
    }

    /// The velocity may have changed, but never beyond what the robot can do: near that, errors of long ago fade.
    fn age_velocity(&mut self, axis: usize, more: f64, most: f64) {
        let idx = TWIST + axis;
        let sum = self.covariance[(idx, idx)] + more;
        let kept = if sum > most { (((most - more) / (sum - more)).max(0.0)).sqrt() } else { 1.0 };
        self.covariance.row_mut(idx).scale_mut(kept);
        self.covariance.column_mut(idx).scale_mut(kept);
        self.covariance[(idx, idx)] += more;
    }

    /// Takes in where a scan says that the base is beside where it was predicted (in the key scan's axes), with the
    /// information that it has. Along directions without any, nothing is learned, of the velocity neither.
    pub fn take(&mut self, beside: &Vector3<f64>, information: &Matrix3<f64>) -> Correction {
        let of_base: Gain = self.covariance.fixed_view::<9, 3>(0, BASE).into_owned();
        let nothing = Correction { key: Vector3::zeros(), base: Vector3::zeros() };
        let Some(inverse) = (Matrix3::identity() + information * self.block(BASE, BASE)).try_inverse() else {
            return nothing;
        };
        let gain = of_base * inverse * information;
        let change = gain * beside;
        if !change.iter().all(|v| v.is_finite()) {
            return nothing;
        }
        let covariance = self.covariance - gain * of_base.transpose();
        self.covariance = (covariance + covariance.transpose()) * 0.5;
        self.twist.forward_m_s += change[TWIST];
        self.twist.left_m_s += change[TWIST + 1];
        self.twist.turn_rad_s += change[TWIST + 2];
        Correction {
            key: change.fixed_rows::<3>(KEY).into_owned(),
            base: change.fixed_rows::<3>(BASE).into_owned(),
        }
    }

    /// Takes a match as it is, with its covariance of x, y, yaw: where the prediction was that of wheels, which may slip by more
    /// than they say.
    pub fn adopt(&mut self, covariance: &Matrix3<f64>) {
        self.covariance.fixed_rows_mut::<3>(BASE).fill(0.0);
        self.covariance.fixed_columns_mut::<3>(BASE).fill(0.0);
        self.covariance.fixed_view_mut::<3, 3>(BASE, BASE).copy_from(covariance);
    }

    /// Takes in how the base moved where the velocity had no part in the prediction, with the covariance of that step.
    pub fn learn(&mut self, step: &Pose2, covariance: &Matrix3<f64>, seconds: f64) {
        let said = twist_of(step, seconds);
        let beside = [
            said.forward_m_s - self.twist.forward_m_s,
            said.left_m_s - self.twist.left_m_s,
            said.turn_rad_s - self.twist.turn_rad_s,
        ];
        let mut gains = [0.0; 3];
        for (axis, gain) in gains.iter_mut().enumerate() {
            let (told, own) =
                (covariance[(axis, axis)] / (seconds * seconds), self.twist_covariance()[(axis, axis)]);
            *gain = own / (own + told);
            self.set_velocity(axis, (1.0 - *gain) * own);
        }
        self.twist.forward_m_s += gains[0] * beside[0];
        self.twist.left_m_s += gains[1] * beside[1];
        self.twist.turn_rad_s += gains[2] * beside[2];
    }

    /// No match is surer than the agility's floor of where the base is in the key scan's frame.
    fn add_floor(&mut self) {
        let [least_m, least_rad] = self.agility.floor;
        for (axis, least) in [least_m, least_m, least_rad].into_iter().enumerate() {
            self.covariance[(BASE + axis, BASE + axis)] += least * least;
        }
    }

    /// The base where it is now becomes the key.
    pub fn begin_key(&mut self, odom_from_key: &Pose2, key_from_base: &Pose2) {
        let (by_key, by_base) = by_parts(odom_from_key, key_from_base);
        self.add_floor();
        let mut change = Errors::identity();
        change.fixed_view_mut::<3, 3>(KEY, KEY).copy_from(&by_key);
        change.fixed_view_mut::<3, 3>(KEY, BASE).copy_from(&by_base);
        change.fixed_view_mut::<3, 3>(BASE, BASE).fill(0.0);
        self.covariance = change * self.covariance * change.transpose();
    }
}

/// How errors of `first`, in the axes of its frame, and of `then`, in those of `first`, move what they make together.
fn by_parts(first: &Pose2, then: &Pose2) -> (Matrix3<f64>, Matrix3<f64>) {
    let way = first.rotation * then.translation.vector;
    let mut by_first = Matrix3::identity();
    by_first[(0, 2)] = -way.y;
    by_first[(1, 2)] = way.x;
    (by_first, first.rotation.to_rotation_matrix().to_homogeneous())
}

/// How a velocity moves the step that it makes: its way is turned by half of its turn.
fn by_twist(step: &Pose2, seconds: f64) -> Matrix3<f64> {
    let half = UnitComplex::new(step.rotation.angle() / 2.0);
    let mut by_twist = half.to_rotation_matrix().to_homogeneous() * seconds;
    by_twist[(2, 2)] = seconds;
    by_twist[(0, 2)] = -0.5 * seconds * step.translation.y;
    by_twist[(1, 2)] = 0.5 * seconds * step.translation.x;
    by_twist
}

/// The velocity that makes a step within a time. The chord of an arc is its velocity's way, turned by half of its turn.
fn twist_of(step: &Pose2, seconds: f64) -> Twist {
    let turn_rad = step.rotation.angle();
    let half_rad = turn_rad / 2.0;
    let longer = if half_rad.abs() < 1e-6 { 1.0 } else { half_rad / half_rad.sin() };
    let way = UnitComplex::new(-half_rad) * step.translation.vector * longer;
    Twist { forward_m_s: way.x / seconds, left_m_s: way.y / seconds, turn_rad_s: turn_rad / seconds }
}
