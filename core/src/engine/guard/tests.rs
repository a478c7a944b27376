use super::*;
use crate::boundary::Buffer;
use crate::frames::Pose3;
use crate::messages::{Data, LaserScan, PointCloud};
use crate::robot::{Drive, SteeredWheel};

const LASER: SensorId = SensorId(0);
const PERIOD: Span = Span(100_000_000);

/// One beam that hits at (bearing, range).
fn hit(stamp_s: f64, bearing_rad: f64, range_m: f32) -> Observation {
    let scan = LaserScan {
        first_bearing_rad: bearing_rad,
        bearing_step_rad: 0.01,
        max_range_m: 8.0,
        ranges_m: Buffer::filled(1, range_m),
        ..LaserScan::default()
    };
    Observation {
        sensor: LASER,
        stamp: Time::from_secs(stamp_s),
        base_from_sensor: Pose3::identity(),
        valid: true,
        data: Data::LaserScan(scan),
    }
}

fn situation(now_s: f64) -> Situation {
    Situation {
        now: Time::from_secs(now_s),
        odom_from_base: Pose2::identity(),
        stage_failed: false,
        deadline_missed: false,
    }
}

/// A guard in the middle of a drive at this twist.
fn driving(robot: Robot, twist: Twist) -> (Guard, Vec<Event>) {
    let (mut guard, mut events) = (Guard::new(Arc::new(robot), PERIOD, &[]), Vec::new());
    for k in 0..100 {
        guard.limit(twist, &situation(k as f64 * 0.1), &mut events);
    }
    (guard, events)
}

fn kinds(events: &[Event]) -> Vec<Intervention> {
    let of = |e: &Event| if let EventKind::Guard(i) = e.kind { Some(i) } else { None };
    events.iter().filter_map(of).collect()
}

#[test]
fn not_a_number_stops_the_robot_and_is_said_once() {
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.02, 0.0));
    assert!(events.is_empty());
    for (k, bad) in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].into_iter().enumerate() {
        let twist = guard.limit(Twist::new(0.1, bad), &situation(20.0 + k as f64), &mut events);
        assert_eq!(twist, Twist::ZERO);
    }
    assert_eq!(kinds(&events), [Intervention::NotFinite]);
}

#[test]
fn too_fast_a_twist_is_scaled_whole_so_that_the_curve_stays() {
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(5.0, 2.0));
    let twist = guard.limit(Twist::new(5.0, 2.0), &situation(20.0), &mut events);
    assert!((twist.forward_m_s - 0.5).abs() < 1e-9 && (twist.turn_rad_s - 0.2).abs() < 1e-9, "{twist:?}");
    assert_eq!(kinds(&events), [Intervention::TooFast]);
}

#[test]
fn a_change_of_speed_takes_the_time_that_the_limits_say() {
    let robot = Robot { max_accel_m_s2: 0.2, ..Robot::default() };
    let (mut guard, mut events) = (Guard::new(Arc::new(robot), PERIOD, &[]), Vec::new());
    guard.limit(Twist::ZERO, &situation(0.0), &mut events);
    let at = |guard: &mut Guard, t: f64, events: &mut Vec<Event>| {
        guard.limit(Twist::new(0.5, 0.0), &situation(t), events).forward_m_s
    };
    assert!((at(&mut guard, 0.1, &mut events) - 0.02).abs() < 1e-9);
    assert!((at(&mut guard, 0.6, &mut events) - 0.12).abs() < 1e-9);
    assert!(events.is_empty(), "ramps are no interventions");
}

#[test]
fn the_robot_stops_before_what_it_drives_towards_and_may_still_turn_and_retreat() {
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.3, 0.0));
    guard.see(&hit(20.0, 0.0, 0.22), &Pose2::identity());
    let ahead = guard.limit(Twist::new(0.3, 0.0), &situation(20.0), &mut events);
    assert_eq!(ahead, Twist::ZERO);
    assert_eq!(kinds(&events), [Intervention::StopZone]);
    let turning = guard.limit(Twist::new(0.0, 0.1), &situation(20.1), &mut events);
    assert!((turning.turn_rad_s - 0.1).abs() < 1e-9);
    let back = guard.limit(Twist::new(-0.05, 0.0), &situation(20.2), &mut events);
    assert!((back.forward_m_s + 0.05).abs() < 1e-9);
}

#[test]
fn the_stopping_distance_follows_the_formula() {
    // Hull 0.20, margin 0.03; 0.5 m/s needs 0.5²/(2·0.5) + 0.5·0.1 = 0.30 m.
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.5, 0.0));
    guard.see(&hit(20.0, 0.0, 0.54), &Pose2::identity());
    let free = guard.limit(Twist::new(0.5, 0.0), &situation(20.0), &mut events);
    assert!((free.forward_m_s - 0.5).abs() < 1e-9);
    guard.see(&hit(20.1, 0.0, 0.40), &Pose2::identity());
    let slow = guard.limit(Twist::new(0.5, 0.0), &situation(20.1), &mut events).forward_m_s;
    let stops_in = slow * slow + slow * 0.1;
    assert!(stops_in <= 0.17 + 1e-9 && stops_in > 0.13, "{slow} m/s stops in {stops_in} m");
}

#[test]
fn a_point_beside_the_way_is_passed() {
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.3, 0.0));
    guard.see(&hit(20.0, std::f64::consts::FRAC_PI_2, 0.24), &Pose2::identity());
    let twist = guard.limit(Twist::new(0.3, 0.0), &situation(20.0), &mut events);
    assert!((twist.forward_m_s - 0.3).abs() < 1e-9 && events.is_empty());
}

#[test]
fn a_reading_moves_with_the_robot() {
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.3, 0.0));
    guard.see(&hit(20.0, 0.0, 0.60), &Pose2::identity());
    let moved = Situation { odom_from_base: crate::frames::pose2(0.38, 0.0, 0.0), ..situation(20.0) };
    assert_eq!(guard.limit(Twist::new(0.3, 0.0), &moved, &mut events), Twist::ZERO);
}

#[test]
fn a_turning_corner_of_a_long_hull_is_watched() {
    let footprint_m = vec![[-0.5, -0.1], [0.5, -0.1], [0.5, 0.1], [-0.5, 0.1]];
    let (mut guard, mut events) = driving(Robot { footprint_m, ..Robot::default() }, Twist::new(0.0, 0.3));
    guard.see(&hit(20.0, 0.26, 0.50), &Pose2::identity());
    let into = guard.limit(Twist::new(0.0, 0.3), &situation(20.0), &mut events);
    assert!(into.turn_rad_s < 0.1, "{into:?}");
    let away = guard.limit(Twist::new(0.0, -0.05), &situation(21.0), &mut events);
    assert!((away.turn_rad_s + 0.05).abs() < 1e-9, "{away:?}");
}

#[test]
fn an_old_scan_and_a_failed_stage_stop_the_robot() {
    let robot = Arc::new(Robot::default());
    let (mut guard, mut events) = (Guard::new(robot, PERIOD, &[LASER]), Vec::new());
    for k in 0..10 {
        guard.see(&hit(k as f64, 0.0, 7.0), &Pose2::identity());
        guard.limit(Twist::new(0.1, 0.0), &situation(k as f64), &mut events);
    }
    assert!(events.is_empty());
    assert!(guard.limit(Twist::new(0.1, 0.0), &situation(9.9), &mut events).forward_m_s > 0.09);
    guard.limit(Twist::new(0.1, 0.0), &situation(10.2), &mut events);
    assert_eq!(kinds(&events), [Intervention::Stale]);
    let failed = Situation { stage_failed: true, ..situation(10.3) };
    guard.limit(Twist::new(0.1, 0.0), &failed, &mut events);
    assert_eq!(kinds(&events), [Intervention::Stale, Intervention::StageFailed]);
    let late = Situation { deadline_missed: true, ..situation(10.4) };
    assert_eq!(guard.limit(Twist::new(0.1, 0.0), &late, &mut events), Twist::ZERO);
    assert_eq!(kinds(&events).last(), Some(&Intervention::Deadline));
}

#[test]
fn a_tricycle_is_never_told_to_turn_in_place() {
    let drive = Drive::Tricycle {
        wheelbase_m: 1.0,
        track_m: 0.8,
        max_steer_deg: 45.0,
        max_steer_rate_deg_s: 60.0,
        steered: SteeredWheel::Front,
    };
    let (mut guard, mut events) = driving(Robot { drive, ..Robot::default() }, Twist::ZERO);
    let twist = guard.limit(Twist::new(0.0, 0.5), &situation(20.0), &mut events);
    assert_eq!(twist, Twist::ZERO);
    assert_eq!(kinds(&events), [Intervention::Infeasible]);
}

#[test]
fn a_turn_that_fades_slowly_does_not_delay_the_brakes() {
    let robot = Robot { max_turn_accel_deg_s2: 1.0, ..Robot::default() };
    let (mut guard, mut events) = (Guard::new(Arc::new(robot), PERIOD, &[]), Vec::new());
    for k in 0..600 {
        guard.limit(Twist::new(0.4, 0.5), &situation(k as f64 * 0.1), &mut events);
    }
    let stopped = (0..9)
        .map(|k| guard.limit(Twist::ZERO, &situation(60.0 + k as f64 * 0.1), &mut events))
        .last()
        .unwrap();
    assert_eq!(stopped.forward_m_s, 0.0, "0.4 m/s takes 0.8 s at 0.5 m/s2");
    assert!(stopped.turn_rad_s > 0.3);
}

#[test]
fn what_only_the_last_of_many_dense_scanners_sees_stops_the_robot_too() {
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.3, 0.0));
    let dense = |sensor: u16, range_m: f32, n: usize| {
        let scan = LaserScan {
            first_bearing_rad: 2.0,
            bearing_step_rad: 1e-5,
            max_range_m: 8.0,
            ranges_m: Buffer::filled(n, range_m),
            ..LaserScan::default()
        };
        Observation { sensor: SensorId(sensor), data: Data::LaserScan(scan), ..hit(20.0, 0.0, 1.0) }
    };
    guard.see(&dense(1, 0.4, 20_000), &Pose2::identity());
    guard.see(&dense(2, 0.4, 20_000), &Pose2::identity());
    guard.see(&Observation { sensor: SensorId(3), ..hit(20.0, 0.0, 0.22) }, &Pose2::identity());
    assert_eq!(guard.limit(Twist::new(0.3, 0.0), &situation(20.0), &mut events), Twist::ZERO);
}

/// A camera 0.3 m over the floor, whose cloud has these points of its own frame.
fn cloud(stamp_s: f64, points_m: &[[f32; 3]]) -> Observation {
    let data = Data::PointCloud(PointCloud { points_m: points_m.into() });
    let base_from_sensor = Pose3::translation(0.0, 0.0, 0.3);
    Observation { base_from_sensor, data, ..hit(stamp_s, 0.0, 1.0) }
}

#[test]
fn a_cloud_of_points_stops_the_robot_but_floor_and_what_hangs_overhead_do_not() {
    let passed = [
        [0.25, 0.0, -0.3],
        // Higher than the robot, which is 0.5 m.
        [0.25, 0.0, 0.25],
        [f32::NAN; 3],
        [5.0, 0.0, 0.0],
    ];
    let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.3, 0.0));
    guard.see(&cloud(20.0, &passed), &Pose2::identity());
    let free = guard.limit(Twist::new(0.3, 0.0), &situation(20.0), &mut events);
    assert!((free.forward_m_s - 0.3).abs() < 1e-9 && events.is_empty(), "{free:?}");
    let stopped = [passed.as_slice(), &[[0.22, 0.0, -0.1]]].concat();
    guard.see(&cloud(20.1, &stopped), &Pose2::identity());
    assert_eq!(guard.limit(Twist::new(0.3, 0.0), &situation(20.1), &mut events), Twist::ZERO);
    assert_eq!(kinds(&events), [Intervention::StopZone]);
}

#[test]
fn the_scan_and_the_cloud_of_one_camera_both_count() {
    for order in [[0, 1], [1, 0]] {
        let (mut guard, mut events) = driving(Robot::default(), Twist::new(0.3, 0.0));
        for k in order {
            let seen = if k == 0 { hit(20.0, 0.0, 0.22) } else { cloud(20.0, &[[f32::NAN; 3]]) };
            guard.see(&seen, &Pose2::identity());
        }
        assert_eq!(guard.limit(Twist::new(0.3, 0.0), &situation(20.0), &mut events), Twist::ZERO);
    }
}
