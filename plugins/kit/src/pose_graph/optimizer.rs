//! Levenberg-Marquardt on a pose graph.

use super::graph::PoseGraph;
use super::normal_equations::NormalEquations;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::wrap_angle;

/// When to stop, and how carefully to step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OptimizeSettings {
    /// Most accepted steps.
    pub most_iterations: usize,
    /// Done when a step lowers the cost by less than this share.
    pub least_decrease: f64,
    /// Done when no pose moves by more than this, meters and radians.
    pub least_step: f64,
    /// Share by which the diagonal is raised at the beginning; 0 is Gauss-Newton as long as that goes well.
    pub first_damping: f64,
}

impl Default for OptimizeSettings {
    fn default() -> Self {
        OptimizeSettings { most_iterations: 20, least_decrease: 1e-6, least_step: 1e-7, first_damping: 0.0 }
    }
}

/// How it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OptimizeStatus {
    /// At a minimum.
    Converged,
    /// More steps would still lower the cost.
    OutOfIterations,
    /// No step lowers the cost, or the equations have no solution: the poses of the last good step.
    Degenerate,
}

/// What optimizing did.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimized {
    /// How it ended.
    pub status: OptimizeStatus,
    /// Cost before, and after each accepted step.
    pub costs: Vec<f64>,
}

impl Optimized {
    /// Cost at the end.
    pub fn cost(&self) -> f64 {
        self.costs.last().copied().unwrap_or_default()
    }
}

/// Times that a step is tried again, more carefully each time.
const MOST_REFUSALS: usize = 10;
/// The first damping after a step that did not help.
const FIRST_CARE: f64 = 1e-6;

/// Optimizes graphs, and keeps the structure of the last one: the same graph with other numbers costs less.
#[derive(Debug, Default)]
pub struct GraphOptimizer {
    equations: Option<NormalEquations>,
}

impl GraphOptimizer {
    /// Moves the poses of the graph to a minimum of its cost.
    pub fn optimize(&mut self, graph: &mut PoseGraph, settings: &OptimizeSettings) -> Optimized {
        let mut costs = vec![graph.cost()];
        self.prepare(graph);
        let Some(equations) = &mut self.equations else {
            return Optimized { status: OptimizeStatus::Converged, costs };
        };
        let mut damping = settings.first_damping;
        for _ in 0..settings.most_iterations {
            equations.linearize(graph);
            let Some(step) = accepted_step(equations, graph, &mut damping, &mut costs) else {
                let is_flat = equations.gradient.iter().all(|v| v.abs() < 1e-6);
                let status = if is_flat { OptimizeStatus::Converged } else { OptimizeStatus::Degenerate };
                return Optimized { status, costs };
            };
            let [.., before, after] = costs[..] else { break };
            if step < settings.least_step || before - after <= settings.least_decrease * before {
                return Optimized { status: OptimizeStatus::Converged, costs };
            }
        }
        Optimized { status: OptimizeStatus::OutOfIterations, costs }
    }

    /// What the graph leaves open about its poses; none where the equations have no solution.
    pub fn covariances(&mut self, graph: &PoseGraph) -> Option<Covariances<'_>> {
        self.prepare(graph);
        let equations = self.equations.as_mut()?;
        equations.linearize(graph);
        let factor = equations.factor(0.0).ok()?;
        Some(Covariances { equations, factor })
    }

    fn prepare(&mut self, graph: &PoseGraph) {
        if !self.equations.as_ref().is_some_and(|equations| equations.fits(graph)) {
            self.equations = NormalEquations::of(graph);
        }
    }
}

/// Steps until the cost is lower, more carefully each time: the largest motion of a pose, or nothing.
fn accepted_step(
    equations: &mut NormalEquations,
    graph: &mut PoseGraph,
    damping: &mut f64,
    costs: &mut Vec<f64>,
) -> Option<f64> {
    let before = costs.last().copied()?;
    for _ in 0..=MOST_REFUSALS {
        if let Ok(step) = equations.step(*damping) {
            let mut poses = moved(equations, graph, &step);
            graph.swap_poses(&mut poses);
            let cost = graph.cost();
            // At the minimum a step of rounding errors may raise the cost by one.
            if cost <= before + 1e-12 * before {
                costs.push(cost);
                *damping = if *damping <= FIRST_CARE { 0.0 } else { *damping / 10.0 };
                return Some(step.iter().fold(0.0, |most: f64, v| most.max(v.abs())));
            }
            graph.swap_poses(&mut poses);
        }
        *damping = (*damping * 10.0).max(FIRST_CARE);
    }
    None
}

fn moved(equations: &NormalEquations, graph: &PoseGraph, step: &[f64]) -> Vec<Vector3<f64>> {
    let moved = |(node, pose): (usize, &Vector3<f64>)| {
        let part = equations.column_of(node).and_then(|column| step.get(3 * column..3 * column + 3));
        let Some(&[dx, dy, turn]) = part else { return *pose };
        Vector3::new(pose.x + dx, pose.y + dy, wrap_angle(pose.z + turn))
    };
    graph.poses().iter().enumerate().map(moved).collect()
}

/// Covariances of the poses of a graph, each by a back substitution.
#[derive(Debug)]
pub struct Covariances<'a> {
    equations: &'a NormalEquations,
    factor: Llt<usize, f64>,
}

impl Covariances<'_> {
    /// Covariance of x, y, turn of one pose, in the map's axes; zero where the pose is held.
    pub fn of_pose(&self, node: usize) -> Matrix3<f64> {
        self.between(node, node)
    }

    /// Covariance of the numbers of one pose with those of another.
    pub fn between(&self, node: usize, other: usize) -> Matrix3<f64> {
        let (Some(row), Some(column)) = (self.equations.column_of(node), self.equations.column_of(other))
        else {
            return Matrix3::zeros();
        };
        let n = self.equations.gradient.len();
        let mut units = vec![0.0; 3 * n];
        for part in 0..3 {
            units[part * n + 3 * column + part] = 1.0;
        }
        self.factor.solve_in_place(faer::MatMut::from_column_major_slice_mut(&mut units, n, 3));
        Matrix3::from_fn(|part, other_part| units[other_part * n + 3 * row + part])
    }
}
