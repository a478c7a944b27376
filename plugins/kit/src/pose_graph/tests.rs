//! Against the vectors of the specification, finite differences, and dense algebra on generated graphs.

mod files;
mod generated;
mod manhattan;
mod vectors;

use super::*;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2};

fn constraint(from: usize, to: usize, from_to: Pose2, diagonal: [f64; 3]) -> Constraint {
    Constraint {
        from: Some(from),
        to,
        from_to,
        information: Matrix3::from_diagonal(&Vector3::from(diagonal)),
        kernel: RobustKernel::Quadratic,
    }
}

#[test]
fn what_makes_no_sense_is_named_and_changes_nothing() {
    let mut graph = PoseGraph::default();
    assert_eq!(graph.add_pose(&pose2(f64::NAN, 0.0, 0.0)), Err(GraphFault::NotFinite));
    for k in 0..2 {
        assert_eq!(graph.add_pose(&pose2(f64::from(k), 0.0, 0.0)), Ok(k as usize));
    }
    let fine = constraint(0, 1, pose2(1.0, 0.0, 0.0), [1.0; 3]);
    let cases = [
        (Constraint { to: 2, ..fine }, GraphFault::UnknownNode { node: 2, n_nodes: 2 }),
        (Constraint { from: Some(7), ..fine }, GraphFault::UnknownNode { node: 7, n_nodes: 2 }),
        (Constraint { from: Some(1), ..fine }, GraphFault::SelfEdge { node: 1 }),
        (Constraint { from_to: pose2(0.0, f64::INFINITY, 0.0), ..fine }, GraphFault::NotFinite),
        (Constraint { information: Matrix3::identity() * f64::NAN, ..fine }, GraphFault::NotFinite),
        (Constraint { information: -Matrix3::identity(), ..fine }, GraphFault::Indefinite { least: -1.0 }),
        (Constraint { kernel: RobustKernel::Cauchy { c: 0.0 }, ..fine }, GraphFault::Kernel),
    ];
    for (wrong, fault) in cases {
        assert_eq!(graph.add(wrong), Err(fault));
    }
    assert!(graph.constraints().is_empty());
    assert_eq!(graph.fix(2), Err(GraphFault::UnknownNode { node: 2, n_nodes: 2 }));
    let nothing_to_do = GraphOptimizer::default().optimize(&mut graph, &OptimizeSettings::default());
    assert_eq!((nothing_to_do.status, nothing_to_do.cost()), (OptimizeStatus::Converged, 0.0));
}

#[test]
fn each_part_of_a_graph_is_held_by_its_first_pose_or_by_what_holds_it_already() {
    let mut graph = PoseGraph::default();
    for k in 0..7 {
        graph.add_pose(&pose2(f64::from(k) * 0.9, 0.1, 0.05)).unwrap();
    }
    for (from, to) in [(0, 1), (2, 3), (4, 5), (5, 6)] {
        graph.add(constraint(from, to, pose2(1.0, 0.0, 0.0), [10.0; 3])).unwrap();
    }
    graph.fix(3).unwrap();
    let prior = pose2(20.0, 5.0, 1.0);
    graph.add(Constraint { from: None, ..constraint(0, 5, prior, [1.0; 3]) }).unwrap();
    let before = graph.clone();
    let done = GraphOptimizer::default().optimize(&mut graph, &OptimizeSettings::default());
    assert!(done.status == OptimizeStatus::Converged && done.cost() < 1e-15, "{done:?}");
    assert_eq!(graph.pose(0), before.pose(0));
    assert_eq!(graph.pose(3), before.pose(3));
    let near = |node: usize, pose: Pose2| {
        let off = graph.pose(node).unwrap().inverse() * pose;
        assert!(off.translation.vector.norm() + off.rotation.angle().abs() < 1e-7, "{node}");
    };
    near(5, prior);
    near(6, prior * pose2(1.0, 0.0, 0.0));
    near(2, before.pose(3).unwrap() * pose2(-1.0, 0.0, 0.0));
}

#[test]
fn slopes_and_weights_are_those_of_finite_differences() {
    let link = constraint(0, 1, pose2(0.8, -0.3, 2.9), [1.0; 3]);
    let (from, to) = (Vector3::new(1.0, 2.0, -2.5), Vector3::new(1.7, 2.4, 0.7));
    let line = link.linearize(&from, &to);
    let step = 1e-6;
    for part in 0..3 {
        let mut shift = Vector3::zeros();
        shift[part] = step;
        let by_from = (link.error(&(from + shift), &to) - link.error(&(from - shift), &to)) / (2.0 * step);
        let by_to = (link.error(&from, &(to + shift)) - link.error(&from, &(to - shift))) / (2.0 * step);
        assert!((by_from - line.by_from.column(part)).amax() < 1e-8, "from {part}");
        assert!((by_to - line.by_to.column(part)).amax() < 1e-8, "to {part}");
    }
    let kernels = [
        RobustKernel::Quadratic,
        RobustKernel::Huber { c: 1.3 },
        RobustKernel::Cauchy { c: 0.7 },
        RobustKernel::GemanMcClure { c: 3.0 },
    ];
    for kernel in kernels {
        for s in [0.01, 0.5, 1.6, 1.8, 30.0, 1e4] {
            let step = 1e-5 * s;
            let slope = (kernel.cost(s + step) - kernel.cost(s - step)) / (2.0 * step);
            assert!((slope - kernel.weight(s)).abs() < 1e-7, "{kernel:?} at {s}");
        }
    }
}
