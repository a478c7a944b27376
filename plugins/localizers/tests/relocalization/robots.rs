//! Robots that nobody told where they are.

use super::relocalization_work::{Laser, Office};
use super::robot::Robot;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_core::map::Layer;
use rumbo_core::messages::{Estimate, ObservationKind, Status, Wish};
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::rng::stream;
use rumbo_localizers::landmark_noise::LandmarkNoiseParams;
use rumbo_localizers::landmark_relaxation::{LandmarkRelaxationParams, ModelCache};

fn defaults() -> LandmarkRelaxationParams {
    LandmarkRelaxationParams::default()
}

#[test]
fn a_robot_that_turns_once_is_found_and_followed_by_the_odometer() {
    let office = Office::named("5x5");
    for (mount, seed) in [(Pose2::identity(), 1), (pose2(0.15, 0.05, 0.2), 2)] {
        let laser = Laser { base_from_sensor: mount, ..Laser::lms200() };
        let start = office.pose(&mut stream(seed, "start"));
        let mut robot = Robot::new(&office, &defaults(), laser, start);
        let first = robot.step();
        assert_eq!((first.status, first.wish), (Status::Converging, Some(Wish::HoldStill)));
        let found = robot.search();
        let [off_m, off_deg] = robot.off(&found);
        assert!(found.status == Status::Tracking && off_m < 0.01 && off_deg < 0.5, "{off_m} {off_deg}");
        assert!(robot.driven_m == 0.0 && robot.counter("second_observations") == 0.0);
        assert!(robot.counter("model_cells") == 9606.0 && robot.counter("model_bytes") < 950_000.0);
        assert!(robot.counter("candidates") >= 1.0 && robot.counter("matches") >= 2.0);
        assert!(robot.counter("landmarks") > 5.0 && robot.counter("model_progress") == 1.0);
        let half_a_turn = robot.map_from_base.rotation.angle_to(&start.rotation).abs();
        assert!((half_a_turn - std::f64::consts::PI).abs() < 0.1, "{half_a_turn}");
        let after = robot.step();
        assert!(after.status == Status::Tracking && after.wish.is_none() && robot.off(&after)[0] < 0.01);
    }
}

#[test]
fn a_laser_that_sees_all_around_needs_no_turn() {
    let office = Office::named("5x5");
    let start = office.pose(&mut stream(7, "start"));
    let mut robot = Robot::new(&office, &defaults(), Laser::round(), start);
    let found = robot.search();
    assert!(found.status == Status::Tracking && robot.off(&found)[0] < 0.01);
    assert_eq!(robot.map_from_base, start);
}

#[test]
fn without_moves_what_one_scan_shows_must_do() {
    let office = Office::named("5x5");
    let params = LandmarkRelaxationParams { moves: false, ..defaults() };
    let mut n_found = 0;
    for seed in 0..8 {
        let start = office.pose(&mut stream(seed, "start"));
        let mut robot = Robot::new(&office, &params, Laser::lms200(), start);
        let end = loop {
            let estimate = robot.step();
            assert!(matches!(estimate.wish, None | Some(Wish::HoldStill)), "{:?}", estimate.wish);
            if estimate.status != Status::Converging {
                break estimate;
            }
        };
        assert_eq!(robot.map_from_base, start);
        if end.status == Status::Tracking {
            n_found += 1;
            assert!(robot.off(&end)[0] < 0.10, "{seed}: {:?}", robot.off(&end));
        }
    }
    assert!(n_found >= 4, "{n_found}");
}

#[test]
fn a_robot_that_cannot_turn_is_not_waited_for() {
    let office = Office::named("5x5");
    let start = office.pose(&mut stream(3, "start"));
    let mut robot = Robot::new(&office, &defaults(), Laser::lms200(), start);
    robot.is_stuck = true;
    let end = robot.search();
    assert!(end.status != Status::Tracking || robot.off(&end)[0] < 0.10);
}

/// Two rooms that look the same, with doors to a corridor that does not.
fn doors() -> Office {
    Office::drawn(
        5,
        "
        #############################################
        #.............#.............#...............#
        #..##.........#..##.........#...............#
        #..##.........#..##.........#...............#
        #.............#.............#...............#
        #.............#.............#...............#
        #.............#.............#...............#
        #.............#.............#...............#
        #.............#.............#...............#
        #.............#.............#...............#
        #####.....#########.....#####...............#
        #...........................................#
        #...........................................#
        #...........................................#
        ####........................................#
        ####........................................#
        ##############......#########################",
    )
}

#[test]
fn where_two_rooms_look_alike_the_robot_goes_to_see_more_and_is_found() {
    let office = doors();
    let (mut n_moved, mut n_found) = (0, 0);
    let mut rng = stream(11, "doors");
    const N: usize = 20;
    for _ in 0..N {
        let start = loop {
            let pose = office.pose(&mut rng);
            let is_in_a_room = pose.translation.y > 1.9 && pose.translation.x < 7.0;
            if is_in_a_room {
                break pose;
            }
        };
        let mut robot = Robot::new(&office, &defaults(), Laser::lms200(), start);
        let (mut ambiguous, mut end) = (None, robot.step());
        for _ in 0..18_000 {
            if end.status == Status::Tracking || end.wish.is_none() {
                break;
            }
            if end.status == Status::Ambiguous {
                ambiguous = Some(end.clone());
            }
            end = robot.step();
        }
        if let Some(estimate) = &ambiguous {
            n_moved += 1;
            assert!(robot.counter("second_observations") >= 1.0);
            let scores: f64 = estimate.candidates.iter().map(|candidate| candidate.score).sum();
            assert!((scores - 1.0).abs() < 1e-9 && estimate.candidates.len() >= 2);
        }
        if end.status == Status::Tracking {
            n_found += 1;
            assert!(robot.off(&end)[0] < 0.10, "put {:?} off, begun at {start}", robot.off(&end));
        }
    }
    assert!(n_moved >= 5 && n_found * 100 >= N * 95, "{n_moved} moved, {n_found} found");
}

#[test]
fn where_there_is_nothing_to_see_the_search_ends_and_says_so() {
    let field = ["....................................."; 37].join("\n");
    let office = Office::drawn(20, &field);
    let mut robot = Robot::new(&office, &defaults(), Laser::lms200(), pose2(18.0, 18.0, 0.3));
    let end = robot.search();
    assert_eq!((end.status, end.wish), (Status::Lost, None));
    assert_eq!(robot.counter("second_observations"), 3.0);
    for _ in 0..50 {
        assert_eq!(robot.step().wish, None);
    }
}

#[test]
fn the_same_search_gives_the_same_estimates() {
    let office = Office::named("5x5");
    let start = office.pose(&mut stream(5, "start"));
    let params =
        LandmarkRelaxationParams { landmark_noise: Some(LandmarkNoiseParams::default()), ..defaults() };
    let run = |n_threads: usize| -> Vec<Estimate> {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n_threads).build().unwrap();
        pool.install(|| {
            let mut robot = Robot::new(&office, &params, Laser::lms200(), start);
            (0..80).map(|_| robot.step()).collect()
        })
    };
    let (one, many) = (run(1), run(4));
    assert!(one == many && one.last().unwrap().status == Status::Tracking);
}

#[test]
fn it_says_what_it_needs_and_refuses_what_cannot_be() {
    let manifest = defaults().manifest();
    assert_eq!(manifest.needs_layers, [Layer::Grid]);
    assert_eq!(manifest.consumes, [[ObservationKind::LaserScan], [ObservationKind::Odometry]]);
    assert!(manifest.wishes_motion && !manifest.needs_start_pose);
    assert!(!LandmarkRelaxationParams { moves: false, ..defaults() }.manifest().wishes_motion);
    assert!(defaults().check().is_empty());
    let noise = LandmarkNoiseParams { share: 1.5, distance_m: -1.0, bearing_deg: f64::NAN };
    let bad = LandmarkRelaxationParams {
        range_m: f64::NAN,
        ray_step_deg: 0.0,
        relation_m: -1.0,
        least_explained: 2.0,
        sure_explained: -0.5,
        most_moves: 1000,
        cache: ModelCache::None,
        cache_file: Some("office.landmark_model".into()),
        landmark_noise: Some(noise),
        ..defaults()
    };
    let faults: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    assert_eq!(
        faults,
        [
            "range_m",
            "ray_step_deg",
            "relation_m",
            "least_explained",
            "sure_explained",
            "most_moves",
            "landmark_noise.share",
            "landmark_noise.distance_m",
            "landmark_noise.bearing_deg",
            "cache_file"
        ]
    );
}
