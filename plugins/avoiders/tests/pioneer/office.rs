//! The tour of the office.

use crate::camera::{Faults, Gives};
use crate::place::Place;
use crate::robot::{ARRIVAL_RADIUS_M, Belief, Result, Run, STEP_S, heavy_pioneer, pioneer};
use rumbo_avoiders::potential_field::field::NearField;
use rumbo_avoiders::potential_field::near_rule::NearRule;
use rumbo_avoiders::potential_field::push::PushFrom;
use rumbo_avoiders::potential_field::{PotentialField, PotentialFieldParams};
use rumbo_avoiders::wheels::Saturation;
use rumbo_core::frames::{Point2, pose2};
use rumbo_core::robot::Robot;
use std::f64::consts::FRAC_PI_2;

/// Waypoints 1, 2, 3, 2, 4, 5.
const TOUR: [[f64; 2]; 6] =
    [[-4.2, 1.0], [0.65, 1.2], [0.175, -1.4], [0.65, 1.2], [4.075, 1.2], [4.075, -2.525]];

struct Tour {
    robot: Robot,
    params: PotentialFieldParams,
    belief: Belief,
    gives: Gives,
    faults: Faults,
    limit_s: f64,
}

impl Tour {
    fn new(robot: Robot) -> Tour {
        let params = PotentialFieldParams::default();
        Tour {
            robot,
            params,
            belief: Belief::True,
            gives: Gives::Scan,
            faults: Faults::default(),
            limit_s: 120.0,
        }
    }

    fn drive(&self, seed: u64) -> Result {
        let place = Place::office();
        let run = Run {
            place: &place,
            robot: self.robot.clone(),
            gives: self.gives,
            faults: self.faults,
            belief: self.belief,
            seed,
            waypoints: TOUR.map(Point2::from).to_vec(),
            limit_s: self.limit_s,
        };
        let mut avoider = PotentialField::new(&self.params, &self.robot).unwrap();
        let result = run.drive(&mut avoider, pose2(-3.97, -4.0, FRAC_PI_2));
        println!(
            "{:?} seed {seed}: {} of 6, {:.1} s, {:.1} m, clearance {:.3} m, error {:.3} m, stuck {:?}",
            self.belief,
            result.n_reached,
            result.time_s,
            result.driven_m,
            result.least_m,
            result.error_m,
            result.stuck
        );
        result
    }
}

/// DC-A5.
#[test]
fn with_its_true_pose_the_robot_does_the_whole_tour() {
    for gives in [Gives::Scan, Gives::Cloud] {
        let result = Tour { gives, ..Tour::new(pioneer()) }.drive(1);
        assert!(result.is_complete && result.time_s <= 30.0 && result.least_m >= 0.267);
    }
}

/// DC-A6.
#[test]
fn with_fixes_of_5_m_fused_once_a_second_nearly_every_tour_is_done() {
    let tour = Tour { belief: Belief::Fused(5.0), ..Tour::new(pioneer()) };
    let results: Vec<Result> = (1..=20).map(|seed| tour.drive(seed)).collect();
    assert!(results.iter().filter(|result| result.is_complete).count() >= 19);
    assert!(results.iter().all(|result| result.least_m >= 0.25 && result.error_m <= 0.15));
}

/// DC-A7.
#[test]
fn with_the_mean_of_three_good_fixes_nearly_every_tour_is_done() {
    let tour = Tour { belief: Belief::MeanOfThree(0.2), ..Tour::new(pioneer()) };
    let results: Vec<Result> = (1..=20).map(|seed| tour.drive(seed)).collect();
    assert!(results.iter().filter(|result| result.is_complete).count() >= 19);
    assert!(results.iter().all(|result| result.least_m >= 0.24));
}

/// DC-A5 to A7 with the accelerations of a real robot.
#[test]
fn with_real_wheels_the_tours_are_done_too() {
    for belief in [Belief::True, Belief::Fused(5.0), Belief::MeanOfThree(0.2)] {
        let tour = Tour { belief, ..Tour::new(heavy_pioneer()) };
        let results: Vec<Result> = (1..=20).map(|seed| tour.drive(seed)).collect();
        assert!(results.iter().filter(|result| result.is_complete).count() >= 19, "{belief:?}");
        assert!(results.iter().all(|result| result.least_m >= 0.267), "{belief:?}");
    }
}

/// DC-A8, the part of the robot: it dithers in the door of the office, where the specification says.
#[test]
fn the_published_near_rule_is_stuck_in_the_door() {
    let mut tour = Tour { limit_s: 60.0, ..Tour::new(pioneer()) };
    (tour.params.near_rule, tour.params.brakes) = (NearRule::SpinInPlace, false);
    (tour.params.repulsion.near_field, tour.params.saturation) = (NearField::Sign, Saturation::Clamp);
    let result = tour.drive(1);
    assert!(!result.is_complete && result.n_reached == 3);
    let (_, at) = result.stuck.unwrap();
    assert!((at - Point2::new(-0.35, -0.26)).norm() < 0.3, "{at}");
}

/// DC-A9: 1.2 m/s beyond 1.5 m, linear to none at 0.5 m, and no overshoot.
#[test]
fn toward_a_single_goal_the_speed_is_as_published() {
    let place = Place::empty();
    let run = Run {
        place: &place,
        robot: pioneer(),
        gives: Gives::Scan,
        faults: Faults::default(),
        belief: Belief::True,
        seed: 1,
        waypoints: vec![Point2::new(5.0, 0.0)],
        limit_s: 30.0,
    };
    let params = PotentialFieldParams::default();
    let result = run.drive(&mut PotentialField::new(&params, &pioneer()).unwrap(), pose2(0.0, 0.0, 0.0));
    assert!(result.is_complete);
    let before = std::iter::once(Point2::origin()).chain(result.way.iter().copied());
    for (at, twist) in before.zip(&result.twists) {
        let left_m = 5.0 - at.x;
        let expected_m_s = 1.2 * (left_m - 0.5).clamp(0.0, 1.0);
        assert!((twist.forward_m_s - expected_m_s).abs() < 1e-9, "{left_m} {twist:?}");
        assert!(left_m > 0.5);
    }
    assert!(5.0 - result.end.translation.x <= ARRIVAL_RADIUS_M);
    assert!((result.time_s - result.way.len() as f64 * STEP_S).abs() < 1e-9);
}

/// DC-A11: 30 % of the pixels have no reading.
#[test]
fn a_camera_that_loses_a_third_of_its_pixels_leads_into_nothing() {
    for gives in [Gives::Scan, Gives::Cloud] {
        for robot in [pioneer(), heavy_pioneer()] {
            let tour = Tour { gives, faults: Faults { lost: 0.3, ..Faults::default() }, ..Tour::new(robot) };
            for seed in 1..=5 {
                let result = tour.drive(seed);
                assert!(result.is_complete && result.least_m >= 0.267);
            }
        }
    }
}

/// Section 16: a real camera reads nothing nearer than half a meter, exactly where the robot must turn.
#[test]
fn a_camera_that_reads_nothing_near_leads_into_nothing() {
    for gives in [Gives::Scan, Gives::Cloud] {
        for robot in [pioneer(), heavy_pioneer()] {
            let result =
                Tour { gives, faults: Faults { least_m: 0.5, lost: 0.0 }, ..Tour::new(robot) }.drive(1);
            assert!(result.least_m >= 0.267 && result.is_complete);
        }
    }
}

/// Section 16: the nearest of every sector, and remembered points that push.
#[test]
fn sectors_and_memory_do_the_tour_as_well() {
    for (push_from, seconds, repel) in
        [(PushFrom::Sectors, 5.0, false), (PushFrom::Closest, 0.0, false), (PushFrom::Closest, 5.0, true)]
    {
        let mut tour = Tour::new(pioneer());
        tour.params.repulsion_from = push_from;
        (tour.params.memory.seconds, tour.params.memory.repel) = (seconds, repel);
        let result = tour.drive(1);
        println!("  {push_from:?} memory {seconds} s, pushes {repel}");
        assert!(result.is_complete, "{push_from:?} {seconds} {repel}");
    }
}
