//! The numbers of the specification.

use super::super::*;
use super::close;
use super::twin::Twin;
use crate::GridSize;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Point2, Pose2, pose2};
use serde_json::Value;

fn load(name: &str) -> Value {
    let path = format!("{}/tests/data/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap_or(f64::NAN)).collect()
}

fn matrix(value: &Value) -> Matrix3<f64> {
    Matrix3::from_fn(|row, col| value[row][col].as_f64().unwrap())
}

fn vector(value: &Value) -> Vector3<f64> {
    Vector3::from_vec(numbers(value))
}

fn pose(value: &Value) -> Pose2 {
    let [x, y, yaw] = numbers(value).try_into().unwrap();
    pose2(x, y, yaw)
}

/// The grid of a file for the twin, and as log-odds for the fast path.
fn grids(file: &Value) -> (Twin, Vec<f32>, GridSize) {
    let grid = &file["grid"];
    let p: Vec<f64> = grid["p"].as_array().unwrap().iter().flat_map(numbers).collect();
    let (width, height) =
        (grid["width"].as_u64().unwrap() as usize, grid["height"].as_u64().unwrap() as usize);
    let origin = numbers(&grid["origin_m"]);
    let twin = Twin {
        width,
        height,
        resolution_m: grid["resolution_m"].as_f64().unwrap(),
        level_from_map: pose2(origin[0], origin[1], 0.0).inverse(),
        is_touched: vec![true; p.len()],
        p,
    };
    let cells = twin.p.iter().map(|p| (p / (1.0 - p)).ln() as f32).collect();
    (twin, cells, GridSize::new(width, height))
}

#[test]
fn values_and_gradients_are_those_of_the_specification() {
    let file = load("slam2d_bilinear_gradient");
    let (twin, cells, size) = grids(&file);
    let level = GridLevel::new(&cells, size, twin.resolution_m, twin.level_from_map).unwrap();
    for case in file["cases"].as_array().unwrap() {
        let [x, y] = numbers(&case["point_m"]).try_into().unwrap();
        let (value, gradient, _) = twin.value(Point2::new(x, y)).unwrap();
        let expected = numbers(&case["grad_per_m"]);
        close(value, case["value"].as_f64().unwrap(), 1e-9, "value");
        close(gradient[0], expected[0], 1e-9, "along x");
        close(gradient[1], expected[1], 1e-9, "along y");
        for wrong in case["must_not_equal_grad_per_cell"].as_object().unwrap().values() {
            let wrong: Vec<f64> = numbers(wrong).iter().map(|v| v / twin.resolution_m).collect();
            // In two cases a wrong formula happens to be right.
            let is_right = (wrong[0] - expected[0]).hypot(wrong[1] - expected[1]) < 1e-9;
            assert!(is_right || (gradient[0] - wrong[0]).hypot(gradient[1] - wrong[1]) > 1e-3);
        }
        // One point of a scan, a hair inside, on the fast path.
        let inside = |at: f64, origin: f64, n: usize| {
            at.clamp(origin + 0.5 * 0.05 + 1e-6, origin + (n as f64 - 0.5) * 0.05 - 1e-6)
        };
        let mut points = ScanPoints::default();
        points.push(0.0, 0.0, 1.0);
        let place = pose2(inside(x, -1.0, size.width), inside(y, 2.0, size.height), 0.0);
        let fast = linearize(&level, &points, &place);
        assert_eq!(fast.n_used, 1);
        close(fast.mean_value(), value, 1e-4, "fast value");
        // At the middle of a cell the gradient jumps.
        let parts = [case["fx"].as_f64().unwrap(), case["fy"].as_f64().unwrap()];
        if parts.iter().all(|part| (0.01..0.99).contains(part)) {
            let descent = fast.descent / (1.0 - value);
            close(descent.x, expected[0], 1e-4, "fast along x");
            close(descent.y, expected[1], 1e-4, "fast along y");
        }
    }
    for case in file["outside_cases_expect_none"].as_array().unwrap() {
        let [x, y] = numbers(&case["point_m"]).try_into().unwrap();
        let mut points = ScanPoints::default();
        points.push(x as f32, y as f32, 1.0);
        assert_eq!(linearize(&level, &points, &Pose2::identity()).n_used, 0, "{case}");
        assert!(!x.is_finite() || twin.value(Point2::new(x, y)).is_none(), "{case}");
    }
}

fn scan(file: &Value) -> (Vec<[f64; 3]>, ScanPoints) {
    let exact: Vec<[f64; 3]> = match file["points"].as_array() {
        Some(points) => points.iter().map(|point| numbers(&point["scan_point_m"])).collect::<Vec<_>>(),
        None => file["scan_points_m"].as_array().unwrap().iter().map(numbers).collect(),
    }
    .into_iter()
    .map(|point| [point[0], point[1], 1.0])
    .collect();
    let mut points = ScanPoints::default();
    exact.iter().for_each(|[x, y, weight]| points.push(*x as f32, *y as f32, *weight as f32));
    (exact, points)
}

#[test]
fn a_gauss_newton_step_is_that_of_the_specification() {
    let file = load("slam2d_gauss_newton_step");
    let (twin, cells, size) = grids(&file);
    let level = GridLevel::new(&cells, size, twin.resolution_m, twin.level_from_map).unwrap();
    let (exact, points) = scan(&file);
    let start = pose(&file["initial_xi"]);
    let slow = twin.linearize_exact(&exact, &start);
    let fast = linearize(&level, &points, &start);
    let (hessian, descent) = (matrix(&file["H"]), vector(&file["b"]));
    assert!((slow.hessian - hessian).amax() < 1e-8 && (slow.descent - descent).amax() < 1e-8);
    assert!((fast.hessian - hessian).amax() < 1e-4 * hessian.amax(), "{}", fast.hessian);
    assert!((fast.descent - descent).amax() < 1e-4 * descent.amax() + 1e-4, "{}", fast.descent);
    close(slow.cost, file["cost_before"].as_f64().unwrap(), 1e-8, "cost");
    close(fast.cost, file["cost_before"].as_f64().unwrap(), 1e-4, "fast cost");
    let taken = step(&slow, 0.0, None, None).unwrap();
    assert!((taken - vector(&file["delta_xi"])).amax() < 1e-8);
    let damped = step(&slow, file["levenberg"]["lambda_"].as_f64().unwrap(), None, None).unwrap();
    assert!((damped - vector(&file["levenberg"]["delta_xi"])).amax() < 1e-8);
    let prior = PosePrior {
        map_from_base: pose(&file["map_prior"]["prior_xi"]),
        information: matrix(&file["map_prior"]["prior_information"]),
        residual_variance: file["map_prior"]["residual_variance"].as_f64().unwrap(),
    };
    let toward = prior.difference_from(&start);
    let drawn = step(&slow, 0.0, None, Some((&prior, toward))).unwrap();
    assert!((drawn - vector(&file["map_prior"]["delta_xi"])).amax() < 1e-8);
}

#[test]
fn the_safeguarded_search_ends_at_the_optimum_of_the_specification_with_its_covariance() {
    let file = load("slam2d_gauss_newton_step");
    let (twin, cells, size) = grids(&file);
    let level = GridLevel::new(&cells, size, twin.resolution_m, twin.level_from_map).unwrap();
    let (exact, points) = scan(&file);
    let settings = MatchSettings {
        finest_iterations: 60,
        converge_m: 1e-7,
        converge_rad: 1e-7,
        ..MatchSettings::default()
    };
    let found = match_scan(&[level], &points, &pose(&file["initial_xi"]), None, &settings).unwrap();
    let expected = numbers(&file["safeguarded"]["final_xi"]);
    close(found.map_from_base.translation.x, expected[0], 1e-3, "x");
    close(found.map_from_base.translation.y, expected[1], 1e-3, "y");
    close(found.map_from_base.rotation.angle(), expected[2], 2e-3, "yaw");
    close(found.end.cost, file["safeguarded"]["final_cost"].as_f64().unwrap(), 1e-3, "cost");
    let at_final = twin.linearize_exact(&exact, &pose(&file["safeguarded"]["final_xi"]));
    let seen = Observability::of(&at_final, found.seen.extent_m, &ObservabilitySettings::default());
    let bare =
        CovarianceSettings { min_deviation_m: 0.0, min_deviation_rad: 0.0, ..CovarianceSettings::default() };
    let covariance = bare.from_curvature(&at_final, &seen);
    let expected = matrix(&file["covariance_at_final"]["R"]);
    // The pose is given to thirteen digits, and the map bends at the middles of cells.
    assert!((covariance - expected).amax() < 1e-8, "{covariance} {expected}");
}

#[test]
fn along_a_straight_wall_the_step_is_that_of_the_specification() {
    let file = load("slam2d_gauss_newton_degenerate");
    let (twin, ..) = grids(&file);
    let (exact, points) = scan(&file);
    let sums = twin.linearize_exact(&exact, &pose(&file["initial_xi"]));
    assert!((sums.hessian - matrix(&file["H"])).amax() < 1e-8);
    let exact_extent = (exact.iter().map(|[x, y, _]| x * x + y * y).sum::<f64>() / exact.len() as f64).sqrt();
    close(points.extent_m(), file["rho"].as_f64().unwrap(), 1e-6, "rho");
    let settings = ObservabilitySettings::default();
    let seen = Observability::unless_complete(&sums, exact_extent, &settings).unwrap();
    for (k, value) in numbers(&file["eigenvalues"]).into_iter().enumerate() {
        close(seen.evidence[k], value, 1e-8, "eigenvalue");
    }
    assert_eq!(seen.seen, [false, true, true]);
    assert_eq!(seen.blind_axes(), BlindAxes { x: false, y: true, yaw: false });
    let taken = step(&sums, 0.0, Some(&seen), None).unwrap();
    assert!((taken - vector(&file["delta_xi"])).amax() < 1e-8, "{taken}");
    assert!(taken.y.abs() < 1e-10);
}
