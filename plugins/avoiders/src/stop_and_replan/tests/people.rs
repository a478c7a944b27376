//! People who walk: waited for, let by, and obstacles only when they stand.

use super::by_sound_and_touch::touch;
use super::*;

const BODY_M: f64 = 0.25;

/// What became of a robot that follows a straight way of 4 m along x.
struct Meeting {
    /// The first answer that is no `Drive`, and when.
    other: Option<(f64, Steering)>,
    /// Time and speed at each step.
    speeds: Vec<(f64, f64)>,
    /// The smallest gap between hull and body, meters.
    nearest_m: f64,
    /// The robot's speed when it was first touched.
    touched_m_s: Option<f64>,
}

/// Somebody is at `person(time)`, seen by the scanner five times a second.
fn meet(bench: &mut Bench, limit_s: f64, person: impl Fn(f64) -> Point2) -> Meeting {
    let start = bench.now;
    let mut met = Meeting { other: None, speeds: Vec::new(), nearest_m: f64::INFINITY, touched_m_s: None };
    for step in 0..(limit_s / PERIOD_S) as usize {
        let time_s = (bench.now - start).as_secs();
        bench.discs = vec![(person(time_s), BODY_M)];
        let gap_m = (person(time_s).coords - bench.pose.translation.vector).norm() - BODY_M - 0.20;
        met.nearest_m = met.nearest_m.min(gap_m);
        if gap_m <= 0.0 {
            // He walks on, through the robot.
            met.touched_m_s.get_or_insert(bench.twist.forward_m_s);
        }
        let seen = if step % 2 == 0 { vec![bench.scan()] } else { Vec::new() };
        match bench.steer(&seen).unwrap() {
            Steering::Drive(twist) => bench.obey(twist),
            other => {
                met.other = Some((time_s, other));
                break;
            }
        }
        met.speeds.push((time_s, bench.twist.forward_m_s));
    }
    met
}

fn bench(params: StopAndReplanParams) -> Bench {
    let mut bench = Bench::new(params);
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    bench
}

/// Crosses the way 1.2 m ahead.
fn crosses(speed_m_s: f64) -> impl Fn(f64) -> Point2 {
    move |time_s| Point2::new(1.2, 4.0 - speed_m_s * time_s)
}

#[test]
fn who_crosses_is_let_by_and_never_an_obstacle() {
    for speed_m_s in [0.5, 0.8, 1.2] {
        let met = meet(&mut bench(StopAndReplanParams::default()), 60.0, crosses(speed_m_s));
        let (time_s, other) = met.other.unwrap();
        assert_eq!(other, Steering::Arrived, "{speed_m_s} m/s, after {time_s} s");
        assert!(met.nearest_m > 0.1, "{speed_m_s} m/s: {}", met.nearest_m);
    }
}

#[test]
fn without_people_who_crosses_is_an_obstacle_as_published() {
    for params in [
        Bench::thesis_params(),
        StopAndReplanParams {
            people: PeopleParams { horizon_s: 0.0, ..PeopleParams::default() },
            ..StopAndReplanParams::default()
        },
    ] {
        // He stands in the way when the robot comes.
        let stands = |time_s: f64| Point2::new(1.2, (4.0 - 0.8 * time_s).max(0.0));
        let met = meet(&mut bench(params), 60.0, stands);
        assert!(matches!(met.other, Some((_, Steering::Blocked { .. }))));
    }
}

#[test]
fn who_walks_straight_at_the_robot_meets_one_that_stands_or_backs_off() {
    for (speed_m_s, beside_m) in [(0.5, 0.0), (1.2, 0.0), (0.8, 0.15), (0.8, -0.3)] {
        let comes = |time_s: f64| Point2::new(6.0 - speed_m_s * time_s, beside_m);
        let met = meet(&mut bench(StopAndReplanParams::default()), 30.0, comes);
        assert!(met.touched_m_s.is_none_or(|speed| speed <= 0.0), "{speed_m_s} m/s: {:?}", met.touched_m_s);
        assert!(met.speeds.iter().any(|(_, speed)| *speed > 0.0), "it drove at first");
    }
}

#[test]
fn who_has_stopped_in_the_way_is_an_obstacle_that_stands() {
    let stops = |time_s: f64| Point2::new(1.6, (3.0 - 0.8 * time_s).max(0.0));
    let met = meet(&mut bench(StopAndReplanParams::default()), 30.0, stops);
    let Some((time_s, Steering::Blocked { obstacles })) = met.other else { panic!("{:?}", met.other) };
    assert!(time_s > 3.0 && !obstacles.is_empty(), "{time_s}");
    for obstacle in obstacles {
        assert!((obstacle.position - Point2::new(1.6, 0.0)).norm() < BODY_M + 0.05, "{obstacle:?}");
    }
}

#[test]
fn who_walks_to_and_fro_for_ever_costs_one_other_path_and_is_passed_in_the_end() {
    let mut bench = bench(StopAndReplanParams::default());
    let start = bench.now;
    let (mut n_blocked, mut has_arrived) = (0, false);
    for _ in 0..5 {
        let begun_s = (bench.now - start).as_secs();
        let paces = |time_s: f64| {
            let phase_m = (0.7 * (begun_s + time_s)) % 4.0;
            Point2::new(1.2, (2.0 - phase_m).abs() - 1.0)
        };
        match meet(&mut bench, 120.0, paces).other {
            Some((_, Steering::Blocked { .. })) => n_blocked += 1,
            Some((_, Steering::Arrived)) => {
                has_arrived = true;
                break;
            }
            other => panic!("{other:?}"),
        }
        // No other path is known: the same again.
        let here = bench.pose.translation.vector;
        bench.follow(&[(here.x, here.y), (4.0, 0.0)]);
    }
    assert!(has_arrived && n_blocked <= 2, "{n_blocked}");
}

#[test]
fn a_scanner_that_hangs_upside_down_sees_the_same_people() {
    let mut upright = Bench::new(StopAndReplanParams::default());
    let mut hanging = Bench::new(StopAndReplanParams::default());
    let roll = Pose3::from_parts(
        nalgebra::Translation3::identity(),
        nalgebra::UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0),
    );
    for bench in [&mut upright, &mut hanging] {
        bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    }
    for step in 0..40 {
        let person = Point2::new(1.5, 2.5 - 0.08 * f64::from(step));
        upright.discs = vec![(person, BODY_M)];
        let scan = upright.scan();
        let Data::LaserScan(seen) = &scan.data else { panic!("no scan") };
        let mut ranges = seen.ranges_m.to_vec();
        ranges.reverse();
        let turned = Observation { base_from_sensor: roll, data: scan_of(ranges), ..scan.clone() };
        let answers = (upright.steer(&[scan]).unwrap(), hanging.steer(&[turned]).unwrap());
        let (Steering::Drive(one), Steering::Drive(other)) = answers else { panic!("{answers:?}") };
        assert!((one.forward_m_s - other.forward_m_s).abs() < 1e-9, "step {step}: {one:?} {other:?}");
        upright.obey(one);
        hanging.obey(other);
    }
}

#[test]
fn what_touches_a_robot_that_stands_came_to_it_and_is_no_obstacle_until_it_stays() {
    let mut bench = bench(StopAndReplanParams::default());
    // Held by an echo in doubt or by a person: here simply without a first scan.
    let mut answers = Vec::new();
    for step in 0..120 {
        let is_touched = step >= 8;
        let mut seen = vec![hits(bench.now, &[(0.29, 0.0)])];
        if step < 8 {
            seen = Vec::new();
        }
        if is_touched {
            seen.push(touch(bench.now, 1 << 4));
        }
        let answer = bench.steer(&seen).unwrap();
        let is_drive = answer == Steering::Drive(Twist::ZERO);
        answers.push(is_drive);
        if !is_drive {
            break;
        }
        bench.now = bench.now + Span::from_secs(PERIOD_S);
    }
    // Patience of 8 s.
    assert!(answers.len() > 80 && answers.len() < 95 && !answers[answers.len() - 1], "{}", answers.len());
}
