//! Field, turn and near rule against the published cases, and against finite differences.

use super::aim::Aim;
use super::classical::Classical;
use super::descent::{Descent, Place};
use super::field::{Attraction, NearField, Repulsion};
use super::near_rule::{NearControl, NearRule, Pull};
use super::push::{PushFrom, PushLaw, push};
use super::turn::turn_error_rad;
use super::*;
use crate::near_points::NearPoint;
use crate::nearest::Stimulus;
use crate::spec_samples::rows;
use crate::wheels::{Saturation, WheelPair, turn_in_time_rad_s};
use nalgebra::Vector2;
use rumbo_core::frames::Point2;
use rumbo_core::registry::Params;
use rumbo_core::robot::{Drive, Robot};
use rumbo_core::time::Time;
use std::f64::consts::{FRAC_PI_2, PI};

mod on_its_way;

fn pioneer() -> Robot {
    let drive = Drive::Differential { track_m: 0.33 };
    Robot { drive, radius_m: 0.267, max_speed_m_s: 1.2, max_turn_deg_s: 300.0, ..Robot::default() }
}

fn seen(x: f64, y: f64) -> NearPoint {
    NearPoint { in_base: Point2::new(x, y), stamp: Time::ZERO, is_remembered: false }
}

fn polar(distance_m: f64, bearing_rad: f64) -> NearPoint {
    seen(distance_m * bearing_rad.cos(), distance_m * bearing_rad.sin())
}

fn published(near_field: NearField) -> Descent {
    Descent {
        attraction: Attraction::default(),
        push: PushLaw::Gradient(Repulsion { near_field, ..Repulsion::default() }),
        push_from: PushFrom::Closest,
    }
}

/// A robot at the origin that looks along x, with a goal so far off.
fn place(distance_m: f64, angle_rad: f64) -> Place {
    let target = Point2::new(distance_m * angle_rad.cos(), distance_m * angle_rad.sin());
    let aim = Aim { target, left_m: distance_m };
    Place { position: Point2::origin(), yaw_rad: 0.0, aim, arrival_radius_m: 0.55 }
}

#[test]
fn pull_and_push_are_those_of_the_samples() {
    for row in rows(include_str!("../../tests/data/dc_field_samples.csv")) {
        let of = |key: &str| row.number(key);
        let near = |found: Vector2<f64>, name: &str| {
            let expected = Vector2::new(of(&format!("{name}_x")), of(&format!("{name}_y")));
            assert!((found - expected).norm() < 1e-6, "{name} {found} {row:?}");
        };
        near(Attraction::default().at(of("d_goal"), of("goal_angle")), "attraction");
        for (near_field, name) in
            [(NearField::Sign, "repulsion"), (NearField::Radial, "repulsion_continuous")]
        {
            let repulsion = Repulsion { near_field, ..Repulsion::default() };
            near(repulsion.at(of("d_obstacle"), of("obstacle_angle")), name);
        }
        let points = [polar(of("d_obstacle"), of("obstacle_angle"))];
        let (strength, turn_rad) =
            published(NearField::Sign).pull(&place(of("d_goal"), of("goal_angle")), &points);
        assert!((strength - of("speed_factor")).abs() < 1e-6, "{row:?}");
        assert!((turn_error_rad(of("path_angle"), turn_rad)).abs() < 1e-6, "{turn_rad} {row:?}");
    }
}

#[test]
fn turns_are_those_of_the_samples() {
    for row in rows(include_str!("../../tests/data/dc_turn_samples.csv")) {
        let of = |key: &str| row.number(key);
        let error_deg = turn_error_rad(of("yaw_deg").to_radians(), of("path_deg").to_radians()).to_degrees();
        assert!((error_deg - of("turn_error_deg")).abs() < 1e-9, "{row:?} {error_deg}");
        assert!((error_deg.abs() - of("angle_deg")).abs() < 1e-9);
        let sense = if error_deg == 0.0 { 0.0 } else { -error_deg.signum() };
        assert_eq!(sense, of("sense"), "{row:?}");
    }
}

/// Pixel, raw depth and heading in, speeds of the wheels out: every number on the way.
#[test]
fn the_three_real_cases_come_out_as_published_and_corrected() {
    let text = include_str!("../../tests/data/dc_sensor_cases.toml");
    let cases: toml::Table = toml::from_str(text).unwrap();
    for case in cases["case"].as_array().unwrap() {
        let of = |table: &str, key: &str| {
            let value = &case[table][key];
            value.as_float().unwrap_or_else(|| value.as_integer().unwrap() as f64)
        };
        let close = |found: f64, table: &str, key: &str| {
            assert!((found - of(table, key)).abs() < 1e-6, "{key} {found} {}", case["name"]);
        };
        // The source's own angle of a pixel, with its shift of one.
        let column_rad = (32.0 - of("input", "column") - 0.5) / 32.0 * 28.5f64.to_radians();
        let ahead_m = 0.2 + 3.3 * of("input", "raw_depth") / 8191.0;
        let point = seen(ahead_m, ahead_m * column_rad.tan());
        close(point.in_base.y, "point", "X");
        close(point.in_base.coords.norm(), "point", "planar_distance");
        let goal = Point2::new(0.0, 5.0);
        let yaw_rad = of("input", "yaw");
        let descent = published(NearField::Sign);
        let pushed = push(&descent.push, PushFrom::Closest, &[point], yaw_rad);
        close(pushed.x, "field", "repulsion_x");
        close(pushed.y, "field", "repulsion_y");
        let aim = Aim { target: goal, left_m: 5.0 };
        let place = Place { position: Point2::origin(), yaw_rad, aim, arrival_radius_m: 0.55 };
        let (strength, turn_rad) = descent.pull(&place, &[point]);
        close(strength, "control", "speed_factor");
        close(turn_rad, "control", "turn_error");
        close(yaw_rad + turn_rad, "control", "path_angle");
        let free = WheelPair::toward(1.2, strength, turn_rad);
        close(free.left_m_s, "control", "v_left_unsaturated");
        close(free.right_m_s, "control", "v_right_unsaturated");
        let clamped = free.saturated(1.2, Saturation::Clamp);
        close(clamped.left_m_s, "control", "v_left");
        close(clamped.right_m_s, "control", "v_right");
    }
}

#[test]
fn the_classical_force_is_the_negative_gradient_of_its_potential() {
    let field = Classical { xi: 0.7, eta: 0.3, reach_m: 1.2 };
    let (goal, obstacle) = (Point2::new(3.0, -1.0), Point2::new(0.5, 0.4));
    let potential =
        |at: Point2| field.attractive_potential(at, goal) + field.repulsive_potential(at, obstacle);
    for k in 0..40 {
        let at = Point2::new(0.05 * f64::from(k) - 0.8, 0.9 - 0.04 * f64::from(k));
        let h = 1e-6;
        let slope = |step: Vector2<f64>| (potential(at + step * h) - potential(at - step * h)) / (2.0 * h);
        let expected = -Vector2::new(slope(Vector2::x()), slope(Vector2::y()));
        let found = field.attraction(at, goal) + field.repulsion(at, obstacle, Vector2::zeros());
        assert!((found - expected).norm() < 1e-5 * (1.0 + expected.norm()), "{at} {found} {expected}");
    }
    // On the obstacle the force is finite, and points where somebody says.
    let away = Vector2::new(0.0, 1.0);
    let force = field.repulsion(obstacle, obstacle, away);
    assert!(force.x == 0.0 && force.y > 0.0 && force.y.is_finite());
}

#[test]
fn the_classical_field_draws_all_the_way_to_the_goal() {
    let descent =
        PotentialFieldParams { field: FieldForm::Classical, ..PotentialFieldParams::default() }.descent();
    assert!((descent.pull(&place(0.3, 1.0), &[]).0 - 0.3).abs() < 1e-12);
    let (strength, turn_rad) = descent.pull(&place(2.0, 0.0), &[seen(0.5, 0.0)]);
    let force = Classical::default().repulsion(Point2::origin(), Point2::new(0.5, 0.0), Vector2::zeros());
    assert!((strength - (2.0 + force.x)).abs() < 1e-12 && turn_rad == 0.0);
}

#[test]
fn the_nearest_of_each_sector_pushes_and_their_mean_has_no_jump() {
    let law = PushLaw::Gradient(Repulsion::default());
    let left = [seen(0.0, 0.7), seen(0.02, 0.75), seen(0.0, -0.700001), seen(2.0, 0.0)];
    let right = [seen(0.0, 0.700002), seen(0.02, 0.75), seen(0.0, -0.700001), seen(2.0, 0.0)];
    let jump = |from: PushFrom| (push(&law, from, &left, 0.3) - push(&law, from, &right, 0.3)).norm();
    assert!(jump(PushFrom::Closest) > 0.5 && jump(PushFrom::Sectors) < 1e-5);
    // By hand: of four points one is beside a nearer one in its sector, and one too far to push.
    let one = |point: &NearPoint| push(&law, PushFrom::Closest, std::slice::from_ref(point), 0.3);
    let first_of_three = [seen(0.0, 0.7), seen(0.02, 0.75), seen(0.0, -0.700001)].map(|point| one(&point));
    let mean = push(&law, PushFrom::Sectors, &left, 0.3);
    let apart = (left[1].in_base.y.atan2(left[1].in_base.x).to_degrees() / 10.0) as i32 == 9;
    let sum = first_of_three[0] + first_of_three[2];
    let expected = if apart { sum / 2.0 } else { (sum + first_of_three[1]) / 3.0 };
    assert!((mean - expected).norm() < 1e-12);
}

fn control(near_rule: NearRule) -> NearControl {
    NearControl::new(PotentialFieldParams { near_rule, ..PotentialFieldParams::default() }.near(&pioneer()))
}

fn pull(strength: f64, turn_error_rad: f64, nearest: Option<(f64, f64)>) -> Pull {
    let nearest = nearest.map(|(distance_m, bearing_rad)| Stimulus { distance_m, bearing_rad });
    Pull { strength, turn_error_rad, nearest }
}

#[test]
fn the_published_rule_spins_at_full_speed_in_front_of_what_is_near() {
    let mut control = control(NearRule::SpinInPlace);
    let spin = |wheels: WheelPair| (wheels.left_m_s, wheels.right_m_s);
    assert_eq!(spin(control.steer(&pull(0.9, 0.4, Some((0.5, 1.0))), false)), (-1.2, 1.2));
    assert_eq!(spin(control.steer(&pull(0.9, -0.4, Some((0.5, 1.0))), false)), (1.2, -1.2));
    assert_eq!(spin(control.steer(&pull(0.9, 0.0, Some((0.5, 1.0))), false)), (-1.2, 1.2));
    let free = control.steer(&pull(0.9, 0.4, Some((0.501, 1.0))), false);
    assert_eq!(free, WheelPair::toward(1.2, 0.9, 0.4).saturated(1.2, Saturation::Scale));
    assert!(!control.is_blocked(&[seen(0.3, 0.0)]));
}

#[test]
fn in_a_blocked_corridor_the_robot_turns_one_way_until_it_is_free() {
    let mut control = control(NearRule::ClearCorridor);
    assert!(control.is_blocked(&[seen(0.54, -0.29)]));
    for free in [seen(0.56, 0.0), seen(0.3, 0.31), seen(-0.3, 0.0)] {
        assert!(!control.is_blocked(&[free]));
    }
    let mut turn = |error_rad: f64, bearing_rad: f64, is_blocked: bool| {
        let wheels = control.steer(&pull(0.8, error_rad, Some((0.4, bearing_rad))), is_blocked);
        (wheels.left_m_s, wheels.right_m_s)
    };
    // About along the way, the obstacle's side counts, and stays.
    assert_eq!(turn(0.2, 0.1, true), (0.5, -0.5));
    assert_eq!(turn(0.2, -0.1, true), (0.5, -0.5));
    // Beside something near it goes slowly: 0.25 m/s, and a turn of 1.8 e/π.
    let (left, right) = turn(0.2, 1.2, false);
    assert!(
        ((left + right) / 2.0 - 0.25).abs() < 1e-12 && ((right - left) / 2.0 - 1.8 * 0.2 / PI).abs() < 1e-12
    );
    assert_eq!(turn(0.2, -0.1, true), (-0.5, 0.5));
    turn(0.2, 1.2, false);
    // Far from its way, the way out is the way.
    assert_eq!(turn(-1.0, -0.1, true), (0.5, -0.5));
    let (left, right) = turn(1.7, 1.2, false);
    assert!((left + right).abs() < 1e-12, "no speed with the way behind");
}

/// Table 5: full speed beyond 1.5 m, then linear to none at 0.5 m.
#[test]
fn the_speed_toward_a_goal_is_linear_to_half_a_meter_before_it() {
    let mut control = control(NearRule::ClearCorridor);
    for k in 0..400 {
        let distance_m = 0.01 * f64::from(k);
        let (strength, turn_error_rad) = published(NearField::Radial).pull(&place(distance_m, 0.0), &[]);
        let wheels = control.steer(&pull(strength, turn_error_rad, None), false);
        let expected_m_s = 1.2 * (distance_m - 0.5).clamp(0.0, 1.0);
        assert!((wheels.left_m_s - expected_m_s).abs() < 1e-12 && wheels.left_m_s == wheels.right_m_s);
    }
}

#[test]
fn a_nearer_arrival_radius_moves_the_end_of_the_pull() {
    let near = Place { arrival_radius_m: 0.11, ..place(0.2, 0.0) };
    assert!((published(NearField::Radial).pull(&near, &[]).0 - 0.1).abs() < 1e-12);
}

#[test]
fn a_turn_ends_in_time() {
    // From 1 rad/s a slowing of 2 rad/s² needs a quarter of a radian.
    assert!((turn_in_time_rad_s(0.25, 5.0, 2.0) - 1.0).abs() < 1e-12);
    assert!((turn_in_time_rad_s(-0.25, -5.0, 2.0) + 1.0).abs() < 1e-12);
    assert_eq!(turn_in_time_rad_s(FRAC_PI_2, 0.3, 2.0), 0.3);
}

#[test]
fn every_fault_is_told() {
    let mut params = PotentialFieldParams { speed_m_s: 0.0, ..PotentialFieldParams::default() };
    params.attraction.alpha = -1.0;
    params.repulsion.gamma = f64::NAN;
    params.memory.seconds = -1.0;
    let keys: Vec<String> = params.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["speed_m_s", "attraction.alpha", "repulsion.gamma", "memory.seconds"]);
    assert!(PotentialFieldParams::default().check().is_empty());
}
