use super::*;
use nalgebra::{Vector2, Vector3};
use serde_json::Value;

fn vector() -> Value {
    let path = format!("{}/tests/data/slam2d_scan_odometry_alignment.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

fn close(found: f64, expected: f64, what: &str) {
    assert!((found - expected).abs() < 1e-8, "{what}: {found}, not {expected}");
}

#[test]
fn the_closed_form_finds_the_published_motion() {
    let file = &vector()["closed_form_2d"];
    let (p, q, w) = (rows(&file["p"]), rows(&file["q"]), numbers(&file["weights"]));
    let pairs: Vec<_> = p
        .iter()
        .zip(&q)
        .zip(&w)
        .map(|((p, q), w)| (Vector2::new(p[0], p[1]), Vector2::new(q[0], q[1]), *w))
        .collect();
    let found = align(pairs.iter().copied()).unwrap();
    close(found.rotation.angle(), file["theta"].as_f64().unwrap(), "theta");
    let t = numbers(&file["t"]);
    close(found.translation.x, t[0], "x");
    close(found.translation.y, t[1], "y");
    assert_eq!(align(std::iter::empty()), None);
    assert_eq!(align(pairs.iter().take(1).copied()), None, "one pair says nothing about the turn");
}

/// The equations of the published points at a pose.
fn published(file: &Value, xi: &Vector3<f64>) -> (Equations, Vec<f64>, Vec<Vector3<f64>>) {
    let lines: Vec<Line> = file["lines_n_d"]
        .as_array()
        .unwrap()
        .iter()
        .map(|line| {
            let normal = numbers(&line[0]);
            let distance_m = line[1].as_f64().unwrap();
            Line { normal: [normal[0], normal[1]], distance_m, normal_rad2: 0.0 }
        })
        .collect();
    let (mut equations, mut residuals, mut jacobians) = (Equations::default(), Vec::new(), Vec::new());
    let (sine, cosine) = xi.z.sin_cos();
    for (point, line) in rows(&file["points"]).iter().zip(numbers(&file["line_of_point"])) {
        let line = lines[line as usize];
        let arm = [cosine * point[0] - sine * point[1], sine * point[0] + cosine * point[1]];
        let residual_m = line.residual_m([arm[0] + xi.x, arm[1] + xi.y]);
        equations.add(&line, arm, residual_m, 1.0);
        residuals.push(residual_m);
        jacobians.push(Equations::jacobian(line.normal, arm));
    }
    (equations, residuals, jacobians)
}

#[test]
fn one_step_and_the_optimum_of_points_at_lines_are_the_published_ones() {
    let file = &vector()["point_to_line"];
    let mut xi = Vector3::zeros();
    let (equations, residuals, jacobians) = published(file, &xi);
    for (found, expected) in residuals.iter().zip(numbers(&file["residuals"])) {
        close(*found, expected, "residual");
    }
    for (found, expected) in jacobians.iter().zip(rows(&file["J"])) {
        found.iter().zip(expected).for_each(|(found, expected)| close(*found, expected, "J"));
    }
    for (row, expected) in rows(&file["H"]).iter().enumerate() {
        (0..3).for_each(|col| close(equations.information[(row, col)], expected[col], "H"));
    }
    let (gradient, delta) = (numbers(&file["gradient"]), numbers(&file["delta"]));
    let step = Split::new(&equations, &DegeneracyRule::default()).unwrap().step(&equations.gradient);
    for k in 0..3 {
        close(equations.gradient[k], gradient[k], "gradient");
        close(step[k], delta[k], "delta");
    }
    for _ in 0..20 {
        let (equations, ..) = published(file, &xi);
        xi += Split::new(&equations, &DegeneracyRule::default()).unwrap().step(&equations.gradient);
    }
    let converged = numbers(&file["converged_xi"]);
    (0..3).for_each(|k| close(xi[k], converged[k], "converged"));
    let cost_m2 = published(file, &xi).0.cost_m2;
    let expected = file["final_cost"].as_f64().unwrap();
    assert!((cost_m2 - expected).abs() < 1e-8 || (0.5 * cost_m2 - expected).abs() < 1e-8, "{cost_m2}");
}

#[test]
fn the_jacobian_is_that_of_finite_differences() {
    let line = Line { normal: [0.6, -0.8], distance_m: 0.4, normal_rad2: 0.0 };
    let (point, xi) = ([1.7, -2.3], Vector3::new(0.3, -0.2, 2.9));
    let arm = |xi: &Vector3<f64>| {
        let (sine, cosine) = xi.z.sin_cos();
        [cosine * point[0] - sine * point[1], sine * point[0] + cosine * point[1]]
    };
    let residual = |xi: &Vector3<f64>| line.residual_m([arm(xi)[0] + xi.x, arm(xi)[1] + xi.y]);
    let jacobian = Equations::jacobian(line.normal, arm(&xi));
    for k in 0..3 {
        let step = Vector3::ith(k, 1e-6);
        let difference = (residual(&(xi + step)) - residual(&(xi - step))) / 2e-6;
        assert!((jacobian[k] - difference).abs() < 1e-8, "{k}: {} {difference}", jacobian[k]);
    }
}
