//! What a scan tells by its own shape, against places of which that is known.

use super::*;
use crate::GridSize;
use crate::scan_odometry::tests::{Wall, corridor, seen};
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::Pose3;
use rumbo_core::messages::LaserScan;
use rumbo_core::rng;

const RANGES_M: [f64; 2] = [0.1, 40.0];

fn shape(scan: &LaserScan) -> Option<Observability> {
    shape_of(scan, &Pose3::identity(), RANGES_M)?.blind()
}

/// Of twenty scans from here, so many do not tell all directions.
fn n_blind(walls: &[Wall], at: &Pose2, n_beams: usize, noise_m: f64) -> usize {
    let is_blind =
        |seed: &u64| shape(&seen(walls, at, n_beams, noise_m, &mut rng::stream(*seed, "shapes"))).is_some();
    (0..20).filter(is_blind).count()
}

/// With a face across it of this width, at its left wall.
fn with_jamb(depth_m: f64) -> Vec<Wall> {
    let mut walls = corridor();
    walls.push([[4.0, 1.2 - depth_m], [4.0, 1.2]]);
    walls
}

#[test]
fn a_corridor_without_ends_does_not_tell_the_way_along_it_whatever_the_noise_and_the_heading() {
    for (n_beams, noise_m) in [(181, 0.0), (361, 0.005), (361, 0.03), (1081, 0.01), (1081, 0.03)] {
        for (seed, yaw_rad) in [0.0, 0.3, -0.8, 1.4, 3.0].into_iter().enumerate() {
            let mut rng = rng::stream(seed as u64, "shapes");
            let scan = seen(&corridor(), &pose2(3.0, 0.2, yaw_rad), n_beams, noise_m, &mut rng);
            let shape = shape(&scan).unwrap_or_else(|| panic!("{n_beams} {noise_m} {yaw_rad}"));
            assert_eq!(shape.seen, [false, true, true], "{n_beams} {noise_m} {yaw_rad}: {shape:?}");
            // Seen from the base, the corridor lies the other way round.
            let blind = shape.directions.column(0);
            let along = blind[0] * yaw_rad.cos() - blind[1] * yaw_rad.sin();
            assert!(along.abs() > 0.999, "{n_beams} {noise_m} {yaw_rad}: {blind}");
        }
    }
}

#[test]
fn what_lies_across_a_corridor_tells_the_way() {
    let at = pose2(0.0, 0.1, 0.2);
    let mut ended = corridor();
    ended.push([[9.0, -1.2], [9.0, 1.2]]);
    for noise_m in [0.005, 0.01, 0.03] {
        assert_eq!(n_blind(&ended, &at, 361, noise_m), 0, "an end, {noise_m}");
        assert_eq!(n_blind(&with_jamb(0.5), &at, 361, noise_m), 0, "a cupboard, {noise_m}");
        assert_eq!(n_blind(&corridor(), &at, 361, noise_m), 20, "bare, {noise_m}");
    }
    // Some points on it are enough, and what is no deeper than the noise tells nothing.
    assert_eq!(n_blind(&with_jamb(0.3), &at, 361, 0.005), 0);
    assert_eq!(n_blind(&with_jamb(0.01), &at, 361, 0.03), 20);
}

/// What a depth camera of 57 degrees sees from here: up to 8 m, with noise of 1.5 mm at a meter that grows with the square.
fn seen_by_camera(walls: &[Wall], at: &Pose2, seed: u64) -> LaserScan {
    let mut rng = rng::stream(seed, "shapes");
    let all = seen(walls, at, 505, 0.0, &mut rng);
    let in_view = 173..333;
    let first_bearing_rad = all.bearing_rad(in_view.start);
    let read = |range_m: &f32| {
        let noise: f32 = StandardNormal.sample(&mut rng);
        let reading_m = range_m + 0.0015 * range_m.powi(2) * noise;
        if reading_m < 8.0 { reading_m } else { f32::INFINITY }
    };
    let ranges_m: Vec<f32> = all.ranges_m[in_view].iter().map(read).collect();
    LaserScan { first_bearing_rad, max_range_m: 8.0, ranges_m: ranges_m.into(), ..all }
}

#[test]
fn a_camera_whose_noise_grows_does_not_see_the_way_along_a_corridor_either() {
    let mut ended = corridor();
    ended.push([[5.0, -1.2], [5.0, 1.2]]);
    for yaw_rad in [0.0, 0.2, -0.4] {
        let at = pose2(0.0, 0.2, yaw_rad);
        let n_blind = |walls: &[Wall]| {
            (0..20).filter(|seed| shape(&seen_by_camera(walls, &at, *seed)).is_some()).count()
        };
        assert!(n_blind(&corridor()) >= 14, "{yaw_rad}: {}", n_blind(&corridor()));
        assert_eq!(n_blind(&ended), 0, "{yaw_rad}");
    }
}

#[test]
fn the_end_of_a_wall_tells_the_way_and_the_end_of_the_range_does_not() {
    let at = pose2(0.0, 0.0, 0.0);
    let wall = |ends_at: f64| vec![[[-200.0, 1.5], [ends_at, 1.5]]];
    assert_eq!(n_blind(&wall(200.0), &at, 361, 0.01), 20);
    assert_eq!(n_blind(&wall(4.0), &at, 361, 0.01), 0, "nothing behind");
    let mut before_another = wall(4.0);
    before_another.push([[-200.0, 4.0], [200.0, 4.0]]);
    assert_eq!(n_blind(&before_another, &at, 361, 0.01), 0, "a wall behind");
}

#[test]
fn a_beam_that_is_lost_now_and_then_ends_no_wall() {
    let mut scan = seen(&corridor(), &pose2(0.0, 0.2, 0.1), 361, 0.01, &mut rng::stream(1, "shapes"));
    for (idx, range_m) in scan.ranges_m.make_mut().iter_mut().enumerate() {
        if idx % 11 == 3 || idx % 37 == 5 {
            *range_m = f32::NAN;
        }
    }
    assert_eq!(shape(&scan).unwrap().seen, [false, true, true]);
}

#[test]
fn where_grazing_beams_do_not_come_back_no_wall_ends() {
    for (reach_m, nothing) in [(8.0, f32::NAN), (12.0, f32::INFINITY), (12.0, 0.0)] {
        let mut scan = seen(&corridor(), &pose2(0.0, 0.2, 0.1), 361, 0.01, &mut rng::stream(1, "shapes"));
        let far = scan.ranges_m.make_mut().iter_mut().filter(|range_m| **range_m > reach_m);
        far.for_each(|range_m| *range_m = nothing);
        assert_eq!(shape(&scan).unwrap().seen, [false, true, true], "{reach_m} {nothing}");
    }
}

#[test]
fn around_the_middle_of_a_round_room_the_turn_is_not_told() {
    let at = |k: f64| [5.0 * k.to_radians().cos(), 5.0 * k.to_radians().sin()];
    let walls: Vec<Wall> = (0..360).map(|k| [at(f64::from(k)), at(f64::from(k + 1))]).collect();
    for noise_m in [0.0, 0.01, 0.03] {
        let scan = seen(&walls, &pose2(0.6, -0.4, 0.5), 1081, noise_m, &mut rng::stream(3, "shapes"));
        let shape = shape(&scan).unwrap();
        assert_eq!(shape.seen, [false, true, true], "{noise_m}: {shape:?}");
        // A turn around the middle of the room keeps it in its place: the way of the base for a turn of one radian.
        let blind = shape.directions.column(0);
        let turn = blind[2] / shape.extent_m;
        let base_from_middle = pose2(0.6, -0.4, 0.5).inverse().translation.vector;
        let way = [blind[0] / turn, blind[1] / turn];
        assert!((way[0] - base_from_middle.y).abs() < 0.1, "{noise_m}: {way:?} {base_from_middle}");
        assert!((way[1] + base_from_middle.x).abs() < 0.1, "{noise_m}: {way:?} {base_from_middle}");
    }
}

#[test]
fn scans_without_lines_or_points_tell_all_that_they_tell() {
    assert_eq!(shape(&LaserScan::default()), None);
    let open = LaserScan {
        ranges_m: vec![f32::INFINITY; 361].into(),
        ..seen(&[], &pose2(0.0, 0.0, 0.0), 361, 0.0, &mut rng::stream(0, "shapes"))
    };
    assert_eq!(shape(&open), None);
    let mut few = open.clone();
    few.ranges_m.make_mut()[100..103].fill(2.0);
    assert_eq!(shape(&few), None);
}

/// Two meters of a wall are known, or four, and it ends after three.
#[test]
fn the_end_of_a_wall_tells_the_way_where_one_is_drawn() {
    let wall = |ends_at: f64| Scene::drawn(vec![[-8.0, 1.5, ends_at, 1.5]], 0.05);
    let at = pose2(0.0, 0.0, 0.0);
    let scan = seen(&[[[-200.0, 1.5], [3.0, 1.5]]], &at, 361, 0.01, &mut rng::stream(6, "shapes"));
    let told = shape_of(&scan, &Pose3::identity(), RANGES_M).unwrap();
    assert_eq!(told.blind(), None, "by itself it tells all");
    for (drawn_to_m, is_told) in [(2.0, false), (3.0, true), (4.0, false)] {
        let drawn = wall(drawn_to_m);
        let blind = told.blind_where(drawn_near(&[drawn.level()], &at, 0.1));
        assert_eq!(blind.is_none(), is_told, "{drawn_to_m}: {blind:?}");
    }
}

/// Somebody stands in the corridor, where nothing is drawn: only of what is drawn the scan tells where it is.
#[test]
fn what_is_seen_for_the_first_time_tells_no_way() {
    let bare = Scene::corridor(0.05);
    let mut walls: Vec<Wall> = bare.walls.iter().map(|[ax, ay, bx, by]| [[*ax, *ay], [*bx, *by]]).collect();
    walls.extend([[[3.0, -0.3], [3.4, -0.3]], [[3.0, -0.3], [3.0, 0.2]], [[3.0, 0.2], [3.4, 0.2]]]);
    let at = pose2(0.0, 0.0, 0.1);
    let scan = seen(&walls, &at, 361, 0.01, &mut rng::stream(4, "shapes"));
    assert_eq!(shape(&scan), None, "by itself it tells all");
    let told = shape_of(&scan, &Pose3::identity(), RANGES_M).unwrap();
    let levels = [bare.level()];
    for blind in
        [told.blind_where(drawn_near(&levels, &at, 0.15)), told.blind_where(drawn_along(&levels, &at, 0.15))]
    {
        let blind = blind.unwrap();
        assert_eq!(blind.seen, [false, true, true], "{blind:?}");
        assert!((blind.directions.column(0)[0]).abs() > 0.99, "{blind:?}");
    }
    let no_cells = GridLevel::new(&[], GridSize::new(0, 0), 0.05, pose2(0.0, 0.0, 0.0)).unwrap();
    assert_eq!(told.blind_where(drawn_near(&[no_cells], &at, 0.15)), None);
    assert_eq!(told.blind_where(drawn_near::<GridLevel<'_>>(&[], &at, 0.15)), None);
    // Where nothing is drawn nobody can say what is new.
    assert_eq!(told.blind_where(|_| false), None);
}

#[test]
fn a_match_in_a_bare_corridor_keeps_the_priors_way_along_it() {
    let at = pose2(0.0, 0.2, 0.0);
    let scan = seen(&corridor(), &at, 361, 0.01, &mut rng::stream(2, "shapes"));
    let mut scene = Scene::corridor(0.05);
    ScanPreparation { min_range_m: 0.1, ..ScanPreparation::default() }.prepare(
        &scan,
        &Pose3::identity(),
        &mut scene.points,
    );
    assert!(scene.points.blind().is_some());
    let start = pose2(0.07, 0.12, 0.02);
    for rule in [CovarianceRule::Curvature, CovarianceRule::Sampled] {
        let covariance = CovarianceSettings { rule, ..CovarianceSettings::default() };
        let settings = MatchSettings { covariance, ..MatchSettings::default() };
        let found = match_scan(&[scene.level()], &scene.points, &start, None, &settings).unwrap();
        assert_eq!(found.seen.seen, [false, true, true]);
        assert!((found.map_from_base.translation.x - 0.07).abs() < 1e-3, "{}", found.map_from_base);
        let [along_m, across_m] = [0, 1].map(|axis| found.covariance[(axis, axis)].sqrt());
        assert!(along_m > 0.9 && across_m < 0.1, "{rule:?}: {along_m} m along, {across_m} m across");
    }
}

/// Walls on all sides of a sensor that is not at the robot's middle.
#[test]
fn normals_are_toward_the_sensor() {
    let scan = seen(&corridor(), &pose2(0.0, 0.2, 0.3), 361, 0.01, &mut rng::stream(9, "shapes"));
    let mount = Pose3::translation(0.3, -0.4, 0.0);
    let shape = shape_of(&scan, &mount, RANGES_M).unwrap();
    let normals = || shape.points().iter().filter_map(|point| Some((point.at, point.normal?)));
    assert!(normals().count() > 200, "{}", normals().count());
    for ([x, y], [nx, ny]) in normals() {
        assert!((0.3 - x) * nx + (-0.4 - y) * ny > 0.0, "{x} {y}: {nx} {ny}");
    }
}

#[test]
fn a_room_proves_a_place_and_few_points_of_it_do_not() {
    let room: Vec<Wall> = vec![
        [[-9.0, -2.0], [9.0, -2.0]],
        [[9.0, -2.0], [9.0, 2.0]],
        [[9.0, 2.0], [-9.0, 2.0]],
        [[-9.0, 2.0], [-9.0, -2.0]],
    ];
    let scan = seen(&room, &pose2(5.0, 0.0, 0.0), 361, 0.01, &mut rng::stream(7, "shapes"));
    let shape = shape_of(&scan, &Pose3::identity(), RANGES_M).unwrap();
    assert!(shape.blind().is_none());
    assert!(shape.proves_where(|_| true), "all is known");
    let far_wall = |point: &ShapePoint| point.at[0] > 3.8;
    let n_far = shape.points().iter().filter(|point| far_wall(point)).count();
    assert!(n_far > 40, "{n_far}");
    assert!(!shape.proves_where(|point| !far_wall(point) && !point.is_end), "the side walls alone");
    let n_seen = std::cell::Cell::new(0);
    let is_few = |_: &ShapePoint| n_seen.replace(n_seen.get() + 1) < 6;
    assert!(!shape.proves_where(is_few), "six points");
    assert!(!shape.proves_where(|_| false), "none");
}

#[test]
fn new_ends_of_walls_tell_no_way_however_many_they_are() {
    let wall = |from_m: f64, to_m: f64, y_m: f64| [[from_m, y_m], [to_m, y_m]];
    let mut walls = vec![wall(-200.0, 200.0, 9.0), wall(-200.0, 200.0, -9.0)];
    for y_m in [-1.2, 1.2] {
        let mut from_m = -200.0;
        for door_m in [-6.0, -3.5, -1.0, 1.5, 4.0] {
            walls.push(wall(from_m, door_m, y_m));
            from_m = door_m + 0.9;
        }
        walls.push(wall(from_m, 200.0, y_m));
    }
    let scan = seen(&walls, &pose2(0.0, 0.0, 0.0), 1081, 0.005, &mut rng::stream(8, "shapes"));
    let shape = shape_of(&scan, &Pose3::identity(), RANGES_M).unwrap();
    let n_ends = shape.points().iter().filter(|point| point.is_end).count();
    assert!(n_ends >= 8, "{n_ends}");
    assert_eq!(shape.blind(), None, "by itself it tells all");
    let blind = shape.blind_where(|point| !point.is_end);
    assert_eq!(blind.map(|blind| blind.seen), Some([false, true, true]));
}
