//! One filter over one drive, and how well it did.

use super::metrics::map_offset_m;
use super::{BASE_S, SCAN_EVERY, Step, hall};
use nalgebra::{Matrix5, Vector3, Vector5};
use rumbo_core::frames::wrap_angle;
use rumbo_kit::line_filter::{FilterSettings, LineFilter, Mount, ROBOT, State, WallMap};

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// The walls are known.
    KnownMap,
    /// Every sensor at its own rate.
    MultiRate,
    /// Every sensor at the laser's.
    SingleRate,
}

/// A filter.
#[derive(Debug, Clone)]
pub struct Setup {
    pub mode: Mode,
    pub settings: FilterSettings,
}

/// What came out, over all scans.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    pub position_rmse_m: f64,
    pub max_error_m: f64,
    pub heading_rmse_rad: f64,
    pub nees: f64,
    pub n_walls: usize,
    pub map_offset_m: f64,
    pub line_nis: f64,
    /// Largest rise of a wall's standard deviation from one scan to the next.
    pub largest_rise: f64,
    /// Symmetric and positive definite, looked at after every tenth scan.
    pub is_covariance_fine: bool,
    /// More than three times as many walls as there are, farther off than 2 m, or not finite.
    pub is_unstable: bool,
    pub final_robot: [f64; 5],
    pub n_slips: usize,
}

/// Three times the 28 true lines.
const TOO_MANY_WALLS: usize = 84;

fn started(setup: &Setup, steps: &[Step]) -> LineFilter {
    let [x, y, theta] = steps[0].truth.unwrap();
    let robot = Vector5::new(x, y, theta, 0.0, 0.0);
    let covariance = Matrix5::from_diagonal(&Vector5::new(1e-6, 1e-6, 1e-6, 1e-4, 1e-4));
    if setup.mode == Mode::KnownMap {
        let map = WallMap::new(&hall().lines);
        return LineFilter::on_map(setup.settings.clone(), robot, &covariance, &map);
    }
    LineFilter::building(setup.settings.clone(), robot, &covariance)
}

/// Variances of the walls' numbers.
fn wall_variances(state: &State) -> Vec<f64> {
    state.covariance.view().diagonal().iter().skip(ROBOT).copied().collect()
}

/// Sums over scans.
#[derive(Default)]
struct Sums {
    n: f64,
    square_m2: f64,
    square_rad2: f64,
    nees: f64,
    nis: f64,
    n_nis: f64,
}

/// Drives a filter through the steps.
pub fn run(setup: &Setup, steps: &[Step]) -> Outcome {
    let mut filter = started(setup, steps);
    let every = if setup.mode == Mode::SingleRate { SCAN_EVERY } else { 1 };
    let mut outcome = Outcome { is_covariance_fine: true, ..Outcome::default() };
    let mut sums = Sums::default();
    let mut variances = wall_variances(filter.state());
    for (k, step) in steps.iter().enumerate().step_by(every) {
        if k > 0 {
            filter.predict(BASE_S * every as f64);
        }
        if let Some(wheels) = step.wheels {
            let reading = filter.read_wheels(wheels);
            outcome.n_slips += usize::from(matches!(reading, rumbo_kit::line_filter::Reading::Slipping(_)));
        }
        if let Some(angle) = step.steering {
            filter.read_steering(angle);
        }
        if let Some(lines) = &step.lines {
            let report = filter.read_lines(lines, &Mount::default());
            sums.nis += report.matches.iter().map(|found| found.distance2).sum::<f64>();
            sums.n_nis += report.matches.len() as f64;
        }
        if k.is_multiple_of(SCAN_EVERY) {
            measure(&mut sums, &mut outcome, &filter, step.truth.unwrap());
            variances = rise(&mut outcome, &filter, &variances);
            if (k / SCAN_EVERY).is_multiple_of(10) {
                outcome.is_covariance_fine &= is_covariance(&filter);
            }
            if outcome.is_unstable {
                break;
            }
        }
    }
    outcome.position_rmse_m = (sums.square_m2 / sums.n).sqrt();
    outcome.heading_rmse_rad = (sums.square_rad2 / sums.n).sqrt();
    outcome.nees = sums.nees / sums.n;
    outcome.line_nis = sums.nis / sums.n_nis;
    outcome.n_walls = filter.walls().len();
    outcome.map_offset_m = map_offset_m(&filter.layer(), &hall());
    outcome.final_robot = filter.state().robot.into();
    outcome
}

fn measure(sums: &mut Sums, outcome: &mut Outcome, filter: &LineFilter, truth: [f64; 3]) {
    let robot = filter.state().robot;
    let error = Vector3::new(robot[0] - truth[0], robot[1] - truth[1], wrap_angle(robot[2] - truth[2]));
    let error_m = error[0].hypot(error[1]);
    outcome.max_error_m = outcome.max_error_m.max(error_m);
    outcome.is_unstable |=
        filter.walls().len() > TOO_MANY_WALLS || error_m > 2.0 || !filter.state().is_finite();
    sums.n += 1.0;
    sums.square_m2 += error_m * error_m;
    sums.square_rad2 += error[2] * error[2];
    sums.nees += filter.state().pose_covariance().try_inverse().map_or(f64::NAN, |s| error.dot(&(s * error)));
}

/// No wall may become less sure: new ones are at the end, and none goes while walls are not merged.
fn rise(outcome: &mut Outcome, filter: &LineFilter, before: &[f64]) -> Vec<f64> {
    let after = wall_variances(filter.state());
    for (after, before) in after.iter().zip(before) {
        outcome.largest_rise = outcome.largest_rise.max(after.sqrt() - before.sqrt());
    }
    after
}

/// Symmetric to the bit, and positive definite.
fn is_covariance(filter: &LineFilter) -> bool {
    let covariance = filter.state().covariance.view().into_owned();
    let is_symmetric = covariance == covariance.transpose();
    // A known map has no variance of its own: its part of the matrix is zero.
    let is_known = covariance.diagonal().iter().skip(ROBOT).all(|v| *v == 0.0);
    let moving = if is_known { covariance.view((0, 0), (ROBOT, ROBOT)).into_owned() } else { covariance };
    is_symmetric && nalgebra::Cholesky::new(moving).is_some()
}
