//! The wandering robot in the arena.

use crate::camera::{Faults, Gives};
use crate::place::Place;
use crate::robot::{Belief, Result, Run, heavy_pioneer, pioneer};
use rumbo_avoiders::braitenberg::vehicle::StopTurn;
use rumbo_avoiders::braitenberg::{Braitenberg, BraitenbergParams};
use rumbo_avoiders::memory_params::MemoryParams;
use rumbo_core::frames::pose2;
use rumbo_core::robot::Robot;

/// The six starts of the specification.
const STARTS: [[f64; 3]; 6] = [
    [-1.8, -1.8, 0.0],
    [0.0, 0.0, 1.0],
    [1.8, 0.3, 3.0],
    [-0.2, -1.9, 2.0],
    [-1.9, 0.6, 0.3],
    [2.0, 2.0, -2.0],
];

fn wander(robot: &Robot, params: &BraitenbergParams, gives: Gives) -> Vec<Result> {
    let place = Place::arena();
    let from = |[x, y, yaw]: [f64; 3]| {
        let run = Run {
            place: &place,
            robot: robot.clone(),
            gives,
            faults: Faults::default(),
            belief: Belief::True,
            seed: 1,
            waypoints: Vec::new(),
            limit_s: 120.0,
        };
        run.drive(&mut Braitenberg::new(params, robot).unwrap(), pose2(x, y, yaw))
    };
    STARTS.map(from).to_vec()
}

fn print(name: &str, runs: &[Result]) {
    for run in runs {
        println!("{name}: {:.1} m, clearance {:.3} m, stuck {:?}", run.driven_m, run.least_m, run.stuck);
    }
}

/// Without what goes beyond the source: no memory, no brakes of its own.
fn published(stop_turn: StopTurn) -> BraitenbergParams {
    let memory = MemoryParams { seconds: 0.0, ..MemoryParams::default() };
    BraitenbergParams { stop_turn, memory, brakes: false, ..BraitenbergParams::default() }
}

/// DC-A3.
#[test]
fn a_latched_robot_drives_115_m_in_two_minutes_from_everywhere() {
    for gives in [Gives::Scan, Gives::Cloud] {
        let runs = wander(&pioneer(), &published(StopTurn::Latched), gives);
        print("latched", &runs);
        assert!(runs.iter().all(|run| run.driven_m >= 115.0 && run.least_m >= 0.20));
    }
}

/// DC-A4: the published rule dithers in corners.
#[test]
fn a_robot_that_compares_bearings_is_stuck_from_somewhere() {
    let runs = wander(&pioneer(), &published(StopTurn::CompareBearing), Gives::Scan);
    print("compared", &runs);
    assert!(runs.iter().all(|run| run.least_m >= 0.20));
    assert!(runs.iter().any(|run| run.driven_m < 40.0));
}

/// DC-A3 with memory and brakes: the hull of 0.267 m touches nothing.
#[test]
fn with_memory_and_brakes_the_hull_touches_nothing() {
    let runs = wander(&pioneer(), &BraitenbergParams::default(), Gives::Scan);
    print("with memory and brakes", &runs);
    assert!(runs.iter().all(|run| run.driven_m >= 115.0 && run.least_m >= 0.267));
}

/// DC-A3 with the accelerations of a real robot, which needs 1.2 m to stop from full speed: it cannot drive 115 m. Without
/// brakes of its own it runs into walls; without memory its blind sides come nearer to them.
#[test]
fn with_real_wheels_brakes_keep_the_robot_off_the_walls() {
    let forgets = MemoryParams { seconds: 0.0, ..MemoryParams::default() };
    let forgetful = BraitenbergParams { memory: forgets, ..BraitenbergParams::default() };
    let [braked, forgetful, published] =
        [BraitenbergParams::default(), forgetful, published(StopTurn::Latched)]
            .map(|params| wander(&heavy_pioneer(), &params, Gives::Scan));
    print("real wheels", &braked);
    print("real wheels, no memory", &forgetful);
    print("real wheels, as published", &published);
    let least_m = |runs: &[Result]| runs.iter().map(|run| run.least_m).fold(f64::INFINITY, f64::min);
    assert!(least_m(&braked) >= 0.20 && braked.iter().all(|run| run.driven_m >= 30.0));
    assert!(least_m(&published) < 0.05 && least_m(&forgetful) < least_m(&braked));
}
