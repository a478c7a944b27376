//! The pose together with the errors of the odometer and the offsets of the places that it is found by: an iterated extended Kalman filter (Bell and
//! Cathey 1993) over both, as in stochastic maps (Smith, Self and Cheeseman 1990). Not in the source, which fuses pairs
//! with weights made by hand; here each landmark weighs what its errors allow, and errors of the map stay what they are
//! however often a place is seen.

use super::dead_reckoning::{Way, sigmas};
use super::landmark_errors::LandmarkErrors;
use super::linearized::{OFFSETS, Rows, deviations, residual_at};
use super::mapped_marks::{MappedMark, MappedMarks, Slot};
use super::misfit::Misfit;
use super::sighting::{Sighting, offset_variances};
use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};
use rumbo_core::frames::{Point2, Pose2, pose2, wrap_angle};

/// Correlation of offsets of two pieces of one wall.
const ALIKE: f64 = 0.95;
/// Pose, odometer and offsets with their covariance.
#[derive(Debug, Clone)]
pub struct Joint {
    pose: Vector3<f64>,
    /// Errors of the odometer that stay: distance (m/m), direction (rad/m), turn (rad/rad).
    odometer: Vector3<f64>,
    /// Something is known of them beyond what the odometer claims.
    is_odometer_known: bool,
    marks: MappedMarks,
    misfit: Misfit,
    /// Of x, y, yaw, then of the odometer's three errors, then of two numbers for each place.
    covariance: DMatrix<f64>,
}

/// What sightings lead to.
#[derive(Debug, Clone)]
pub struct Posterior {
    state: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Sightings that may be what they seem.
    pub n_possible: usize,
    /// Sightings that are explained.
    pub n_fit: usize,
    /// Mean of the squared deviations of those that may be what they seem.
    squared_deviation: f64,
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
/// Within this many standard deviations a landmark is explained.
const FIT: f64 = 3.0;
/// Beyond this many standard deviations a landmark counts ever less.
const SURE: f64 = 2.0;

impl Joint {
    /// A pose and nothing else.
    pub fn new(map_from_base: &Pose2, covariance: &Matrix3<f64>) -> Joint {
        let mut full = DMatrix::zeros(OFFSETS, OFFSETS);
        full.fixed_view_mut::<3, 3>(0, 0).copy_from(covariance);
        Joint {
            pose: vector(map_from_base),
            odometer: Vector3::zeros(),
            is_odometer_known: false,
            marks: MappedMarks::default(),
            misfit: Misfit::default(),
            covariance: full,
        }
    }

    /// Where the robot is.
    pub fn map_from_base(&self) -> Pose2 {
        pose2(self.pose.x, self.pose.y, self.pose.z)
    }

    /// Covariance of x, y, yaw.
    pub fn pose_covariance(&self) -> Matrix3<f64> {
        self.covariance.fixed_view::<3, 3>(0, 0).into_owned()
    }

    /// Variance of the first part of a place's offset.
    #[cfg(test)]
    pub(super) fn offset_variance(&self, idx: usize) -> f64 {
        self.covariance[(OFFSETS + 2 * idx, OFFSETS + 2 * idx)]
    }

    /// The places.
    pub fn marks(&self) -> &MappedMarks {
        &self.marks
    }

    /// Where the odometer leads that says `way` of the robot's motion, and how surely; it claims `noise` of itself.
    pub fn carried(&self, way: &Pose2, noise: [f64; 3]) -> (Pose2, Matrix3<f64>) {
        let told = self.told(way);
        let mut cross = Matrix3::zeros();
        let mut odometer = Matrix3::from_diagonal(&Vector3::from(sigmas(noise)).map(|sigma| sigma * sigma));
        if self.is_odometer_known {
            cross.copy_from(&self.covariance.fixed_view::<3, 3>(0, 3));
            odometer.copy_from(&self.covariance.fixed_view::<3, 3>(3, 3));
        }
        let (by_pose, by_errors) = (told.by_pose(), told.by_errors());
        let mixed = by_pose * cross * by_errors.transpose();
        let covariance = by_pose * self.pose_covariance() * by_pose.transpose()
            + by_errors * odometer * by_errors.transpose()
            + mixed
            + mixed.transpose()
            + told.new_errors(noise);
        let pose = self.moved(way, &told);
        (pose2(pose.x, pose.y, pose.z), (covariance + covariance.transpose()) / 2.0)
    }

    fn told(&self, way: &Pose2) -> Way {
        let along = (self.map_from_base().rotation * way.translation.vector).xy();
        Way { along, turn_rad: way.rotation.angle() }
    }

    fn moved(&self, way: &Pose2, told: &Way) -> Vector3<f64> {
        vector(&(self.map_from_base() * way)) + told.by_errors() * self.odometer
    }

    /// The robot moved; see [`Joint::carried`].
    pub fn carry(&mut self, way: &Pose2, noise: [f64; 3]) {
        let told = self.told(way);
        let variances = Vector3::from(sigmas(noise)).map(|sigma| sigma * sigma);
        if !self.is_odometer_known {
            self.is_odometer_known = true;
            self.covariance.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::from_diagonal(&variances));
        }
        let covariance = self.carried(way, noise).1;
        let mut pose = self.moved(way, &told);
        pose.z = wrap_angle(pose.z);
        let others = self.covariance.columns(3, self.covariance.ncols() - 3).into_owned();
        let moved = told.by_pose() * others.fixed_rows::<3>(0) + told.by_errors() * others.fixed_rows::<3>(3);
        self.covariance.fixed_rows_mut::<3>(0).columns_range_mut(3..).copy_from(&moved);
        self.covariance.fixed_columns_mut::<3>(0).rows_range_mut(3..).copy_from(&moved.transpose());
        self.covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&covariance);
        let kept = told.keeps();
        for k in 3..OFFSETS {
            self.covariance.row_mut(k).scale_mut(kept);
            self.covariance.column_mut(k).scale_mut(kept);
            self.covariance[(k, k)] += (1.0 - kept * kept) * variances[k - 3];
        }
        self.odometer *= kept;
        self.pose = pose;
    }

    /// The robot may have moved this far in any direction, or turned, without anybody knowing.
    pub fn widen(&mut self, reach_m: f64, turn_rad: f64) {
        for (k, by) in [reach_m, reach_m, turn_rad].into_iter().enumerate() {
            self.covariance[(k, k)] += by * by;
        }
    }

    /// Finds a place or adds it; gives its number and its pivot. Without a number all are taken.
    pub fn slot_of(
        &mut self,
        mapped: MappedMark,
        scan: u64,
        errors: &LandmarkErrors,
    ) -> (Option<usize>, Point2) {
        let beside = self.marks.piece_beside(&mapped);
        let idx = match self.marks.find_or_add(mapped, scan) {
            Slot::Known(idx) => idx,
            Slot::Full => return (None, mapped.place),
            Slot::Added(idx) => {
                let n = self.covariance.nrows();
                self.covariance.resize_mut(n + 2, n + 2, 0.0);
                self.begin(idx, beside, &mapped, errors);
                idx
            }
            Slot::Replaced(idx) => {
                self.begin(idx, beside.filter(|beside| *beside != idx), &mapped, errors);
                idx
            }
        };
        (Some(idx), self.marks.get(idx).map_or(mapped.place, |mark| mark.mapped.place))
    }

    /// Of a new place's offset nothing is known but what the map promises, and that a wall goes on much as it was beside.
    fn begin(&mut self, idx: usize, beside: Option<usize>, mapped: &MappedMark, errors: &LandmarkErrors) {
        let alike = if beside.is_some() { ALIKE } else { 0.0 };
        let variances = offset_variances(mapped, errors);
        let offset = beside.and_then(|idx| self.marks.get(idx)).map_or(Vector2::zeros(), |mark| mark.offset);
        self.marks.set_offset(idx, offset * alike);
        for k in 0..2 {
            let at = OFFSETS + 2 * idx + k;
            let mut shared = match beside {
                Some(beside) => self.covariance.column(OFFSETS + 2 * beside + k) * alike,
                None => DVector::zeros(self.covariance.nrows()),
            };
            let own = beside.map_or(0.0, |beside| shared[OFFSETS + 2 * beside + k] * alike);
            shared[at] = own + (1.0 - alike * alike) * variances[k];
            self.covariance.set_column(at, &shared);
            self.covariance.set_row(at, &shared.transpose());
        }
    }

    fn state(&self) -> DVector<f64> {
        let offsets = self.marks.all().iter().flat_map(|mark| [mark.offset.x, mark.offset.y]);
        let parts: Vec<f64> = self.pose.iter().chain(&self.odometer).copied().chain(offsets).collect();
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
            let rows = Rows::at(&possible, (&prior, &state), &self.covariance, base_from_sensor);
            let (gain, shrunk) = rows.gain(&self.covariance, &possible, &weights, self.misfit.factor())?;
            let step = &prior + gain * rows.innovation() - &state;
            state += &step;
            solved = Some(shrunk);
            for (weight, sighting) in weights.iter_mut().zip(&possible) {
                let off = residual_at(sighting, &state, base_from_sensor).off;
                let deviations = deviations(&off, &sighting.covariance);
                *weight = if deviations > SURE { (SURE / deviations).powi(2) } else { 1.0 };
            }
            if step.amax() < 1e-7 {
                break;
            }
        }
        let off = |sighting: &Sighting| residual_at(sighting, &state, base_from_sensor).off;
        let fits = |sighting: &&Sighting| deviations(&off(sighting), &sighting.covariance) <= FIT;
        let n_fit = sightings.iter().filter(fits).count();
        let squared = |sighting: &&Sighting| deviations(&off(sighting), &sighting.covariance).powi(2);
        let squared_deviation = possible.iter().map(squared).sum::<f64>() / possible.len().max(1) as f64;
        Some(Posterior { covariance: solved?, n_possible: possible.len(), n_fit, squared_deviation, state })
    }

    /// It lies within what the pose so far and the errors let expect.
    fn is_possible(
        &self,
        sighting: &Sighting,
        prior: &DVector<f64>,
        state: &DVector<f64>,
        base_from_sensor: &Pose2,
    ) -> bool {
        let rows = Rows::at(&[sighting], (prior, state), &self.covariance, base_from_sensor);
        rows.first_deviations(sighting) <= GATE
    }

    /// Takes over what sightings lead to.
    pub fn accept(&mut self, posterior: Posterior) {
        let Posterior { state, covariance, squared_deviation, .. } = posterior;
        self.misfit.note(squared_deviation);
        self.pose = Vector3::new(state[0], state[1], wrap_angle(state[2]));
        self.odometer = state.fixed_rows::<3>(3).into_owned();
        self.marks
            .set_offsets((OFFSETS..state.len()).step_by(2).map(|at| Vector2::new(state[at], state[at + 1])));
        self.covariance = (&covariance + covariance.transpose()) / 2.0;
    }
}

fn vector(pose: &Pose2) -> Vector3<f64> {
    Vector3::new(pose.translation.x, pose.translation.y, pose.rotation.angle())
}
