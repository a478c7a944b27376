//! One step of everything, against the numbers of the vectors and against finite differences.

use super::super::association::associate;
use super::super::growth::NewWall;
use super::super::sighting::Viewpoint;
use super::super::state::wrapped;
use super::{DATA, alike, close, seen};
use crate::line_filter::*;
use crate::lines::SensedLine;
use nalgebra::{DMatrix, Matrix5, SMatrix, Vector5};
use serde_json::Value;

fn vectors() -> Value {
    serde_json::from_str(&std::fs::read_to_string(format!("{DATA}ekf_one_step.json")).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<Vec<f64>> = value.as_array().unwrap().iter().map(numbers).collect();
    DMatrix::from_fn(rows.len(), rows[0].len(), |row, col| rows[row][col])
}

fn state_of(x: &Value, covariance: &Value) -> State {
    let x = numbers(x);
    let mut state = State::new(Vector5::from_column_slice(&x[..5]), &Matrix5::zeros());
    state.walls = x[5..].chunks(2).map(|line| [line[0], line[1]]).collect();
    state.covariance.grow(x.len() - 5);
    state.covariance.view_mut().copy_from(&matrix(covariance));
    state
}

fn whole(state: &State) -> DMatrix<f64> {
    state.covariance.view().into_owned()
}

fn same_state(found: &State, expected: &Value, what: &str) {
    let numbers = numbers(&expected["x"]);
    for (found, expected) in found.robot.iter().chain(found.walls.iter().flatten()).zip(numbers) {
        close(*found, expected, 1e-8, what);
    }
    alike(&whole(found), &matrix(&expected["P"]), 1e-8, what);
}

fn model(integration: Integration) -> MotionModel {
    MotionModel { integration, ..MotionModel::default() }
}

#[test]
fn predictions_are_those_of_the_vectors() {
    let vectors = vectors();
    for case in vectors["prediction"].as_array().unwrap() {
        let t = case["T"].as_f64().unwrap();
        let is_euler = case["integration"] == "euler";
        let model = model(if is_euler { Integration::Euler } else { Integration::Midpoint });
        let mut state = state_of(&vectors["initial"]["x"], &vectors["initial"]["P"]);
        let (_, by_robot) = model.step(&state.robot, t);
        let dynamic = |m: &[f64], rows, cols| DMatrix::from_column_slice(rows, cols, m);
        alike(&dynamic(by_robot.as_slice(), 5, 5), &matrix(&case["F_r"]), 1e-8, "F");
        let gamma = model.by_accelerations(&state.robot, t);
        alike(&dynamic(gamma.as_slice(), 5, 2), &matrix(&case["Gamma_r"]), 1e-8, "Gamma");
        model.predict(&mut state, t);
        same_state(&state, case, &format!("{t} {}", case["integration"]));
    }
}

/// Innovations, rows of H, gain and distance of an update, and the state after it.
fn check_update(state: &mut State, rows: &[Row], expected: &Value) {
    let name = expected["name"].as_str().unwrap();
    let size = state.covariance.size();
    let mut h = DMatrix::zeros(rows.len(), size);
    for (k, row) in rows.iter().enumerate() {
        row.entries().for_each(|(at, weight)| h[(k, at)] = weight);
        close(row.innovation, expected["innovation"][k].as_f64().unwrap(), 1e-8, name);
    }
    alike(&h, &matrix(&expected["H"]), 1e-8, name);
    let update = Update::new(state, rows).unwrap();
    alike(&update.gain(size), &matrix(&expected["K"]), 1e-6, name);
    close(update.distance2(), expected["mahalanobis_sq"].as_f64().unwrap(), 1e-7, name);
    update.fuse(state, rows, false);
    same_state(state, expected, name);
}

/// The state before the first update of the vectors, and the state after the last.
fn updated(vectors: &Value) -> State {
    let mut state = state_of(&vectors["initial"]["x"], &vectors["initial"]["P"]);
    model(Integration::Euler).predict(&mut state, 0.05);
    let [wheels, steering, line] = [0, 1, 2].map(|k| &vectors["updates"][k]);
    let speeds = numbers(&wheels["y"]);
    let rows = OdometerModel::default().rows(&Wheels::default(), &state, [speeds[0], speeds[1]]);
    check_update(&mut state, &rows, wheels);
    let angle = steering["y"][0].as_f64().unwrap();
    let printed = Steering { model: SteeringModel::SmallAngle, ..Steering::default() };
    let small = steering["h_printed_without_arctan"].as_f64().unwrap();
    close(printed.expected(&state.robot).unwrap(), small, 1e-8, "printed steering");
    let row = Steering::default().row(&state.robot, angle).unwrap();
    check_update(&mut state, &[row], steering);
    let sighted = sighted(line);
    let predicted = PredictedLine::new(&state.robot, &Mount::default(), state.walls[0]);
    let rows = predicted.rows(state.column_of(0), &sighted);
    check_update(&mut state, &rows, line);
    state
}

fn sighted(value: &Value) -> SensedLine {
    let (y, r) = (numbers(&value["y"]), matrix(&value["R"]));
    SensedLine { covariance: [r[(0, 0)], r[(0, 1)], r[(1, 1)]], ..seen(y[0], y[1], [-1.0, 1.0]) }
}

#[test]
fn updates_gates_and_new_walls_are_those_of_the_vectors() {
    let vectors = vectors();
    let state = updated(&vectors);
    let view = Viewpoint::new(&state.robot, &Mount::default());
    for case in vectors["gating_feature_2"].as_array().unwrap() {
        let line = sighted(case);
        let expected = case["mahalanobis_sq"].as_f64().unwrap();
        let everywhere = Wall { ends_m: [[-1e3, 8.0], [1e3, 8.0]] };
        let walls = [Wall { ends_m: [[1e6; 2]; 2] }, everywhere];
        let open = Gates { distance2: f64::MAX, ..Gates::default() };
        let found = associate(&state, &walls, &view, &[line], &open);
        close(found[0].distance2, expected, 1e-6, "distance");
        assert_eq!(found[0].wall, 1);
        let is_accepted = !associate(&state, &walls, &view, &[line], &Gates::default()).is_empty();
        assert_eq!(is_accepted, case["accepted"].as_bool().unwrap());
    }
    let new = &vectors["feature_initialisation"];
    let z = numbers(&new["z"]);
    let (line, by_robot, by_seen) = placed(&state.robot, &Mount::default(), [z[0], z[1]]);
    for (found, expected) in line.into_iter().zip(numbers(&new["feature"])) {
        close(found, expected, 1e-8, "new wall");
    }
    alike(&DMatrix::from_column_slice(2, 5, by_robot.as_slice()), &matrix(&new["G_r"]), 1e-8, "G_r");
    alike(&DMatrix::from_column_slice(2, 2, by_seen.as_slice()), &matrix(&new["G_z"]), 1e-8, "G_z");
    let r = matrix(&new["R"]);
    let seen = SensedLine { covariance: [r[(0, 0)], r[(0, 1)], r[(1, 1)]], ..seen(z[0], z[1], [-1.0, 1.0]) };
    let (mut grown, mut walls) = (state.clone(), vec![Wall { ends_m: [[0.0; 2]; 2] }; 2]);
    NewWall::new(&state, &Mount::default(), &seen).add(
        &mut grown,
        &mut walls,
        Wall { ends_m: [[0.0; 2]; 2] },
    );
    let covariance = whole(&grown);
    alike(&covariance.view((9, 9), (2, 2)).into_owned(), &matrix(&new["P_new_new"]), 1e-8, "new");
    alike(&covariance.view((9, 0), (2, 9)).into_owned(), &matrix(&new["P_new_old"]), 1e-8, "new with old");
    alike(&covariance, &covariance.transpose(), 0.0, "symmetric");
}

#[test]
fn a_sensor_beside_the_axle_sees_walls_as_in_the_vectors() {
    let vectors = vectors();
    let case = &vectors["sensor_offset"];
    let number = |key: &str| case[key].as_f64().unwrap();
    let mount = Mount { x_m: number("a"), y_m: number("b"), yaw_rad: number("gamma") };
    let (robot, wall) = (numbers(&case["robot"]), numbers(&case["feature"]));
    let robot = Vector5::new(robot[0], robot[1], robot[2], 0.0, 0.0);
    let found = PredictedLine::new(&robot, &mount, [wall[0], wall[1]]);
    let h = numbers(&case["h"]);
    close(found.distance_m, h[0], 1e-8, "h");
    close(found.normal_rad, h[1], 1e-8, "h");
    let by_robot = DMatrix::from_column_slice(2, 3, found.by_robot.as_slice());
    alike(&by_robot, &matrix(&case["H_robot"]).columns(0, 3).into_owned(), 1e-8, "by the robot");
    let by_wall = DMatrix::from_column_slice(2, 2, found.by_wall.as_slice());
    alike(&by_wall, &matrix(&case["H_feature"]), 1e-8, "by the wall");
}

/// Central differences of a function of five numbers.
fn differences<const N: usize>(
    at: Vector5<f64>,
    function: impl Fn(&Vector5<f64>) -> [f64; N],
) -> SMatrix<f64, N, 5> {
    let step = 1e-6;
    SMatrix::from_fn(|row, col| {
        let (mut up, mut down) = (at, at);
        up[col] += step;
        down[col] -= step;
        wrapped(function(&up)[row] - function(&down)[row]) / (2.0 * step)
    })
}

#[test]
fn jacobians_are_finite_differences_on_all_sides() {
    let robots = [
        Vector5::new(2.0, 3.0, 0.5, 1.2, 0.25),
        Vector5::new(-4.0, 1.0, 3.1, -0.8, -0.6),
        Vector5::new(0.3, -7.0, -2.4, 0.6, 0.0),
    ];
    let mount = Mount { x_m: 1.1, y_m: -0.2, yaw_rad: 2.9 };
    for robot in robots {
        for integration in [Integration::Euler, Integration::Midpoint] {
            let model = model(integration);
            let expected = differences(robot, |robot| model.step(robot, 0.4).0.into());
            assert!((model.step(&robot, 0.4).1 - expected).amax() < 1e-6);
        }
        for model in [SteeringModel::Arctangent, SteeringModel::SmallAngle] {
            let steering = Steering { model, ..Steering::default() };
            let expected = differences(robot, |robot| [steering.expected(robot).unwrap()]);
            let row = steering.row(&robot, 0.1).unwrap();
            row.entries().for_each(|(at, weight)| close(weight, expected[at], 1e-6, "steering"));
        }
        let rows = |robot: &Vector5<f64>| {
            let state = State::new(*robot, &Matrix5::zeros());
            OdometerModel::default().rows(&Wheels::default(), &state, [0.0; 2])
        };
        let expected = differences(robot, |robot| rows(robot).map(|row| -row.innovation));
        for (k, row) in rows(&robot).iter().enumerate() {
            row.entries().for_each(|(at, weight)| close(weight, expected[(k, at)], 1e-6, "wheels"));
        }
        for wall in [[10.0, 0.1], [-3.0, 3.0], [4.0, -3.1]] {
            let sees = |robot: &Vector5<f64>, wall| {
                let line = PredictedLine::new(robot, &mount, wall);
                [line.distance_m, line.normal_rad]
            };
            let predicted = PredictedLine::new(&robot, &mount, wall);
            let expected = differences(robot, |robot| sees(robot, wall));
            assert!((predicted.by_robot - expected.fixed_columns::<3>(0)).amax() < 1e-6);
            let padded = Vector5::new(wall[0], wall[1], 0.0, 0.0, 0.0);
            let expected = differences(padded, |wall| sees(&robot, [wall[0], wall[1]]));
            assert!((predicted.by_wall - expected.fixed_columns::<2>(0)).amax() < 1e-6);
            // Where it was seen from, it is again.
            let (line, by_robot, by_seen) = placed(&robot, &mount, sees(&robot, wall));
            close(line[0], wall[0], 1e-9, "back in the map");
            close(wrapped(line[1] - wall[1]), 0.0, 1e-9, "back in the map");
            let z = sees(&robot, wall);
            let expected = differences(robot, |robot| placed(robot, &mount, z).0);
            assert!((by_robot - expected).amax() < 1e-6);
            let expected = differences(Vector5::new(z[0], z[1], 0.0, 0.0, 0.0), |z| {
                placed(&robot, &mount, [z[0], z[1]]).0
            });
            assert!((by_seen - expected.fixed_columns::<2>(0)).amax() < 1e-6);
        }
    }
}
