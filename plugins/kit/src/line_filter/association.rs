//! Which wall of the map a seen line is (section 2.4 of the source).

use super::joint::compatible;
use super::sighting::{PredictedLine, Viewpoint};
use super::state::State;
use super::update::Row;
use super::wall::{Axes, Wall};
use crate::lines::SensedLine;
use nalgebra::{Matrix2, SMatrix};

/// When a line is a wall of the map. The source has one limit for the innovation's norm; its two numbers have different
/// units, and so two limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gates {
    /// Largest squared Mahalanobis distance (eta); 9.0 keeps 98.9 % of the right pairs.
    pub distance2: f64,
    /// A robot farther behind a wall than this does not see it, meters.
    pub behind_m: f64,
    /// Largest innovation of the distance, meters.
    pub distance_m: f64,
    /// Largest innovation of the normal, radians.
    pub normal_rad: f64,
    /// Largest gap along the line, meters (l_max).
    pub gap_m: f64,
    /// Pairs must fit together, too, not only each by itself.
    pub joint: bool,
}

impl Default for Gates {
    fn default() -> Self {
        Gates {
            distance2: 9.0,
            behind_m: 0.3,
            distance_m: 0.8,
            normal_rad: 20f64.to_radians(),
            gap_m: 1.0,
            joint: false,
        }
    }
}

/// A line that is a wall.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Which line of the scan.
    pub seen: usize,
    /// Which wall of the map.
    pub wall: usize,
    /// Their squared Mahalanobis distance.
    pub distance2: f64,
}

/// z^T S⁻¹ z of two numbers; infinite where S is no covariance.
pub(super) fn mahalanobis2(z: [f64; 2], s: &Matrix2<f64>) -> f64 {
    let determinant = s[(0, 0)] * s[(1, 1)] - s[(0, 1)] * s[(1, 0)];
    if !(s[(0, 0)] > 0.0 && determinant > 0.0) {
        return f64::INFINITY;
    }
    let square = z[0] * z[0] * s[(1, 1)] - 2.0 * z[0] * z[1] * s[(0, 1)] + z[1] * z[1] * s[(0, 0)];
    square / determinant
}

/// Each seen line with its wall: the nearest one, or that of the best set of pairs that fit together. Several lines may be
/// pieces of one wall.
pub(super) fn associate(
    state: &State,
    walls: &[Wall],
    view: &Viewpoint,
    seen: &[SensedLine],
    gates: &Gates,
) -> Vec<Match> {
    let passing = passing(state, walls, view, seen, gates);
    if gates.joint {
        return compatible(state, view, seen, &passing, gates.distance2);
    }
    let mut nearest: Vec<Option<Match>> = vec![None; seen.len()];
    for found in passing {
        if let Some(place) = nearest.get_mut(found.seen)
            && place.is_none_or(|other| found.distance2 < other.distance2)
        {
            *place = Some(found);
        }
    }
    nearest.into_iter().flatten().collect()
}

/// All pairs of a line and a wall within the gates.
fn passing(
    state: &State,
    walls: &[Wall],
    view: &Viewpoint,
    seen: &[SensedLine],
    gates: &Gates,
) -> Vec<Match> {
    let ends_m: Vec<[[f64; 2]; 2]> =
        seen.iter().map(|line| line.ends_m.map(|end| view.in_map(end))).collect();
    let mut passing = Vec::new();
    for (wall, (line, piece)) in state.walls.iter().zip(walls).enumerate() {
        let predicted = PredictedLine::from(view, *line);
        if predicted.distance_m < -gates.behind_m {
            continue;
        }
        let axes = Axes::new(*line);
        let mut own = None;
        for (idx, (line, ends_m)) in seen.iter().zip(&ends_m).enumerate() {
            let z = predicted.innovation(line);
            let is_near = z[0].abs() <= gates.distance_m && z[1].abs() <= gates.normal_rad;
            if !is_near || axes.gap_m(&piece.ends_m, ends_m) > gates.gap_m {
                continue;
            }
            let own = *own.get_or_insert_with(|| expected_covariance(state, wall, &predicted));
            let [rho2, both, phi2] = line.covariance;
            let distance2 = mahalanobis2([z[0], z[1]], &(own + Matrix2::new(rho2, both, both, phi2)));
            if distance2 <= gates.distance2 {
                passing.push(Match { seen: idx, wall, distance2 });
            }
        }
    }
    passing
}

/// H P H^T of what should be seen of a wall.
fn expected_covariance(state: &State, wall: usize, predicted: &PredictedLine) -> Matrix2<f64> {
    let cross = state.robot_with(wall).fixed_rows::<3>(0).into_owned();
    let robot: &SMatrix<f64, 2, 3> = &predicted.by_robot;
    let mixed = robot * cross * predicted.by_wall.transpose();
    robot * state.pose_covariance() * robot.transpose()
        + mixed
        + mixed.transpose()
        + predicted.by_wall * state.between(wall, wall) * predicted.by_wall.transpose()
}

/// The measurement of all matches of a scan.
pub(super) fn rows_of(state: &State, view: &Viewpoint, seen: &[SensedLine], matches: &[Match]) -> Vec<Row> {
    let rows = |found: &Match| {
        let (line, seen) = (state.walls.get(found.wall)?, seen.get(found.seen)?);
        Some(PredictedLine::from(view, *line).rows(state.column_of(found.wall), seen))
    };
    matches.iter().filter_map(rows).flatten().collect()
}
