//! The law against the published table.

use super::vehicle::{StopTurn, Vehicle, VehicleTuning};
use super::*;
use crate::nearest::Stimulus;
use crate::spec_samples::rows;
use rumbo_core::registry::Params;
use rumbo_core::robot::{Drive, Robot};

fn pioneer() -> Robot {
    let drive = Drive::Differential { track_m: 0.33 };
    Robot { drive, max_speed_m_s: 1.2, max_turn_deg_s: 300.0, ..Robot::default() }
}

fn tuning(stop_turn: StopTurn) -> VehicleTuning {
    BraitenbergParams { stop_turn, ..BraitenbergParams::default() }.vehicle(&pioneer())
}

#[test]
fn wheels_are_those_of_the_samples() {
    for row in rows(include_str!("../../tests/data/dc_avoider_samples.csv")) {
        let mut vehicle = Vehicle::new(tuning(StopTurn::CompareBearing));
        let at = |distance: &str, bearing: &str| {
            Some(Stimulus { distance_m: row.number(distance), bearing_rad: row.number(bearing) })
        };
        vehicle.steer(at("distance", "previous_bearing"));
        let wheels = vehicle.steer(at("distance", "bearing"));
        assert!((wheels.left_m_s - row.number("v_left")).abs() < 1e-12, "{row:?} {wheels:?}");
        assert!((wheels.right_m_s - row.number("v_right")).abs() < 1e-12, "{row:?} {wheels:?}");
    }
}

#[test]
fn a_latched_turn_keeps_its_side_until_the_way_is_free() {
    let mut vehicle = Vehicle::new(tuning(StopTurn::Latched));
    let mut turn = |distance_m: f64, bearing_rad: f64| {
        let wheels = vehicle.steer(Some(Stimulus { distance_m, bearing_rad }));
        (wheels.left_m_s, wheels.right_m_s)
    };
    assert_eq!(turn(0.5, 0.2), (0.6, -0.6));
    // The nearest point is on the other side now.
    assert_eq!(turn(0.4, -0.3), (0.6, -0.6));
    assert_eq!(turn(0.5001, -0.3).1, 1.2);
    assert_eq!(turn(0.5, -0.3), (-0.6, 0.6));
    assert_eq!(vehicle.steer(None).left_m_s, 1.2);
}

#[test]
fn the_law_has_no_step_between_its_intervals() {
    let of = |distance_m: f64| {
        Vehicle::new(tuning(StopTurn::Latched))
            .steer(Some(Stimulus { distance_m, bearing_rad: -0.3 }))
            .left_m_s
    };
    assert!((of(0.75 + 1e-9) - of(0.75)).abs() < 1e-6 && (of(0.5 + 1e-9) - 0.6).abs() < 1e-6);
}

#[test]
fn a_slow_robot_has_the_same_law_in_proportion() {
    let slow = Robot { max_speed_m_s: 0.3, ..pioneer() };
    let vehicle = BraitenbergParams::default().vehicle(&slow);
    assert_eq!((vehicle.speed_m_s, vehicle.least_m_s, vehicle.spin_m_s), (0.3, 0.15, 0.15));
}

#[test]
fn every_fault_is_told() {
    let params = BraitenbergParams {
        stop_distance_m: 1.0,
        least_m_s: 2.0,
        spin_m_s: -1.0,
        stale_after_s: f64::NAN,
        ..BraitenbergParams::default()
    };
    let keys: Vec<String> = params.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(keys, ["slow_distance_m", "least_m_s", "spin_m_s", "stale_after_s"]);
    assert!(BraitenbergParams::default().check().is_empty());
}
