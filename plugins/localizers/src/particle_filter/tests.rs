//! The whole localizer against everything that a bad sensor, map or user may give it.

use super::measurement::{BeamModel, FieldModel, MeasurementModel, Obstacles};
use super::motion::{MotionModel, OdometryMotion, OmniMotion};
use super::particles::Particles;
use super::*;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::map::{Grid, Map};
use rumbo_core::messages::{
    Check, Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status, Wish,
};
use rumbo_core::registry::{Built, Params, Plugin, Registry, Stage};
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::GridSize;
use rumbo_kit::grid_poses::GridPoses;
use rumbo_kit::ray::{Ray, RayGrid};
use std::collections::BTreeMap;

const CELL_M: f64 = 0.1;
const SIZE: GridSize = GridSize::new(80, 60);

/// A room of 8 m by 6 m with a pillar that makes it lopsided.
fn room() -> Vec<u8> {
    let wall = |col: usize, row: usize| {
        let border = col == 0 || row == 0 || col == SIZE.width - 1 || row == SIZE.height - 1;
        border || (20..30).contains(&col) && (40..48).contains(&row) || col > 60 && row < 15
    };
    (0..SIZE.n_cells()).map(|i| u8::from(wall(SIZE.col_row(i).0, SIZE.col_row(i).1))).collect()
}

fn map_of(log_odds: impl Fn(u8) -> f32) -> Map {
    let unknown = Grid::unknown(SIZE.width as u32, SIZE.height as u32, CELL_M).unwrap();
    let cells: Vec<f32> = room().into_iter().map(log_odds).collect();
    Map {
        version: 1,
        grid: Some(Grid::new(*unknown.header(), Buffer::from(cells)).unwrap()),
        ..Map::default()
    }
}

fn map() -> Map {
    map_of(|cell| if cell == 1 { Grid::CERTAIN } else { -Grid::CERTAIN })
}

fn build(params: &ParticleFilterParams) -> Box<dyn Localizer> {
    assert!(params.check().is_empty(), "{:?}", params.check());
    params.build(&BuildContext { seed: 3, ..BuildContext::bare("localizer") }).unwrap()
}

/// At (4, 3) looking along +x, known to a few centimeters.
fn prior() -> Prior {
    let covariance = Matrix3::from_diagonal(&Vector3::new(0.0025, 0.0025, 0.0025));
    Prior::Pose { map_from_base: pose2(4.0, 3.0, 0.0), odom_from_base: Pose2::identity(), covariance }
}

fn started(params: &ParticleFilterParams) -> Box<dyn Localizer> {
    let mut localizer = build(params);
    localizer.start(&prior(), &map()).unwrap();
    localizer
}

fn observed(sensor: u16, seconds: f64, base_from_sensor: Pose3, data: Data) -> Observation {
    Observation {
        sensor: SensorId(sensor),
        stamp: Time::from_secs(seconds),
        base_from_sensor,
        valid: true,
        data,
    }
}

fn reading(seconds: f64, odom_from_base: Pose2) -> Observation {
    let odometry = Odometry { odom_from_base, ..Odometry::default() };
    observed(0, seconds, Pose3::identity(), Data::Odometry(odometry))
}

fn scan_with(ranges: Vec<f32>) -> LaserScan {
    LaserScan {
        first_bearing_rad: -2.0,
        bearing_step_rad: 4.0 / 80.0,
        max_range_m: 20.0,
        ranges_m: ranges.into(),
        ..LaserScan::default()
    }
}

/// What a sensor sees in the room.
fn scan(sensor: u16, seconds: f64, map_from_base: Pose2, mount: [f64; 3]) -> Observation {
    let rays = RayGrid::new(SIZE, &room());
    let map_from_sensor = map_from_base * pose2(mount[0], mount[1], mount[2]);
    let (place, yaw) = (map_from_sensor.translation.vector / CELL_M, map_from_sensor.rotation.angle());
    let range = |k: i32| {
        let ray = Ray::at_angle(place.x, place.y, yaw - 2.0 + 0.05 * f64::from(k));
        (rays.cast(&ray, 200.0) * CELL_M) as f32
    };
    let base_from_sensor = rumbo_core::frames::lift(&pose2(mount[0], mount[1], mount[2]));
    observed(sensor, seconds, base_from_sensor, Data::LaserScan(scan_with((0..81).map(range).collect())))
}

fn update(localizer: &mut dyn Localizer, seen: &[Observation]) -> Result<Estimate, LocalizeError> {
    Ok(watched(localizer, seen, &map())?.0)
}

fn watched(
    localizer: &mut dyn Localizer,
    seen: &[Observation],
    map: &Map,
) -> Result<(Estimate, BTreeMap<&'static str, f64>), LocalizeError> {
    let trace = Trace::watched();
    let now = seen.iter().map(|o| o.stamp).max().unwrap_or(Time::ZERO);
    let estimate = localizer.update(&mut Cx { now, trace: &trace }, Seen::sorted(seen), map)?;
    estimate.check().unwrap();
    let smallest = estimate.covariance2().symmetric_eigenvalues().min();
    assert!(smallest >= 1e-12, "the covariance is positive definite: {smallest}");
    Ok((estimate, trace.take().1.into_iter().collect()))
}

fn off_m(estimate: &Estimate, x_m: f64, y_m: f64) -> f64 {
    (estimate.pose2().translation.vector - nalgebra::Vector2::new(x_m, y_m)).norm()
}

#[test]
fn a_known_start_is_tracking_and_follows_the_odometer_between_updates() {
    let mut localizer = started(&ParticleFilterParams::default());
    let first = update(&mut *localizer, &[reading(1.0, Pose2::identity())]).unwrap();
    assert_eq!((first.status, first.wish), (Status::Tracking, None));
    assert!(off_m(&first, 4.0, 3.0) < 0.03);
    let next = update(&mut *localizer, &[reading(1.1, pose2(0.1, 0.0, 0.0))]).unwrap();
    let moved = first.pose2().inverse() * next.pose2();
    assert!((moved.translation.x - 0.1).abs() < 1e-9, "dead reckoning at every call");
    assert_eq!(next.stamp, Time::from_secs(1.1));
    assert!((next.map_from_odom.translation.vector - first.map_from_odom.translation.vector).norm() < 1e-9);
}

#[test]
fn sensors_with_mounts_and_stamps_of_their_own_are_weighed_together() {
    let params = ParticleFilterParams { least_explained: 0.9, ..ParticleFilterParams::default() };
    let mut localizer = started(&params);
    let truth = |seconds: f64| pose2(4.0 + 0.5 * seconds, 3.0, 0.0);
    let odom = |seconds: f64| pose2(0.5 * seconds, 0.0, 0.0);
    let mut counters = BTreeMap::new();
    let mut last = None;
    for k in 0..12 {
        let t = 0.2 * f64::from(k);
        // The rear laser looks backwards from behind, a moment before; odometry comes at other stamps, and late.
        let seen = [
            reading(t, odom(t)),
            scan(2, t + 0.05, truth(t + 0.05), [-0.3, 0.1, 3.0]),
            scan(1, t + 0.07, truth(t + 0.07), [0.25, 0.0, 0.1]),
        ];
        let (estimate, counted) = watched(&mut *localizer, &seen, &map()).unwrap();
        (last, counters) = (Some((t, estimate)), counted);
    }
    let (t, estimate) = last.unwrap();
    assert!(off_m(&estimate, 4.0 + 0.5 * t, 3.0) < 0.08, "{}", estimate.pose2());
    assert!(counters["share of beams explained"] > 0.95, "{counters:?}");
    assert_eq!((counters["scans dropped"], counters["odometry dropped"]), (0.0, 0.0));
    assert!(counters["updates"] >= 4.0);
}

#[test]
fn people_before_a_wall_do_not_pull_the_robot_toward_it() {
    // Somebody stands 1 m to the right and 2 m before the wall, and hides a fourth of what the laser sees.
    let crowded = |seconds: f64, at: Pose2| {
        let mut seen = scan(1, seconds, at, [0.0; 3]);
        if let Data::LaserScan(scan) = &mut seen.data {
            scan.ranges_m.make_mut().iter_mut().take(20).for_each(|range| *range = range.min(0.9));
        }
        seen
    };
    let worst_m = |unmapped_beyond_m: f64| {
        let mut localizer = started(&ParticleFilterParams { unmapped_beyond_m, ..Default::default() });
        let off = |k: u32| {
            let seconds = f64::from(k) * 0.5;
            let odom = pose2(0.0, 0.0, 0.25 * seconds);
            let at = pose2(4.0, 3.0, 0.25 * seconds);
            let seen = [reading(seconds, odom), crowded(seconds, at)];
            off_m(&update(&mut *localizer, &seen).unwrap(), 4.0, 3.0)
        };
        (0..40).map(off).fold(0.0, f64::max)
    };
    let (left_out, weighed) = (worst_m(0.2), worst_m(0.0));
    assert!(left_out < 0.12, "{left_out}");
    assert!(
        weighed > 2.0 * left_out,
        "{weighed} where people are weighed, {left_out} where they are left out"
    );
}

#[test]
fn scans_without_any_reading_only_move_the_particles() {
    for ranges in [vec![], vec![f32::NAN; 81], vec![f32::INFINITY; 81]] {
        let mut localizer = started(&ParticleFilterParams::default());
        let empty = |t| observed(1, t, Pose3::identity(), Data::LaserScan(scan_with(ranges.clone())));
        update(&mut *localizer, &[reading(0.0, Pose2::identity()), empty(0.0)]).unwrap();
        let seen = [reading(1.0, pose2(0.5, 0.0, 0.0)), empty(1.0)];
        let (estimate, counters) = watched(&mut *localizer, &seen, &map()).unwrap();
        assert!(off_m(&estimate, 4.5, 3.0) < 0.2, "{}", estimate.pose2());
        assert_eq!(counters["updates without beams"], 2.0);
        assert!(estimate.covariance2()[(0, 0)] > 0.01, "the motion spread them");
    }
}

#[test]
fn a_map_without_obstacles_says_nothing_and_one_without_free_cells_is_refused() {
    let empty = map_of(|_| -Grid::CERTAIN);
    let mut localizer = build(&ParticleFilterParams::default());
    localizer.start(&prior(), &empty).unwrap();
    let at = pose2(4.0, 3.0, 0.0);
    let seen = [reading(0.0, Pose2::identity()), scan(1, 0.0, at, [0.0; 3])];
    let (_, before) = watched(&mut *localizer, &seen, &empty).unwrap();
    let seen = [reading(1.0, pose2(0.3, 0.0, 0.0)), scan(1, 1.0, at, [0.0; 3])];
    let (_, after) = watched(&mut *localizer, &seen, &empty).unwrap();
    assert_eq!((after["updates without beams"], after["particles"]), (2.0, before["particles"]));
    for closed in [map_of(|_| Grid::CERTAIN), map_of(|_| 0.0)] {
        for start in [Prior::Unknown, prior()] {
            let error = build(&ParticleFilterParams::default()).start(&start, &closed).unwrap_err();
            assert!(error.to_string().contains("no free cell"), "{error}");
        }
    }
    let error = build(&ParticleFilterParams::default()).start(&prior(), &Map::default()).unwrap_err();
    assert_eq!(error, LocalizeError::MissingLayer { layer: "grid" });
}

#[test]
fn a_jump_of_the_odometer_scatters_the_particles_and_keeps_the_place() {
    let mut localizer = started(&ParticleFilterParams::default());
    let before = update(&mut *localizer, &[reading(1.0, Pose2::identity())]).unwrap();
    let seen = [reading(1.1, pose2(40.0, -7.0, 2.0))];
    let (after, counters) = watched(&mut *localizer, &seen, &map()).unwrap();
    assert_eq!(counters["odometry jumps"], 1.0);
    let largest_m = after.covariance2()[(0, 0)].max(after.covariance2()[(1, 1)]).sqrt();
    assert!(largest_m > 0.5 && after.status != Status::Tracking, "{largest_m}");
    assert!((after.pose2().translation.vector - before.pose2().translation.vector).norm() < 0.5);
    let moved =
        update(&mut *localizer, &[reading(1.2, pose2(40.0, -7.0, 2.0) * pose2(0.1, 0.0, 0.0))]).unwrap();
    let way = after.pose2().inverse() * moved.pose2();
    assert!((way.translation.vector - nalgebra::Vector2::new(0.1, 0.0)).norm() < 1e-9);
}

#[test]
fn an_odometer_that_first_speaks_elsewhere_is_taken_at_its_word() {
    let mut localizer = started(&ParticleFilterParams::default());
    let estimate = update(&mut *localizer, &[reading(1.0, pose2(-30.0, 5.0, 1.0))]).unwrap();
    assert!(off_m(&estimate, 4.0, 3.0) < 0.05 && estimate.status == Status::Tracking);
}

#[test]
fn readings_that_are_no_numbers_late_or_twice_are_dropped_and_counted() {
    let mut localizer = started(&ParticleFilterParams::default());
    let at = pose2(4.0, 3.0, 0.0);
    let seen = [reading(1.0, Pose2::identity()), scan(1, 1.0, at, [0.0; 3])];
    update(&mut *localizer, &seen).unwrap();
    let invalid = Observation { valid: false, ..reading(2.0, pose2(f64::NAN, 0.0, 0.0)) };
    let seen = [
        reading(0.5, Pose2::identity()),
        reading(1.0, pose2(0.4, 0.0, 0.0)),
        reading(1.5, pose2(f64::NAN, 0.0, 0.0)),
        scan(1, 0.9, at, [0.0; 3]),
        scan(1, 1.0, at, [0.0; 3]),
        invalid,
    ];
    let (estimate, counters) = watched(&mut *localizer, &seen, &map()).unwrap();
    assert_eq!((counters["odometry dropped"], counters["scans dropped"]), (3.0, 2.0));
    assert!(off_m(&estimate, 4.0, 3.0) < 0.05);
}

#[test]
fn a_long_silence_of_the_odometer_widens_the_belief() {
    let spread = |silence_s: f64| {
        let mut localizer = started(&ParticleFilterParams::default());
        let blind = |t| observed(1, t, Pose3::identity(), Data::LaserScan(scan_with(vec![f32::NAN; 81])));
        update(&mut *localizer, &[reading(0.0, Pose2::identity()), blind(0.0)]).unwrap();
        let seen = [reading(silence_s, Pose2::identity()), blind(silence_s)];
        update(&mut *localizer, &seen).unwrap().covariance2()[(0, 0)].sqrt()
    };
    assert!((spread(0.9) - 0.05).abs() < 0.01);
    assert!(spread(20.0) > 2.0 * spread(0.9), "{} for {}", spread(20.0), spread(0.9));
}

#[test]
fn priors_that_cannot_be_are_refused_and_nothing_works_before_a_start() {
    let mut localizer = build(&ParticleFilterParams::default());
    assert_eq!(update(&mut *localizer, &[]), Err(LocalizeError::NotStarted));
    let saved = Prior::Saved(Vec::new().into());
    assert!(matches!(localizer.start(&saved, &map()), Err(LocalizeError::Prior { .. })));
    let nan = Prior::Pose {
        map_from_base: pose2(f64::NAN, 0.0, 0.0),
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::identity(),
    };
    assert!(matches!(localizer.start(&nan, &map()), Err(LocalizeError::Message(_))));
    let indefinite = Prior::Pose {
        map_from_base: pose2(4.0, 3.0, 0.0),
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::from_diagonal(&Vector3::new(0.01, -0.01, 0.01)),
    };
    localizer.start(&indefinite, &map()).unwrap();
    assert!(off_m(&update(&mut *localizer, &[]).unwrap(), 4.0, 3.0) < 0.05);
}

#[test]
fn a_robot_that_may_be_anywhere_wishes_to_move_but_not_on_a_recording() {
    let recorded = Some(std::path::PathBuf::from("a.log"));
    for (recording, wish, expected) in [(None, true, true), (None, false, false), (recorded, true, false)] {
        let params = ParticleFilterParams { wish, ..ParticleFilterParams::default() };
        assert_eq!(params.manifest().wishes_motion, wish);
        let context = BuildContext { world_recording: recording, ..BuildContext::bare("localizer") };
        let mut localizer = params.build(&context).unwrap();
        localizer.start(&Prior::Unknown, &map()).unwrap();
        let estimate = update(&mut *localizer, &[reading(0.0, Pose2::identity())]).unwrap();
        assert_eq!(estimate.status, Status::Converging);
        assert_eq!(estimate.wish.is_some(), expected);
        if expected {
            assert!(matches!(estimate.wish, Some(Wish::TurnBy(_))), "nothing was seen ahead");
        }
    }
}

#[test]
fn the_fast_beam_model_is_the_formula_within_its_bins() {
    let model = BeamModel::default();
    let occupied = room();
    let obstacles = Obstacles { size: SIZE, resolution_m: CELL_M, occupied: &occupied };
    let at = pose2(4.0, 3.0, 0.4);
    let Data::LaserScan(seen) = scan(1, 0.0, at, [0.2, 0.0, 0.3]).data else { panic!("a scan") };
    let mount = rumbo_core::frames::lift(&pose2(0.2, 0.0, 0.3));
    let beams = beams::ScanBeams::of(&seen, &mount, 60);
    let mut fast = model.on_map(&obstacles);
    let mut poses = GridPoses::default();
    let places: Vec<[f64; 3]> = (0..50)
        .map(|k| f64::from(k) * 0.37)
        .map(|v| [40.0 + 20.0 * v.sin(), 30.0 + 9.0 * v.cos(), v])
        .collect();
    places.iter().for_each(|[x, y, heading]| poses.push(*x, *y, *heading));
    let mut ln_p = vec![0.0; 50];
    let n = fast.add_ln(&beams, &poses, &mut ln_p);
    assert_eq!(n, 60);
    for (found, place) in ln_p.iter().zip(places) {
        let exact = fast.exact_ln(&beams, place);
        // A bin is a quarter of a deviation; errors of beams cancel.
        assert!((found - exact).abs() < 0.15 * n as f64, "{place:?}: {found} for {exact}");
    }
    let truth = [40.0, 30.0, 0.4];
    assert_eq!(fast.explained(&beams, truth), [60, 60]);
    let field = FieldModel::default().on_map(&obstacles);
    assert_eq!(field.explained(&beams, truth)[0], 60);
    assert!(fast.explained(&beams, [20.0, 15.0, 2.0])[0] < 40);
}

#[test]
fn an_omnidirectional_robot_strays_along_and_across_its_way() {
    let model = OmniMotion { alpha: [0.0, 0.0, 0.04, 0.0, 0.01] };
    let mut particles = Particles::default();
    (0..40_000).for_each(|_| particles.push([1.0, 2.0, 0.5]));
    let mut rng = rumbo_core::rng::stream(4, "omni");
    let (before, after) = (pose2(0.0, 0.0, 1.0), pose2(0.0, 0.0, 1.0) * pose2(0.0, 2.0, 0.0));
    model.move_all(&before, &after, &mut particles, &mut rng);
    let start = pose2(1.0, 2.0, 0.5);
    let own: Vec<_> =
        particles.iter().map(|[x, y, _]| start.inverse() * nalgebra::Point2::new(x, y)).collect();
    let n = own.len() as f64;
    let mean = own.iter().map(|p| p.coords).sum::<nalgebra::Vector2<f64>>() / n;
    let deviation = |k: usize| (own.iter().map(|p| (p.coords[k] - mean[k]).powi(2)).sum::<f64>() / n).sqrt();
    assert!(mean.x.abs() < 0.01 && (mean.y - 2.0).abs() < 0.02, "sideways without turning: {mean}");
    assert!((deviation(0) - 0.2).abs() < 0.01 && (deviation(1) - 0.4).abs() < 0.01);
}

#[test]
fn the_registry_builds_it_and_every_bad_value_is_named() {
    let entry = Registry::linked().unwrap().get(Stage::Localizer, "particle_filter").unwrap().clone();
    let keys =
        "measurement = { model = 'beam' }\nmotion = { model = 'omni', alpha = [0.1, 0.1, 0.1, 0.1, 0.1] }";
    let configured = entry.source.parse(keys.parse().unwrap()).ok().unwrap();
    assert!(configured.check().is_empty());
    assert!(matches!(configured.build(&BuildContext::bare("localizer")), Ok(Built::Localizer(_))));
    let bad = ParticleFilterParams {
        min_particles: 0,
        max_particles: 0,
        max_beams: 0,
        kld_epsilon: 0.0,
        kld_delta: 1.0,
        resample_threshold: 1.5,
        alpha_slow: 0.5,
        alpha_fast: 0.5,
        motion: Box::new(OdometryMotion { alpha: [0.1, f64::NAN, 0.1, 0.1] }),
        measurement: Box::new(BeamModel { z_hit: 0.95, z_rand: 0.1, ..BeamModel::default() }),
        ..ParticleFilterParams::default()
    };
    let mut paths: Vec<String> = Params::check(&bad).into_iter().map(|fault| fault.path).collect();
    paths.sort();
    let expected = [
        "alpha_slow",
        "kld_delta",
        "kld_epsilon",
        "max_beams",
        "measurement.z_hit",
        "min_particles",
        "motion.alpha",
        "resample_threshold",
    ];
    assert_eq!(paths, expected);
    let off = ParticleFilterParams { alpha_slow: 0.0, alpha_fast: 0.0, ..ParticleFilterParams::default() };
    assert!(off.check().is_empty(), "both 0 turn the recovery off");
}

#[test]
fn shares_of_the_beam_model_that_do_not_sum_to_one_are_refused() {
    let sum_off_by = |by: f64| BeamModel { z_hit: 0.8 + by, ..BeamModel::default() }.faults();
    assert!(
        sum_off_by(0.9e-6).is_empty() && !sum_off_by(2e-6).is_empty() && !sum_off_by(f64::NAN).is_empty()
    );
    let message = &sum_off_by(0.15)[0].1;
    assert!(message.contains("is 1.150000, expected 1"), "{message}");
}

/// A measurement model of a third crate that says the same of every scan: one number for the first particle, another for
/// the rest.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
struct Fixed {
    first: f64,
    rest: f64,
}

#[typetag::serde(name = "fixed")]
impl MeasurementModel for Fixed {
    fn on_map(&self, _: &Obstacles<'_>) -> Box<dyn measurement::ScanLikelihood> {
        Box::new(self.clone())
    }
    fn faults(&self) -> Vec<(&'static str, String)> {
        Vec::new()
    }
    fn boxed_clone(&self) -> Box<dyn MeasurementModel> {
        Box::new(self.clone())
    }
}

impl measurement::ScanLikelihood for Fixed {
    fn add_ln(&mut self, _: &beams::ScanBeams, _: &GridPoses, ln_p: &mut [f64]) -> usize {
        ln_p.fill(self.rest);
        ln_p[0] = self.first;
        1
    }
    fn exact_ln(&self, _: &beams::ScanBeams, _: [f64; 3]) -> f64 {
        self.rest
    }
    fn explained(&self, _: &beams::ScanBeams, _: [f64; 3]) -> [usize; 2] {
        [1, 1]
    }
}

#[test]
fn lost_weights_are_counted_reset_and_followed_by_some_scattered_particles() {
    let at = pose2(4.0, 3.0, 0.0);
    let run = |first: f64, rest: f64| {
        let params =
            ParticleFilterParams { measurement: Box::new(Fixed { first, rest }), ..Default::default() };
        let mut localizer = started(&params);
        let seen = [reading(0.0, Pose2::identity()), scan(1, 0.0, at, [0.0; 3])];
        let (_, counters) = watched(&mut *localizer, &seen, &map()).unwrap();
        (counters["updates without weight"], counters["particles"])
    };
    let (n_fine, few) = run(-1.0, -1.0);
    assert_eq!(n_fine, 0.0);
    for bad in [f64::NAN, f64::NEG_INFINITY] {
        let (n_lost, many) = run(bad, bad);
        assert_eq!(n_lost, 1.0);
        assert!(many > 2.0 * few, "scattered particles fall into bins of their own: {many} for {few}");
        assert_eq!(run(bad, -1.0), (0.0, few), "one bad weight is that particle's affair");
    }
}

#[test]
fn an_older_scan_of_another_sensor_is_weighed_from_where_the_robot_was_then() {
    let field = FieldModel { sigma_hit_m: 0.05, ..FieldModel::default() };
    let params = ParticleFilterParams { measurement: Box::new(field), ..ParticleFilterParams::default() };
    let mut localizer = started(&params);
    let (rear, blind) = ([-0.3, 0.0, 3.0], |t| {
        observed(1, t, Pose3::identity(), Data::LaserScan(scan_with(vec![f32::NAN; 81])))
    });
    let truth = |seconds: f64| pose2(4.0 + 0.19 * seconds, 3.0, 0.0);
    let odom = |seconds: f64| pose2(0.19 * seconds, 0.0, 0.0);
    let seen = [reading(0.0, odom(0.0)), scan(2, 0.0, truth(0.0), rear)];
    update(&mut *localizer, &seen).unwrap();
    // The rear scan comes too soon for an update of its own; the front laser sees nothing when the robot has moved on.
    let seen = [reading(1.0, odom(1.0)), scan(2, 1.0, truth(1.0), rear), reading(2.0, odom(2.0)), blind(2.0)];
    let (estimate, counters) = watched(&mut *localizer, &seen, &map()).unwrap();
    assert_eq!(counters["updates"], 2.0);
    assert!(counters["share of beams explained"] > 0.9, "{counters:?}");
    assert!(off_m(&estimate, 4.38, 3.0) < 0.12, "{}", estimate.pose2());
}
