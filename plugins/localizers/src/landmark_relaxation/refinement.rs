//! The pose beyond the size of a cell, where the source stops: least squares of the distances of beam ends from the
//! surfaces that the map lets expect, by Gauss and Newton with Tukey's weights.
//!
//! Unknowns are x, y and heading at the newest scan, and for every older scan how far the odometer misjudged the turn
//! since. Surfaces are traced anew at every step, to the edges of cells.

use super::matching::Knowledge;
use super::sighting::Beam;
use super::traced_beams::{Comparison, TracedBeams};
use nalgebra::{DMatrix, DVector, Matrix3};
use rumbo_core::frames::{Pose2, wrap_angle};

/// What the errors are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RefinementSettings {
    /// Standard deviation of a range, meters.
    pub range_deviation_m: f64,
    /// Standard deviation of a surface of the map, meters.
    pub map_deviation_m: f64,
    /// Standard deviation of a turn by the odometer for each radian turned.
    pub turn_deviation: f64,
}

/// A pose beyond the size of a cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Refined {
    /// The robot.
    pub map_from_base: Pose2,
    /// How far the odometer misjudged the turn since each scan, radians; zero for the newest.
    pub turns_rad: Vec<f64>,
    /// Covariance of x, y, heading in the map's axes.
    pub covariance: Matrix3<f64>,
}

/// Ends farther than this from their surface say nothing, from step to step, meters.
const GATES_M: [f64; 8] = [0.40, 0.40, 0.30, 0.20, 0.15, 0.10, 0.10, 0.10];
/// A beam that grazes its surface says little: smallest cosine.
const LEAST_COSINE: f64 = 0.17;
/// The odometer misjudges a turn by this much at least, radians (half a degree).
const LEAST_TURN_RAD: f64 = 0.009;
/// Neighboring beams meet the same wall, whose error on the map they share: so many of them count as one.
const BEAMS_PER_ERROR: f64 = 16.0;
/// What beams scatter by tells more of their errors than what was believed before, within these factors of the variance.
const SCATTER: [f64; 2] = [0.25, 25.0];
/// Without a single beam the pose is as unsure as the cell it came from: meters, and radians.
const PRIOR_DEVIATION: [f64; 3] = [0.10, 0.10, 0.10];

/// Refines a pose. It moves where beams say so only.
pub fn refine(
    known: &Knowledge,
    beams: &TracedBeams,
    start: &Pose2,
    settings: &RefinementSettings,
) -> Refined {
    let n_turns = beams.n_scans().saturating_sub(1);
    let mut refined = Refined {
        map_from_base: *start,
        turns_rad: vec![0.0; beams.n_scans()],
        covariance: Matrix3::zeros(),
    };
    let deviation_m = settings.range_deviation_m.hypot(settings.map_deviation_m);
    let turn_deviations: Vec<f64> =
        beams.turns_rad().map(|turn| LEAST_TURN_RAD.max(settings.turn_deviation * turn.abs())).collect();
    for gate_m in GATES_M {
        let comparisons = beams.compare(known, &refined.map_from_base, &refined.turns_rad);
        let mut system = System::new(3 + n_turns, start, &refined, &turn_deviations);
        for comparison in &comparisons {
            system.add(comparison, &refined.map_from_base, gate_m, deviation_m);
        }
        let Some(step) = system.solved(&mut refined.covariance) else { break };
        let pose = &refined.map_from_base;
        refined.map_from_base = Pose2::new(
            pose.translation.vector + nalgebra::Vector2::new(step[0], step[1]),
            wrap_angle(pose.rotation.angle() + step[2]),
        );
        for (turn, by) in refined.turns_rad.iter_mut().zip(step.iter().skip(3)) {
            *turn += by;
        }
    }
    refined
}

/// The normal equations.
struct System {
    hessian: DMatrix<f64>,
    gradient: DVector<f64>,
    /// Sum of weights, and of weighted squares in terms of the expected variance.
    scatter: [f64; 2],
}

impl System {
    /// Starts from what is known without beams.
    fn new(n: usize, start: &Pose2, now: &Refined, turn_deviations: &[f64]) -> System {
        let mut system =
            System { hessian: DMatrix::zeros(n, n), gradient: DVector::zeros(n), scatter: [0.0; 2] };
        let way = start.translation.vector - now.map_from_base.translation.vector;
        let turned = wrap_angle(start.rotation.angle() - now.map_from_base.rotation.angle());
        let turns = now.turns_rad.iter().map(|turn| -turn);
        let pulls = [way.x, way.y, turned].into_iter().chain(turns);
        let deviations = PRIOR_DEVIATION.iter().chain(turn_deviations);
        for (idx, (pull, deviation)) in pulls.zip(deviations).take(n).enumerate() {
            system.hessian[(idx, idx)] = deviation.powi(-2);
            system.gradient[idx] = pull * deviation.powi(-2);
        }
        system
    }

    fn add(&mut self, comparison: &Comparison, map_from_base: &Pose2, gate_m: f64, deviation_m: f64) {
        let (Beam::Hit(range_m), Some([nx, ny])) = (comparison.beam, comparison.normal) else { return };
        let [x, y] = comparison.direction;
        let cosine = nx * x + ny * y;
        let off_m = (range_m - comparison.expected_m) * cosine;
        if cosine.abs() < LEAST_COSINE || !off_m.is_finite() || off_m.abs() >= gate_m {
            return;
        }
        let share = (1.0 - (off_m / gate_m).powi(2)).powi(2);
        self.scatter[0] += share;
        self.scatter[1] += share * (off_m / deviation_m).powi(2);
        let weight = share / (deviation_m * deviation_m * BEAMS_PER_ERROR);
        // Turning moves the end across its way from the center of the turn.
        let by_turn = |center_x: f64, center_y: f64| {
            ny * (comparison.end.x - center_x) - nx * (comparison.end.y - center_y)
        };
        let base = map_from_base.translation.vector;
        let mut row = [0.0; 4];
        row[..3].copy_from_slice(&[nx, ny, by_turn(base.x, base.y)]);
        row[3] = by_turn(comparison.base.x, comparison.base.y);
        let own_turn = 3 + comparison.scan;
        let n_used = if own_turn < self.gradient.len() { 4 } else { 3 };
        let column = |idx: usize| if idx < 3 { idx } else { own_turn };
        for (i, a) in row.iter().take(n_used).enumerate() {
            self.gradient[column(i)] -= weight * a * off_m;
            for (k, b) in row.iter().take(n_used).enumerate() {
                self.hessian[(column(i), column(k))] += weight * a * b;
            }
        }
    }

    /// The step, and the covariance of the pose.
    fn solved(self, covariance: &mut Matrix3<f64>) -> Option<DVector<f64>> {
        let inverse = self.hessian.cholesky()?.inverse();
        let pose = inverse.fixed_view::<3, 3>(0, 0).into_owned();
        let [weights, squares] = self.scatter;
        let factor = if weights > 1.0 { (squares / weights).clamp(SCATTER[0], SCATTER[1]) } else { 1.0 };
        *covariance = (pose + pose.transpose()) * (factor / 2.0);
        let step = inverse * self.gradient;
        step.iter().all(|part| part.is_finite()).then_some(step)
    }
}
