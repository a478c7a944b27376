//! A city of square blocks, against a solver of its own: dense, with slopes by finite differences, and another way to step.

use super::*;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

/// A walk of blocks of a meter with turns by quarters; a pose is tied to the one before, and to earlier ones beside it.
fn city(n: usize, noise: [f64; 2]) -> (PoseGraph, Vec<Pose2>) {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
    let (mut truth, mut graph) = (vec![pose2(0.0, 0.0, 0.0)], PoseGraph::default());
    let [noise_m, noise_rad] = noise;
    let measured = |from: &Pose2, to: &Pose2, rng: &mut Xoshiro256PlusPlus| {
        let [x, y, turn]: [f64; 3] = std::array::from_fn(|_| rng.sample(StandardNormal));
        from.inverse() * to * pose2(noise_m * x, noise_m * y, noise_rad * turn)
    };
    let information = [noise_m.powi(-2), noise_m.powi(-2), noise_rad.powi(-2)];
    graph.add_pose(&truth[0]).unwrap();
    for k in 1..n {
        let turn = if k % 3 == 0 { [-1.0, 0.0, 1.0][rng.random_range(0..3)] } else { 0.0 };
        // Back to the middle before it has gone too far.
        let is_far = truth[k - 1].translation.vector.norm() > 5.0 && k % 3 == 0;
        let turn = if is_far { 1.0 } else { turn };
        let next = truth[k - 1] * pose2(1.0, 0.0, turn * std::f64::consts::FRAC_PI_2);
        let odometry = measured(&truth[k - 1], &next, &mut rng);
        graph.add_pose(&(graph.pose(k - 1).unwrap() * odometry)).unwrap();
        graph.add(constraint(k - 1, k, odometry, information)).unwrap();
        let is_beside =
            |other: &usize| (truth[*other].translation.vector - next.translation.vector).norm() < 1.1;
        let beside: Vec<usize> = (0..k.saturating_sub(5)).filter(is_beside).take(2).collect();
        truth.push(next);
        for other in beside {
            graph.add(constraint(k, other, measured(&next, &truth[other], &mut rng), information)).unwrap();
        }
    }
    (graph, truth)
}

/// Errors of all constraints in units of their deviations, by complex numbers.
fn residuals(graph: &PoseGraph, x: &DVector<f64>) -> DVector<f64> {
    let pose = |node: usize| match node {
        0 => pose2(0.0, 0.0, 0.0),
        _ => pose2(x[3 * node - 3], x[3 * node - 2], x[3 * node - 1]),
    };
    let all = graph.constraints().iter().flat_map(|link| {
        let off = link.from_to.inverse() * pose(link.from.unwrap()).inverse() * pose(link.to);
        let error = Vector3::new(off.translation.x, off.translation.y, off.rotation.angle());
        let deviations = link.information.diagonal().map(f64::sqrt);
        error.component_mul(&deviations).data.0[0]
    });
    DVector::from_vec(all.collect())
}

/// Levenberg's method with a slope by differences: the least cost.
fn dense_cost(graph: &PoseGraph) -> f64 {
    let poses = graph.poses().iter().skip(1).flat_map(|v| [v.x, v.y, v.z]);
    let mut x = DVector::from_vec(poses.collect());
    let mut error = residuals(graph, &x);
    let mut damping = 1e-3;
    for _ in 0..60 {
        let mut slopes = DMatrix::zeros(error.len(), x.len());
        for column in 0..x.len() {
            let (mut above, mut below) = (x.clone(), x.clone());
            above[column] += 1e-6;
            below[column] -= 1e-6;
            slopes.set_column(column, &((residuals(graph, &above) - residuals(graph, &below)) / 2e-6));
        }
        let hessian = slopes.transpose() * &slopes + DMatrix::identity(x.len(), x.len()) * damping;
        let step = -hessian.cholesky().unwrap().solve(&(slopes.transpose() * &error));
        let moved = residuals(graph, &(&x + &step));
        if moved.norm_squared() > error.norm_squared() {
            damping *= 10.0;
            continue;
        }
        let is_done = step.amax() < 1e-9;
        (x, error, damping) = (x + step, moved, damping * 0.1);
        if is_done {
            break;
        }
    }
    error.norm_squared()
}

#[test]
fn from_every_start_the_least_cost_is_that_of_a_dense_solver() {
    let (graph, truth) = city(70, [0.05, 0.02]);
    assert!(graph.constraints().len() > 100, "{}", graph.constraints().len());
    let expected = dense_cost(&graph);
    for name in ["file", "tree", "chords"] {
        let mut graph = graph.clone();
        match name {
            "tree" => graph.start_from_tree(),
            "chords" => assert!(graph.start_from_chords()),
            _ => {}
        }
        let exact = OptimizeSettings { least_decrease: 1e-12, ..OptimizeSettings::default() };
        let done = GraphOptimizer::default().optimize(&mut graph, &exact);
        assert_eq!(done.status, OptimizeStatus::Converged, "{name}");
        assert!((done.cost() - expected).abs() < 1e-6 * expected, "{name}: {} for {expected}", done.cost());
        let off = |(pose, found): (&Pose2, &Vector3<f64>)| (pose.translation.vector - found.xy()).norm();
        assert!(truth.iter().zip(graph.poses()).map(off).fold(0.0, f64::max) < 0.5, "{name}");
    }
}

#[test]
fn chords_lead_to_the_least_cost_where_a_tree_ends_in_another_minimum() {
    let (graph, _) = city(400, [0.05, 0.15]);
    let least = |start: fn(&mut PoseGraph) -> bool| {
        let mut graph = graph.clone();
        start(&mut graph);
        let patient = OptimizeSettings { most_iterations: 100, ..OptimizeSettings::default() };
        GraphOptimizer::default().optimize(&mut graph, &patient).cost()
    };
    let chords = least(PoseGraph::start_from_chords);
    let drifted = least(|_| true);
    // As many squared errors of one deviation as there are numbers more than unknowns.
    let expected = 3.0 * (graph.constraints().len() - graph.n_nodes() + 1) as f64;
    assert!((chords / expected - 1.0).abs() < 0.15, "{chords} for {expected}");
    assert!(drifted > 1.1 * chords, "{drifted} from where the odometer says, {chords}");
}

#[test]
fn starts_keep_what_is_held_and_reach_what_a_prior_says() {
    let mut graph = PoseGraph::default();
    for _ in 0..6 {
        graph.add_pose(&pose2(9.0, 9.0, 0.3)).unwrap();
    }
    let step = pose2(1.0, 0.5, 2.0);
    for (from, to) in [(1, 0), (1, 2), (4, 3), (4, 5)] {
        graph.add(constraint(from, to, step, [10.0, 20.0, 30.0])).unwrap();
    }
    graph.fix(2).unwrap();
    let prior = pose2(-3.0, 4.0, -2.5);
    graph.add(Constraint { from: None, ..constraint(0, 5, prior, [1.0; 3]) }).unwrap();
    let starts: [fn(&mut PoseGraph); 2] = [PoseGraph::start_from_tree, |graph| {
        assert!(graph.start_from_chords());
    }];
    let held = graph.pose(2).unwrap();
    for start in starts {
        let mut graph = graph.clone();
        start(&mut graph);
        let truth = [held * step.inverse() * step, held * step.inverse(), held];
        let more = [prior * step.inverse() * step, prior * step.inverse(), prior];
        for (node, pose) in truth.iter().chain(&more).enumerate() {
            let off = pose.inverse() * graph.pose(node).unwrap();
            assert!(off.translation.vector.norm() + off.rotation.angle().abs() < 1e-9, "{node}: {off:?}");
        }
        assert!(graph.cost() < 1e-15);
    }
}
