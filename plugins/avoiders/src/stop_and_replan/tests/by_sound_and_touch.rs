//! What only sonar hears or bumpers touch.

use super::*;
use rumbo_core::messages::Bumpers;

/// Pane of glass through a point, with the direction from it to the robot's side; endless unless `half_m` says otherwise.
struct Pane {
    at: Point2,
    normal_rad: f64,
    half_m: f64,
}

impl Pane {
    fn normal(&self) -> nalgebra::Vector2<f64> {
        nalgebra::Vector2::new(self.normal_rad.cos(), self.normal_rad.sin())
    }

    /// What a ring of 16 transducers reads: the nearest of rays within 12.5 degrees of each axis that meet the pane within
    /// 6 degrees of its normal.
    fn ring(&self, map_from_base: &Pose2) -> [f32; 16] {
        std::array::from_fn(|k| {
            let axis_rad = 22.5f64.to_radians() * k as f64;
            let tip = map_from_base * Point2::new(0.2 * axis_rad.cos(), 0.2 * axis_rad.sin());
            let ways = (-25..=25).filter_map(|half_deg| {
                let ray_rad =
                    map_from_base.rotation.angle() + axis_rad + (f64::from(half_deg) / 2.0).to_radians();
                let ray = nalgebra::Vector2::new(ray_rad.cos(), ray_rad.sin());
                let way_m = (self.at - tip).dot(&self.normal()) / ray.dot(&self.normal());
                let beside_m = (tip + ray * way_m - self.at).norm();
                let squarely = -ray.dot(&self.normal()) >= 6f64.to_radians().cos();
                (squarely && way_m > 0.0 && beside_m <= self.half_m).then_some(way_m)
            });
            let way_m = ways.fold(f64::INFINITY, f64::min) as f32;
            if way_m < 0.15 { f32::NAN } else { way_m }
        })
    }
}

/// Drives ahead from the origin towards a pane until the avoider is blocked by it.
fn drive_to(pane: &Pane, params: StopAndReplanParams) -> Option<(Pose2, Vec<Obstacle>)> {
    let mut bench = Bench::new(params);
    bench.grid = Some(grid_with(&[], 0.0));
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    for _ in 0..300 {
        let seen = [hits(bench.now, &[]), observe(bench.now, ring_of(pane.ring(&bench.pose)))];
        match bench.steer(&seen).unwrap() {
            Steering::Drive(twist) => bench.obey(twist),
            Steering::Blocked { obstacles } => return Some((bench.pose, obstacles)),
            _ => return None,
        }
        let clear_m = (Point2::from(bench.pose.translation.vector) - pane.at).dot(&pane.normal());
        if clear_m < 0.20 {
            return None;
        }
    }
    None
}

#[test]
fn a_pane_is_found_at_any_incidence_and_its_points_lie_on_it() {
    for incidence_deg in [-45, -40, -34, -20, -7, 0, 3, 11, 25, 38, 45] {
        let normal_rad = std::f64::consts::PI + f64::from(incidence_deg).to_radians();
        let pane = Pane { at: Point2::new(2.0, 0.0), normal_rad, half_m: 0.6 };
        let (pose, obstacles) = drive_to(&pane, StopAndReplanParams::default()).unwrap();
        let clear_m = (Point2::from(pose.translation.vector) - pane.at).dot(&pane.normal()) - 0.20;
        assert!(clear_m > 0.2, "{incidence_deg} degrees: stopped {clear_m} m before it");
        // The arc may be wrong by the cone; half of it is not.
        let nearest_m = obstacles.iter().map(|o| (o.position - pane.at).dot(&pane.normal()).abs());
        assert!(nearest_m.fold(f64::INFINITY, f64::min) < 0.05, "{incidence_deg}: {obstacles:?}");
        let farthest_m = obstacles.iter().map(|o| (o.position - pane.at).dot(&pane.normal()).abs());
        assert!(farthest_m.fold(0.0, f64::max) < 0.25, "{incidence_deg}: {obstacles:?}");
    }
}

#[test]
fn the_three_front_sonars_of_the_source_miss_a_pane_that_stands_aslant() {
    let found = |incidence_deg: f64, thesis_mode: bool| {
        let normal_rad = std::f64::consts::PI + incidence_deg.to_radians();
        let pane = Pane { at: Point2::new(2.0, 0.0), normal_rad, half_m: 2.0 };
        drive_to(&pane, StopAndReplanParams { thesis_mode, ..StopAndReplanParams::default() }).is_some()
    };
    assert!(found(0.0, true) && found(20.0, true) && !found(45.0, true) && !found(-44.0, true));
    assert!(found(45.0, false) && found(-44.0, false));
}

/// What a robot that drives does about a list of rings, one a period.
fn answers(rings: &[[f32; 16]], grid: Grid) -> Vec<Steering> {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.grid = Some(grid);
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let mut answers = Vec::new();
    for ring in rings {
        let seen = [hits(bench.now, &[]), observe(bench.now, ring_of(*ring))];
        let answer = bench.steer(&seen).unwrap();
        // It stays where it is: the echoes belong to this place.
        bench.now = bench.now + Span::from_secs(PERIOD_S);
        answers.push(answer);
    }
    answers
}

fn ring_with(echoes: &[(usize, f32)]) -> [f32; 16] {
    let mut ring = [f32::INFINITY; 16];
    echoes.iter().for_each(|(idx, range_m)| ring[*idx] = *range_m);
    ring
}

fn drives(steering: &Steering) -> bool {
    matches!(steering, Steering::Drive(twist) if twist.forward_m_s > 0.0)
}

#[test]
fn a_single_short_echo_makes_the_robot_wait_and_listen_but_is_no_obstacle() {
    let free = || grid_with(&[], 0.0);
    let (none, short) = (ring_with(&[]), ring_with(&[(0, 0.25)]));
    let once = answers(&[none, short, none, none], free());
    assert!(
        drives(&once[0]) && once[1] == Steering::Drive(Twist::ZERO) && drives(&once[2]) && drives(&once[3])
    );
    let again = answers(&[none, short, short, short], free());
    assert!(matches!(&again[3], Steering::Blocked { obstacles } if !obstacles.is_empty()), "{again:?}");
    assert!(again[2] == Steering::Drive(Twist::ZERO));
    // Not ahead: the robot passes what is beside it.
    let beside = answers(&[ring_with(&[(4, 0.2)]); 6], free());
    assert!(beside.iter().all(drives));
    // Now and then another transducer's sound, or sound by way of mirrors, at ranges that do not agree.
    let at_m = |k: usize| if k.is_multiple_of(3) { 0.5 + 0.35 * (k as f32 * 0.618).fract() } else { 3.0 };
    let stray: Vec<_> = (0..28).map(|k| ring_with(&[(1, at_m(k))])).collect();
    assert!(answers(&stray, free()).iter().all(drives));
}

#[test]
fn echoes_that_the_map_explains_raise_no_alarm() {
    let known = || grid_with(&[(0.46, 0.0)], 0.03);
    assert!(answers(&[ring_with(&[(0, 0.25)]); 9], known()).iter().all(drives), "as far as on the map");
    let nearer = answers(&[ring_with(&[(0, 0.16)]); 9], grid_with(&[(0.56, 0.0)], 0.03));
    assert!(nearer.iter().any(|answer| matches!(answer, Steering::Blocked { .. })), "nearer than on the map");
    // The estimate may be off sideways by a cell: just beside the cone on the map.
    let beside = grid_with(&[(0.45, 0.09)], 0.01);
    assert!(answers(&[ring_with(&[(0, 0.25)]); 9], beside).iter().all(drives));
}

#[test]
fn what_is_known_by_now_stops_nobody_a_second_time() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.grid = Some(grid_with(&[], 0.0));
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let ring = ring_with(&[(2, 0.25)]);
    let mut n_blocked = 0;
    for _ in 0..20 {
        match bench.steer(&[hits(bench.now, &[]), observe(bench.now, ring_of(ring))]).unwrap() {
            Steering::Blocked { obstacles } => {
                n_blocked += 1;
                let grid = bench.grid.as_mut().unwrap();
                obstacles.iter().for_each(|o| grid.occupy_disc(o.position, o.radius_m));
                bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
            }
            Steering::Drive(_) => {}
            other => panic!("{other:?}"),
        }
        bench.now = bench.now + Span::from_secs(PERIOD_S);
    }
    assert_eq!(n_blocked, 1);
}

#[test]
fn echoes_of_the_time_while_the_robot_waited_are_explained_by_the_scans_of_that_time() {
    // Somebody stood before the robot for three seconds, was seen and heard, and left; only then came a path.
    let mut bench = Bench::new(StopAndReplanParams::default());
    bench.grid = Some(grid_with(&[], 0.0));
    let mut seen = Vec::new();
    for k in 0..30 {
        let is_there = k < 29;
        let legs: &[(f64, f64)] = if is_there { &[(0.0, 0.45), (1.0, 0.45)] } else { &[] };
        let ring = if is_there { ring_with(&[(0, 0.25)]) } else { ring_with(&[]) };
        seen.extend([hits(bench.now, legs), observe(bench.now, ring_of(ring))]);
        bench.now = bench.now + Span::from_secs(PERIOD_S);
    }
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    assert!(drives(&bench.steer(&seen).unwrap()), "nothing is left of it");
}

pub(super) fn touch(stamp: Time, pressed: u64) -> Observation {
    let bumpers = Bumpers {
        n_bumpers: 16,
        pressed,
        first_bearing_rad: 0.0,
        bearing_step_rad: 22.5f64.to_radians(),
        ring_radius_m: 0.20,
    };
    Observation { sensor: SensorId(7), ..observe(stamp, Data::Bumpers(bumpers)) }
}

#[test]
fn a_contact_stops_the_robot_at_once_and_is_an_obstacle_at_the_hull() {
    for params in [StopAndReplanParams::default(), Bench::thesis_params()] {
        for (idx, moves_on) in [(0, true), (2, true), (15, true), (8, false)] {
            let mut bench = Bench::new(params.clone());
            bench.pose = pose2(1.0, -0.5, 0.7);
            // Ahead, or around first: a turning robot is stopped as well.
            let (x, y) = if moves_on { (0.7f64.cos(), 0.7f64.sin()) } else { (-0.7f64.cos(), -0.7f64.sin()) };
            bench.follow(&[(1.0, -0.5), (1.0 + 2.0 * x, -0.5 + 2.0 * y)]);
            let free = bench.steer(&[hits(bench.now, &[]), touch(bench.now, 0)]);
            assert!(matches!(free, Ok(Steering::Drive(twist)) if twist != Twist::ZERO));
            bench.now = bench.now + Span::from_secs(PERIOD_S);
            let met = bench.steer(&[touch(bench.now, 1 << idx)]).unwrap();
            let Steering::Blocked { obstacles } = met else { panic!("{met:?}") };
            let bearing_rad = 22.5f64.to_radians() * f64::from(idx);
            let expected = bench.pose * Point2::new(0.20 * bearing_rad.cos(), 0.20 * bearing_rad.sin());
            assert_eq!(obstacles.len(), 1);
            assert!((obstacles[0].position - expected).norm() < 1e-9 && obstacles[0].radius_m == 0.0);
            assert_eq!(obstacles[0].stamp, bench.now);
            // Still touching while it turns away: known, and no reason to stop again.
            bench.obstacles = obstacles;
            bench.follow(&[(1.0, -0.5), (1.0 - 2.0 * x, -0.5 - 2.0 * y)]);
            bench.now = bench.now + Span::from_secs(PERIOD_S);
            let leaves = bench.steer(&[hits(bench.now, &[]), touch(bench.now, 1 << idx)]);
            assert!(matches!(leaves, Ok(Steering::Drive(_))), "{leaves:?}");
        }
    }
}

#[test]
fn touches_without_validity_and_without_a_path_change_nothing() {
    let mut bench = Bench::new(StopAndReplanParams::default());
    assert_eq!(bench.steer(&[touch(bench.now, 1)]), Ok(Steering::Drive(Twist::ZERO)));
    bench.follow(&[(0.0, 0.0), (4.0, 0.0)]);
    let broken = Observation { valid: false, ..touch(bench.now, 1) };
    assert!(matches!(bench.steer(&[hits(bench.now, &[]), broken]), Ok(Steering::Drive(_))));
}
