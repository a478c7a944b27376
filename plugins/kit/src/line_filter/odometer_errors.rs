//! Errors of wheels and odometers that go on and on, as numbers of the state.
//!
//! Not in the source, whose wheels are right in the mean. Real ones are not: of two wheels one is worn more, and the odometer
//! turns a little to one side with every meter. Over half a minute without a wall such errors add up to more than any gate
//! lets pass; but with every wall that is seen the filter can learn them. With true speed v and turn omega the readings are
//!
//! ```text
//! v_read = (1 + k_v) v          omega_read = (1 + k_omega) omega + kappa v + b
//! ```
//!
//! each error a random walk that starts at zero. Borenstein and Feng, *Measurement and correction of systematic odometry
//! errors in mobile robots* (1996), have the same errors as diameters of wheels and as a track; Martinelli and Siegwart,
//! *Simultaneous localization and odometry calibration* (2003), put them into the state of a filter.

use super::motion::MotionModel;
use super::state::{ROBOT, State};
use super::update::Row;
use super::wheels::Wheels;
use nalgebra::{Matrix2, Matrix2xX, RowSVector, SMatrix};

/// Which error.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OdometerError {
    /// Share by which distances read too long (k_v).
    DistanceScale,
    /// Share by which turns read too far (k_omega).
    TurnScale,
    /// Turn that is read for every meter, rad/m (kappa).
    TurnPerMeter,
    /// Turn that is read for every second, rad/s (b).
    TurnPerSecond,
    /// Time by which a scan is stamped later than the odometer's reading of the same moment, seconds (tau).
    ScanDelay,
}

impl OdometerError {
    /// All of them, in their order.
    pub const ALL: [OdometerError; 5] = [
        OdometerError::DistanceScale,
        OdometerError::TurnScale,
        OdometerError::TurnPerMeter,
        OdometerError::TurnPerSecond,
        OdometerError::ScanDelay,
    ];

    /// In words, with its unit.
    pub fn name(self) -> &'static str {
        match self {
            OdometerError::DistanceScale => "odometer: share of distances",
            OdometerError::TurnScale => "odometer: share of turns",
            OdometerError::TurnPerMeter => "odometer: turn, rad/m",
            OdometerError::TurnPerSecond => "odometer: turn, rad/s",
            OdometerError::ScanDelay => "delay of scans, s",
        }
    }
}

/// How large the errors may be. All zero: they are no part of the state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OdometerModel {
    /// Standard deviation of each error before anything was seen, in the order of [`OdometerError::ALL`]; an error of zero
    /// is not estimated.
    pub deviations: [f64; 5],
    /// Share of that deviation by which each error wanders in a second (it grows with the root of the time).
    pub wander_per_s: f64,
}

impl OdometerModel {
    /// The errors that are estimated.
    pub fn estimated(&self) -> impl Iterator<Item = OdometerError> + '_ {
        let all = OdometerError::ALL.into_iter().zip(self.deviations);
        all.filter(|(_, deviation)| *deviation > 0.0).map(|(error, _)| error)
    }

    /// Puts the errors into a state that has only a robot.
    pub(super) fn begin(&self, state: &mut State) {
        for deviation in self.deviations.into_iter().filter(|deviation| *deviation > 0.0) {
            let at = state.covariance.size();
            state.covariance.grow(1);
            state.covariance.view_mut()[(at, at)] = deviation * deviation;
            state.odometer.push(0.0);
        }
    }

    /// The errors wander for so many seconds.
    pub(super) fn wander(&self, state: &mut State, seconds: f64) {
        let mut covariance = state.covariance.view_mut();
        for (k, deviation) in self.deviations.into_iter().filter(|deviation| *deviation > 0.0).enumerate() {
            let step = deviation * self.wander_per_s;
            covariance[(ROBOT + k, ROBOT + k)] += step * step * seconds;
        }
    }

    /// All errors of a state; those that are not estimated are zero.
    pub fn errors(&self, state: &State) -> [f64; 5] {
        let mut known = state.odometer.iter();
        self.deviations
            .map(|deviation| if deviation > 0.0 { known.next().copied().unwrap_or(0.0) } else { 0.0 })
    }

    /// Columns of the state with what each error does.
    fn columns(&self, effects: [f64; 5]) -> impl Iterator<Item = (usize, f64)> {
        let estimated = self.deviations.into_iter().zip(effects).filter(|(deviation, _)| *deviation > 0.0);
        estimated.enumerate().map(|(k, (_, effect))| (ROBOT + k, effect))
    }

    /// What is measured of a speed and a turn, as columns of the state with their weights; `by_all` are those of v, omega
    /// and the four errors.
    fn entries(&self, by_all: &RowSVector<f64, 6>) -> Vec<(usize, f64)> {
        let errors = self.columns([by_all[2], by_all[3], by_all[4], by_all[5], 0.0]);
        [(3, by_all[0]), (4, by_all[1])].into_iter().chain(errors).collect()
    }

    /// The measurement of the speeds of both wheels.
    pub fn rows(&self, wheels: &Wheels, state: &State, speeds_m_s: [f64; 2]) -> [Row; 2] {
        let (read, by_all) = reading([state.robot[3], state.robot[4]], self.errors(state));
        let row = |side: f64, speed_m_s: f64| {
            let arm_m = side * wheels.half_track_m;
            let weights = self.entries(&(by_all.row(0) + by_all.row(1) * arm_m));
            let innovation = speed_m_s - read[0] - arm_m * read[1];
            Row::new(&weights, innovation, wheels.speed_m_s * wheels.speed_m_s)
        };
        [row(-1.0, speeds_m_s[0]), row(1.0, speeds_m_s[1])]
    }

    /// The measurement of the speed and the turn that an odometer reads, with the variances of both.
    pub fn odometer_rows(&self, state: &State, read: [f64; 2], variances: [f64; 2]) -> [Row; 2] {
        let (expected, by_all) = reading([state.robot[3], state.robot[4]], self.errors(state));
        [0, 1].map(|k| {
            let weights = self.entries(&by_all.row(k).into_owned());
            Row::new(&weights, read[k] - expected[k], variances[k])
        })
    }

    /// The robot moves as an odometer read, whatever was thought of its speed and turn before.
    pub(super) fn move_as_read(&self, state: &mut State, read: [f64; 2], variances: [f64; 2]) {
        let (motion, by_errors, by_reading) = truth(read, self.errors(state));
        let n_errors = state.odometer.len();
        let kept: Vec<usize> = (0..5).filter(|error| self.deviations[*error] > 0.0).collect();
        let by_state = Matrix2xX::from_fn(n_errors, |row, k| by_errors[(row, kept[k])]);
        state.forget_motion([0.0; 2]);
        (state.robot[3], state.robot[4]) = (motion[0], motion[1]);
        let noise = Matrix2::from_diagonal(&variances.into());
        let mut covariance = state.covariance.view_mut();
        let n_columns = covariance.ncols();
        let with_all = &by_state * covariance.view((ROBOT, 0), (n_errors, n_columns));
        let own = with_all.columns(ROBOT, n_errors) * by_state.transpose()
            + by_reading * noise * by_reading.transpose();
        covariance.view_mut((3, 0), (2, n_columns)).copy_from(&with_all);
        covariance.view_mut((0, 3), (n_columns, 2)).copy_from(&with_all.transpose());
        covariance.fixed_view_mut::<2, 2>(3, 3).copy_from(&((own + own.transpose()) * 0.5));
    }
}

/// Moves the robot to the time `sign` delays away, along with all that is known: -1 goes back to where a scan was taken.
/// In between the filter deals with scans as if there were no delay.
pub(super) fn shift(model: &OdometerModel, motion: &MotionModel, state: &mut State, sign: f64) {
    let delay = model.columns([0.0, 0.0, 0.0, 0.0, 1.0]).find(|(_, effect)| *effect > 0.0);
    let Some((column, _)) = delay else { return };
    let [.., delay_s] = model.errors(state);
    let (robot, by_robot) = motion.step(&state.robot, sign * delay_s);
    let by_delay = motion.by_time(&state.robot, sign * delay_s) * sign;
    state.robot = robot;
    let mut covariance = state.covariance.view_mut();
    let n_columns = covariance.ncols();
    let with_all = by_robot * covariance.view((0, 0), (ROBOT, n_columns)) + by_delay * covariance.row(column);
    let own =
        with_all.columns(0, ROBOT) * by_robot.transpose() + with_all.column(column) * by_delay.transpose();
    covariance.view_mut((0, 0), (ROBOT, n_columns)).copy_from(&with_all);
    covariance.view_mut((0, 0), (n_columns, ROBOT)).copy_from(&with_all.transpose());
    covariance.fixed_view_mut::<ROBOT, ROBOT>(0, 0).copy_from(&((own + own.transpose()) * 0.5));
}

/// What an odometer reads of a speed and a turn, and how that changes with both and with the first four errors.
pub fn reading(
    [v, omega]: [f64; 2],
    [k_v, k_omega, per_m, per_s, _]: [f64; 5],
) -> ([f64; 2], SMatrix<f64, 2, 6>) {
    let read = [(1.0 + k_v) * v, (1.0 + k_omega) * omega + per_m * v + per_s];
    let (speed, turn) = ([1.0 + k_v, 0.0, v, 0.0, 0.0, 0.0], [per_m, 1.0 + k_omega, 0.0, omega, v, 1.0]);
    (read, SMatrix::from_rows(&[speed.into(), turn.into()]))
}

/// The true speed and turn behind what an odometer reads, and how they change with the errors and with the reading.
pub fn truth(
    [speed, turn]: [f64; 2],
    [k_v, k_omega, per_m, per_s, _]: [f64; 5],
) -> ([f64; 2], SMatrix<f64, 2, 5>, Matrix2<f64>) {
    let (by_speed, by_turn) = (1.0 / (1.0 + k_v), 1.0 / (1.0 + k_omega));
    let v = speed * by_speed;
    let omega = (turn - per_m * v - per_s) * by_turn;
    let of_speed = [-v * by_speed, 0.0, 0.0, 0.0, 0.0];
    let of_turn = [per_m * v * by_speed * by_turn, -omega * by_turn, -v * by_turn, -by_turn, 0.0];
    let by_reading = Matrix2::new(by_speed, 0.0, -per_m * by_speed * by_turn, by_turn);
    ([v, omega], SMatrix::from_rows(&[of_speed.into(), of_turn.into()]), by_reading)
}
