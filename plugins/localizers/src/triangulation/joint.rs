//! The pose together with the offsets of the places that it is found by: an iterated extended Kalman filter (Bell and
//! Cathey 1993) over both, as in stochastic maps (Smith, Self and Cheeseman 1990). Not in the source, which fuses pairs
//! with weights made by hand; here each landmark weighs what its errors allow, and errors of the map stay what they are
//! however often a place is seen.

use super::landmark_errors::LandmarkErrors;
use super::mapped_marks::{MappedMark, MappedMarks, Slot};
use super::sighting::{Residual, Sighting, offset_variances};
use nalgebra::{DMatrix, DVector, Matrix2, Matrix3, Vector2, Vector3};
use rumbo_core::frames::{Point2, Pose2, pose2, wrap_angle};

/// Pose and offsets with their covariance.
#[derive(Debug, Clone)]
pub struct Joint {
    pose: Vector3<f64>,
    marks: MappedMarks,
    /// Of x, y, yaw, then of two numbers for each place.
    covariance: DMatrix<f64>,
}

/// What sightings lead to.
#[derive(Debug, Clone)]
pub struct Posterior {
    state: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Sightings that may be what they seem.
    pub n_possible: usize,
}

impl Posterior {
    /// Where the robot is then.
    pub fn pose(&self) -> Vector3<f64> {
        Vector3::new(self.state[0], self.state[1], self.state[2])
    }
}

/// Steps of the iteration; weights of outliers settle in few.
const N_STEPS: usize = 5;
/// Beyond this many standard deviations from what the pose so far lets expect, a landmark is something else.
const GATE: f64 = 4.0;
/// Beyond this many standard deviations a landmark counts ever less.
const SURE: f64 = 2.0;

impl Joint {
    /// A pose and nothing else.
    pub fn new(map_from_base: &Pose2, covariance: &Matrix3<f64>) -> Joint {
        let covariance = DMatrix::from_fn(3, 3, |row, col| covariance[(row, col)]);
        Joint { pose: vector(map_from_base), marks: MappedMarks::default(), covariance }
    }

    /// Where the robot is.
    pub fn map_from_base(&self) -> Pose2 {
        pose2(self.pose.x, self.pose.y, self.pose.z)
    }

    /// Covariance of x, y, yaw.
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// The places.
    pub fn marks(&self) -> &MappedMarks {
        &self.marks
    }

    /// The robot moved to a pose, which is known as well as `covariance` says. How it moved says nothing about places.
    pub fn carry(&mut self, map_from_base: &Pose2, covariance: &Matrix3<f64>) {
        let way = map_from_base.translation.vector - self.pose.xy();
        for col in 3..self.covariance.ncols() {
            let by_yaw = self.covariance[(2, col)];
            let moved = [-way.y * by_yaw, way.x * by_yaw];
            for (row, by) in moved.into_iter().enumerate() {
                self.covariance[(row, col)] += by;
                self.covariance[(col, row)] = self.covariance[(row, col)];
            }
        }
        self.covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(covariance);
        self.pose = vector(map_from_base);
    }

    /// Finds a place or adds it; gives its number and its pivot. Without a number all are taken.
    pub fn slot_of(
        &mut self,
        mapped: MappedMark,
        scan: u64,
        errors: &LandmarkErrors,
    ) -> (Option<usize>, Point2) {
        let idx = match self.marks.find_or_add(mapped, scan) {
            Slot::Known(idx) => idx,
            Slot::Full => return (None, mapped.place),
            Slot::Added(idx) => {
                let n = self.covariance.nrows();
                self.covariance.resize_mut(n + 2, n + 2, 0.0);
                self.forget(idx, &mapped, errors);
                idx
            }
            Slot::Replaced(idx) => {
                self.forget(idx, &mapped, errors);
                idx
            }
        };
        (Some(idx), self.marks.get(idx).map_or(mapped.place, |mark| mark.mapped.place))
    }

    /// Nothing is known of this offset but what the map promises.
    fn forget(&mut self, idx: usize, mapped: &MappedMark, errors: &LandmarkErrors) {
        let at = 3 + 2 * idx;
        for k in at..at + 2 {
            self.covariance.row_mut(k).fill(0.0);
            self.covariance.column_mut(k).fill(0.0);
        }
        let variances = offset_variances(mapped, errors);
        self.covariance[(at, at)] = variances.x;
        self.covariance[(at + 1, at + 1)] = variances.y;
    }

    fn state(&self) -> DVector<f64> {
        let offsets = self.marks.all().iter().flat_map(|mark| [mark.offset.x, mark.offset.y]);
        let parts: Vec<f64> = self.pose.iter().copied().chain(offsets).collect();
        DVector::from_vec(parts)
    }

    /// What sightings lead to when they are looked at from `start`. None where they say nothing.
    pub fn posterior(
        &self,
        sightings: &[Sighting],
        start: &Vector3<f64>,
        base_from_sensor: &Pose2,
    ) -> Option<Posterior> {
        let prior = self.state();
        let mut state = prior.clone();
        state.fixed_rows_mut::<3>(0).copy_from(start);
        let possible: Vec<&Sighting> = sightings
            .iter()
            .filter(|sighting| self.is_possible(sighting, &prior, &state, base_from_sensor))
            .collect();
        let mut weights = vec![1.0; possible.len()];
        let mut solved = None;
        for _ in 0..N_STEPS {
            let rows = self.rows(&possible, &prior, &state, base_from_sensor);
            let (gain, shrunk) = rows.gain(&self.covariance, &possible, &weights)?;
            let step = &prior + gain * &rows.innovation - &state;
            state += &step;
            solved = Some(shrunk);
            for (weight, sighting) in weights.iter_mut().zip(&possible) {
                let off = residual(sighting, &state, base_from_sensor).off;
                let deviations = deviations(&off, &sighting.covariance);
                *weight = if deviations > SURE { (SURE / deviations).powi(2) } else { 1.0 };
            }
            if step.amax() < 1e-7 {
                break;
            }
        }
        Some(Posterior { state, covariance: solved?, n_possible: possible.len() })
    }

    /// It lies within what the pose so far and the errors let expect.
    fn is_possible(
        &self,
        sighting: &Sighting,
        prior: &DVector<f64>,
        state: &DVector<f64>,
        base_from_sensor: &Pose2,
    ) -> bool {
        let rows = self.rows(&[sighting], prior, state, base_from_sensor);
        let spread = &rows.by_state_covariance * rows.by_state.transpose();
        let spread = spread.fixed_view::<2, 2>(0, 0).into_owned() + sighting.covariance;
        deviations(&Vector2::new(rows.innovation[0], rows.innovation[1]), &spread) <= GATE
    }

    /// Takes over what sightings lead to.
    pub fn accept(&mut self, posterior: Posterior) {
        let Posterior { state, covariance, .. } = posterior;
        self.pose = Vector3::new(state[0], state[1], wrap_angle(state[2]));
        self.marks.set_offsets((3..state.len()).step_by(2).map(|at| Vector2::new(state[at], state[at + 1])));
        self.covariance = (&covariance + covariance.transpose()) / 2.0;
    }

    fn rows(
        &self,
        sightings: &[&Sighting],
        prior: &DVector<f64>,
        state: &DVector<f64>,
        base_from_sensor: &Pose2,
    ) -> Rows {
        let (n, n_rows) = (state.len(), 2 * sightings.len());
        let mut by_state = DMatrix::zeros(n_rows, n);
        let mut innovation = DVector::zeros(n_rows);
        let mut moved = state - prior;
        moved[2] = wrap_angle(moved[2]);
        for (k, sighting) in sightings.iter().enumerate() {
            let Residual { off, by_pose, by_offset } = residual(sighting, state, base_from_sensor);
            by_state.fixed_view_mut::<2, 3>(2 * k, 0).copy_from(&by_pose);
            let mut ahead = off + by_pose * moved.fixed_rows::<3>(0);
            if let Some(at) = sighting.slot.map(|slot| 3 + 2 * slot) {
                by_state.fixed_view_mut::<2, 2>(2 * k, at).copy_from(&by_offset);
                ahead += by_offset * moved.fixed_rows::<2>(at);
            }
            innovation.fixed_rows_mut::<2>(2 * k).copy_from(&ahead);
        }
        let by_state_covariance = &by_state * &self.covariance;
        Rows { by_state, by_state_covariance, innovation }
    }
}

/// All sightings, linearized.
struct Rows {
    by_state: DMatrix<f64>,
    by_state_covariance: DMatrix<f64>,
    /// From what the prior lets expect.
    innovation: DVector<f64>,
}

impl Rows {
    /// The gain and the covariance afterwards.
    fn gain(
        &self,
        covariance: &DMatrix<f64>,
        sightings: &[&Sighting],
        weights: &[f64],
    ) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let mut spread = &self.by_state_covariance * self.by_state.transpose();
        for (k, (sighting, weight)) in sightings.iter().zip(weights).enumerate() {
            let mut part = spread.fixed_view_mut::<2, 2>(2 * k, 2 * k);
            part += sighting.covariance / *weight;
        }
        let inverse_times = spread.cholesky()?.solve(&self.by_state_covariance);
        let shrunk = covariance - self.by_state_covariance.transpose() * &inverse_times;
        Some((inverse_times.transpose(), shrunk))
    }
}

fn vector(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}

fn residual(sighting: &Sighting, state: &DVector<f64>, base_from_sensor: &Pose2) -> Residual {
    let pose = state.fixed_rows::<3>(0).into_owned();
    let offset =
        sighting.slot.map_or(Vector2::zeros(), |slot| state.fixed_rows::<2>(3 + 2 * slot).into_owned());
    sighting.residual(&pose, &offset, base_from_sensor)
}

/// How many standard deviations off; without bound where the covariance is none.
fn deviations(off: &Vector2<f64>, covariance: &Matrix2<f64>) -> f64 {
    covariance
        .try_inverse()
        .map_or(f64::INFINITY, |inverse| off.dot(&(inverse * off)).max(0.0).sqrt())
}
