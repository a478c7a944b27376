//! Larger graphs: a robot that drives rounds, with closed loops.

use super::*;
use nalgebra::{DMatrix, DVector};

/// Numbers that look like chance, between -0.5 and 0.5.
fn scattered(k: usize, by: f64) -> f64 {
    (k as f64 * by).fract() - 0.5
}

/// Rounds of 20 poses; each pose is tied to the one before and to that of the round before. Gives the truth too.
fn rounds(n: usize, noise: f64) -> (PoseGraph, Vec<Pose2>) {
    let at = |k: usize| {
        let angle = k as f64 * std::f64::consts::TAU / 20.0;
        pose2(4.0 * angle.cos(), 4.0 * angle.sin(), angle + 1.5)
    };
    let truth: Vec<Pose2> = (0..n).map(at).collect();
    let mut graph = PoseGraph::default();
    let mut guess = truth[0];
    let measured = |from: usize, to: usize, k: usize| {
        let off =
            pose2(noise * scattered(k, 0.618), noise * scattered(k, 0.7549), noise * scattered(k, 0.5698));
        truth[from].inverse() * truth[to] * off
    };
    graph.add_pose(&guess).unwrap();
    for k in 1..n {
        let link = constraint(k - 1, k, measured(k - 1, k, 2 * k), [100.0, 80.0, 300.0]);
        guess *= link.from_to;
        graph.add_pose(&guess).unwrap();
        graph.add(link).unwrap();
        if k >= 20 {
            // From the newer to the older: blocks below the diagonal too.
            graph.add(constraint(k, k - 20, measured(k, k - 20, 2 * k + 1), [40.0, 60.0, 90.0])).unwrap();
        }
    }
    (graph, truth)
}

#[test]
fn exact_measurements_give_the_truth_back_from_a_bad_guess() {
    let (mut graph, truth) = rounds(80, 0.0);
    for (node, pose) in truth.iter().enumerate().skip(1) {
        let off = pose2(scattered(node, 0.618), scattered(node, 0.75), 0.4 * scattered(node, 0.33));
        graph.set_pose(node, &(pose * off)).unwrap();
    }
    let done = GraphOptimizer::default().optimize(&mut graph, &OptimizeSettings::default());
    assert!(done.cost() < 1e-9, "{done:?}");
    for (node, pose) in truth.iter().enumerate() {
        let off = pose.inverse() * graph.pose(node).unwrap();
        assert!(off.translation.vector.norm() < 1e-5, "{node}");
    }
}

#[test]
fn the_sparse_step_and_covariances_are_those_of_dense_algebra() {
    let (mut graph, _) = rounds(50, 0.1);
    let n = 3 * (graph.n_nodes() - 1);
    let (mut dense, mut pull) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
    for link in graph.constraints() {
        let line = link.linearize(&graph.poses()[link.from.unwrap()], &graph.poses()[link.to]);
        let mut slopes = DMatrix::<f64>::zeros(3, n);
        for (node, by) in [(link.from.unwrap(), line.by_from), (link.to, line.by_to)] {
            if node > 0 {
                slopes.view_mut((0, 3 * (node - 1)), (3, 3)).copy_from(&by);
            }
        }
        let information = DMatrix::from_iterator(3, 3, link.information.iter().copied());
        dense += slopes.transpose() * &information * &slopes;
        pull += slopes.transpose() * information * DVector::from_iterator(3, line.error.iter().copied());
    }
    let inverse = dense.try_inverse().unwrap();
    let before = graph.poses().to_vec();
    let mut optimizer = GraphOptimizer::default();
    let covariances = optimizer.covariances(&graph).unwrap();
    for (node, other) in [(1, 1), (30, 30), (49, 12), (7, 44)] {
        let expected = inverse.view((3 * (node - 1), 3 * (other - 1)), (3, 3)).into_owned();
        let found = covariances.between(node, other);
        assert!(found.iter().zip(expected.iter()).all(|(a, b)| (a - b).abs() < 1e-9), "{node}, {other}");
    }
    let step = -&inverse * pull;
    let one = OptimizeSettings { most_iterations: 1, ..OptimizeSettings::default() };
    optimizer.optimize(&mut graph, &one);
    for (node, (pose, was)) in graph.poses().iter().zip(&before).enumerate().skip(1) {
        let moved = pose - was;
        let expected = step.fixed_rows::<3>(3 * (node - 1)).into_owned();
        let off = (moved - expected).map(rumbo_core::frames::wrap_angle);
        assert!(off.amax() < 1e-8, "{node}: {moved} for {expected}");
    }
}

#[test]
fn the_end_is_a_minimum_and_the_same_from_a_new_optimizer() {
    let (mut graph, truth) = rounds(200, 0.05);
    let (mut again, mut optimizer) = (graph.clone(), GraphOptimizer::default());
    let settings = OptimizeSettings { least_decrease: 1e-12, ..OptimizeSettings::default() };
    let done = optimizer.optimize(&mut graph, &settings);
    assert_eq!(done.status, OptimizeStatus::Converged);
    assert!(done.costs.windows(2).all(|pair| pair[1] <= pair[0] * (1.0 + 1e-12)), "{:?}", done.costs);
    GraphOptimizer::default().optimize(&mut again, &settings);
    assert_eq!(graph, again, "to the bit");
    for node in (1..200).step_by(13) {
        for shift in [pose2(1e-4, 0.0, 0.0), pose2(0.0, -1e-4, 0.0), pose2(0.0, 0.0, 1e-4)] {
            let mut moved = graph.clone();
            moved.set_pose(node, &(graph.pose(node).unwrap() * shift)).unwrap();
            assert!(moved.cost() > graph.cost(), "{node}");
        }
        let off = truth[node].inverse() * graph.pose(node).unwrap();
        assert!(off.translation.vector.norm() < 0.25, "{node}: {}", off.translation.vector.norm());
    }
}
