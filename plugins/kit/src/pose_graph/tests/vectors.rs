//! Five poses with a loop, and one false loop.

use super::*;
use serde_json::Value;

const TOLERANCE: f64 = 1e-6;

fn file() -> Value {
    serde_json::from_str(include_str!("../../../tests/data/slam3d_pose_graph_se2.json")).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn triple(value: &Value) -> Vector3<f64> {
    Vector3::from_iterator(value.as_array().unwrap().iter().map(number))
}

fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_row_iterator(
        value.as_array().unwrap().iter().flat_map(|row| row.as_array().unwrap()).map(number),
    )
}

fn edge(value: &Value) -> Constraint {
    let node = |key: &str| value[key].as_u64().unwrap() as usize;
    let z = triple(&value["z"]);
    constraint(node("i"), node("j"), pose2(z.x, z.y, z.z), triple(&value["information_diag"]).into())
}

fn graph(file: &Value) -> PoseGraph {
    let mut graph = PoseGraph::default();
    for pose in file["initial"].as_array().unwrap() {
        let v = triple(pose);
        graph.add_pose(&pose2(v.x, v.y, v.z)).unwrap();
    }
    for value in file["edges"].as_array().unwrap() {
        graph.add(edge(value)).unwrap();
    }
    graph
}

fn near(found: &Vector3<f64>, expected: &Vector3<f64>, what: &str) {
    assert!((found - expected).amax() < TOLERANCE, "{what}: {found} for {expected}");
}

#[test]
fn errors_slopes_and_the_first_step_are_those_of_the_vector() {
    let file = file();
    let mut graph = graph(&file);
    for (row, link) in file["jacobians_at_initial"].as_array().unwrap().iter().zip(graph.constraints()) {
        let poses = graph.poses();
        let line = link.linearize(&poses[link.from.unwrap()], &poses[link.to]);
        near(&line.error, &triple(&row["error_at_initial"]), "error");
        assert!((line.by_from - matrix(&row["A_d_i"])).amax() < TOLERANCE, "{row}");
        assert!((line.by_to - matrix(&row["B_d_j"])).amax() < TOLERANCE, "{row}");
    }
    let before = graph.poses().to_vec();
    let one = OptimizeSettings { most_iterations: 1, ..OptimizeSettings::default() };
    GraphOptimizer::default().optimize(&mut graph, &one);
    let deltas = file["first_gauss_newton_delta_nodes_1_to_4"].as_array().unwrap();
    for (node, delta) in (1..).zip(deltas) {
        near(&(graph.poses()[node] - before[node]), &triple(delta), "first step");
    }
}

#[test]
fn costs_optimum_and_covariance_are_those_of_the_vector() {
    let file = file();
    let mut graph = graph(&file);
    let exact = OptimizeSettings { least_decrease: 0.0, ..OptimizeSettings::default() };
    let mut optimizer = GraphOptimizer::default();
    let done = optimizer.optimize(&mut graph, &exact);
    assert_eq!(done.status, OptimizeStatus::Converged);
    for (found, expected) in done.costs.iter().zip(file["chi2_per_iteration"].as_array().unwrap()) {
        assert!((found - number(expected)).abs() < TOLERANCE, "{found} for {expected}");
    }
    assert!((done.cost() - number(&file["chi2_optimum"])).abs() < TOLERANCE);
    for (pose, expected) in graph.poses().iter().zip(file["optimum"].as_array().unwrap()) {
        near(pose, &triple(expected), "optimum");
    }
    let covariances = optimizer.covariances(&graph).unwrap();
    let off = covariances.of_pose(4) - matrix(&file["covariance_node4"]);
    assert!(off.amax() < TOLERANCE, "{off}");
    assert_eq!(covariances.of_pose(0), Matrix3::zeros());
}

#[test]
fn a_false_loop_bends_the_map_as_far_as_the_vector_says() {
    let file = file();
    let (row, optimum) = (&file["false_loop_closure"], &file["optimum"]);
    let shift_with = |kernel: RobustKernel| {
        let mut plain = graph(&file);
        GraphOptimizer::default().optimize(&mut plain, &OptimizeSettings::default());
        // The vector's figures are those of a kernel on every edge, not only on the false one.
        let mut graph = plain.clone();
        graph.retain(|_| false);
        for link in plain.constraints().iter().copied().chain([edge(&row["extra_edge"])]) {
            graph.add(Constraint { kernel, ..link }).unwrap();
        }
        let patient =
            OptimizeSettings { most_iterations: 500, least_decrease: 1e-14, ..OptimizeSettings::default() };
        GraphOptimizer::default().optimize(&mut graph, &patient);
        let shifts = graph.poses().iter().zip(optimum.as_array().unwrap());
        let shift_m = shifts.map(|(pose, was)| (pose.xy() - triple(was).xy()).norm()).fold(0.0, f64::max);
        (shift_m, graph)
    };
    let shifts = &row["max_position_shift_m"];
    for (key, kernel, tolerance) in [
        ("plain", RobustKernel::Quadratic, 1e-5),
        ("huber_c1", RobustKernel::Huber { c: 1.0 }, 1e-4),
        ("geman_mcclure_c3", RobustKernel::GemanMcClure { c: 3.0 }, 1e-6),
    ] {
        let (shift_m, graph) = shift_with(kernel);
        assert!((shift_m - number(&shifts[key])).abs() < tolerance, "{key}: {shift_m}");
        if key == "geman_mcclure_c3" {
            for (pose, expected) in
                graph.poses().iter().zip(row["optimum_geman_mcclure_c3"].as_array().unwrap())
            {
                near(pose, &triple(expected), "optimum with a kernel");
            }
        }
    }
}
