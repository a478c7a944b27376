//! The belief: a normal distribution of the pose and the scales of the odometer.

use nalgebra::{Matrix2, Matrix2x3, Matrix3, SMatrix, Vector2};
use rumbo_core::frames::{Pose2, wrap_angle};

use super::known_marks::KnownMark;
use super::motion::{N_STATES, State, StateMatrix, by_state, moved, new_errors, pose_of};
use super::sighting::{Expected, Sighting, expect};

/// A sighting farther from what is expected than this (squared Mahalanobis distance) is not believed: 99.9 % of the
/// chi-square distribution with two degrees of freedom.
pub const GATE: f64 = 13.815_510_557_964_274;

/// A mark nearer than so many standard deviations of the position bends the measurement too much for one step.
const NEAR: f64 = 10.0;
/// Steps of an iterated update at most.
const MOST_STEPS: usize = 10;
/// An iterated update ends when a step is shorter than this, meters or radians.
const CONVERGED: f64 = 1e-9;

type Gain = SMatrix<f64, N_STATES, 2>;
type ByState = SMatrix<f64, 2, N_STATES>;

/// Mean and covariance.
#[derive(Debug, Clone, PartialEq)]
pub struct Belief {
    /// x, y, yaw and the errors of the odometer's scales.
    pub mean: State,
    /// Its covariance.
    pub covariance: StateMatrix,
}

impl Belief {
    /// At a pose, with the standard deviations of the distance scale and of the turn scale. Scales without deviation are
    /// taken as they are for ever.
    pub fn at(pose: &Pose2, covariance: &Matrix3<f64>, scale_deviations: [f64; 2]) -> Belief {
        let Pose2 { translation, rotation } = pose;
        let mean = State::new(translation.x, translation.y, rotation.angle(), 0.0, 0.0);
        let mut full = StateMatrix::zeros();
        full.fixed_view_mut::<3, 3>(0, 0).copy_from(&((covariance + covariance.transpose()) / 2.0));
        for (idx, deviation) in scale_deviations.into_iter().enumerate() {
            full[(3 + idx, 3 + idx)] = deviation * deviation;
        }
        Belief { mean, covariance: full }
    }

    /// The same scales at another pose: their errors no longer have to do with those of the pose.
    pub fn put(&mut self, pose: &Pose2, covariance: &Matrix3<f64>) {
        let scales = [self.mean[3], self.mean[4]];
        let scale_covariance = self.covariance.fixed_view::<2, 2>(3, 3).into_owned();
        *self = Belief::at(pose, covariance, [0.0; 2]);
        [self.mean[3], self.mean[4]] = scales;
        self.covariance.fixed_view_mut::<2, 2>(3, 3).copy_from(&scale_covariance);
    }

    /// Where the robot is.
    pub fn pose(&self) -> Pose2 {
        pose_of(&self.mean)
    }

    /// Covariance of x, y, yaw.
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// The robot moved on; see [`new_errors`] for `noise`.
    pub fn advance(&mut self, step: &Pose2, noise: [f64; 3]) {
        let through = by_state(&self.mean, step);
        self.covariance = through * self.covariance * through.transpose();
        let added = self.pose_covariance() + new_errors(&self.mean, step, noise);
        self.covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&added);
        self.mean = moved(&self.mean, step);
        self.tidy();
    }

    /// The robot may have moved this far in any direction without anybody knowing.
    pub fn widen(&mut self, reach_m: f64, turn_rad: f64) {
        for (idx, reach) in [reach_m, reach_m, turn_rad].into_iter().enumerate() {
            self.covariance[(idx, idx)] += reach * reach;
        }
    }

    /// Squared Mahalanobis distance of a sighting from what the mark would give; infinite where there is none.
    pub fn distance(&self, sighting: &Sighting, mark: &KnownMark) -> f64 {
        let Some(expected) = expect(&self.pose(), &sighting.base_from_sensor, &mark.at) else {
            return f64::INFINITY;
        };
        let innovation = sighting.minus(&expected.expected);
        let by_state = of_state(&expected.by_pose);
        let spread = by_state * self.covariance * by_state.transpose() + noise_of(sighting, mark, &expected);
        spread.cholesky().map_or(f64::INFINITY, |root| innovation.dot(&root.solve(&innovation)))
    }

    /// Takes in a sighting of a mark, whatever its distance. Says whether that was possible.
    pub fn correct(&mut self, sighting: &Sighting, mark: &KnownMark) -> bool {
        let deviation_m = (self.covariance[(0, 0)] + self.covariance[(1, 1)]).sqrt();
        let is_near = sighting.measured.x < NEAR * deviation_m;
        let Some(mut step) = self.step_from(&self.mean, sighting, mark) else { return false };
        if is_near {
            for _ in 1..MOST_STEPS {
                let Some(next) = self.step_from(&step.mean, sighting, mark) else { return false };
                let change = (next.mean - step.mean).amax();
                step = next;
                if change < CONVERGED {
                    break;
                }
            }
        }
        // Joseph's form: a sum of two products with their transposes cannot become negative by rounding.
        let left = StateMatrix::identity() - step.gain * step.by_state;
        self.covariance =
            left * self.covariance * left.transpose() + step.gain * step.noise * step.gain.transpose();
        self.mean = step.mean;
        self.tidy();
        true
    }

    /// One step of Gauss and Newton towards the mean after a sighting, linearized at `point`.
    fn step_from(&self, point: &State, sighting: &Sighting, mark: &KnownMark) -> Option<Step> {
        let expected = expect(&pose_of(point), &sighting.base_from_sensor, &mark.at)?;
        let (by_state, noise) = (of_state(&expected.by_pose), noise_of(sighting, mark, &expected));
        let spread = by_state * self.covariance * by_state.transpose() + noise;
        let gain: Gain = self.covariance * by_state.transpose() * spread.cholesky()?.inverse();
        let innovation: Vector2<f64> = sighting.minus(&expected.expected) - by_state * (self.mean - point);
        let mean = self.mean + gain * innovation;
        mean.iter().all(|v| v.is_finite()).then_some(Step { mean, gain, by_state, noise })
    }

    fn tidy(&mut self) {
        self.mean[2] = wrap_angle(self.mean[2]);
        self.covariance = (self.covariance + self.covariance.transpose()) / 2.0;
    }
}

/// What one step of an update comes to.
struct Step {
    mean: State,
    gain: Gain,
    by_state: ByState,
    noise: Matrix2<f64>,
}

/// Scales of the odometer change nothing about a sighting.
fn of_state(by_pose: &Matrix2x3<f64>) -> ByState {
    let mut full = ByState::zeros();
    full.fixed_view_mut::<2, 3>(0, 0).copy_from(by_pose);
    full
}

/// Of the measurement and of the mark's place.
fn noise_of(sighting: &Sighting, mark: &KnownMark, expected: &Expected) -> Matrix2<f64> {
    sighting.noise + expected.by_mark * mark.covariance * expected.by_mark.transpose()
}
