//! The plugin as a pipeline sees it.

use super::super::params::TriangulationParams;
use super::drive::{Hardship, scan};
use super::place::Office;
use crate::landmark_noise::LandmarkNoiseParams;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2};
use rumbo_core::map::{Grid, GridHeader, Map};
use rumbo_core::messages::{
    Check, Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status,
};
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::rng::stream;
use rumbo_core::stages::{BuildContext, Cx, LocalizeError, Localizer};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;

fn built(params: &TriangulationParams, seed: u64) -> Box<dyn Localizer> {
    let context = BuildContext { seed, ..BuildContext::bare("localizer") };
    params.build(&context).unwrap()
}

fn map_of(grid: Grid) -> Map {
    Map { version: 1, grid: Some(grid), ..Map::default() }
}

fn start_at(pose: Pose2) -> Prior {
    Prior::Pose {
        map_from_base: pose,
        odom_from_base: Pose2::identity(),
        covariance: Matrix3::from_diagonal(&nalgebra::Vector3::new(1e-4, 1e-4, 1e-5)),
    }
}

fn observed(sensor: u16, time_s: f64, data: Data) -> Observation {
    let stamp = Time::from_secs(time_s);
    Observation { sensor: SensorId(sensor), stamp, base_from_sensor: Pose3::identity(), valid: true, data }
}

fn odometry(odom_from_base: Pose2) -> Data {
    Data::Odometry(Odometry { odom_from_base, twist: Twist::ZERO, noise: [0.03, 0.03, 0.05] })
}

fn laser(ranges_m: Vec<f32>) -> Data {
    Data::LaserScan(LaserScan {
        first_bearing_rad: -std::f64::consts::FRAC_PI_2,
        bearing_step_rad: 0.5_f64.to_radians(),
        min_range_m: 0.05,
        max_range_m: 8.0,
        ranges_m: ranges_m.into(),
        ..LaserScan::default()
    })
}

fn update(
    localizer: &mut dyn Localizer,
    trace: &Trace,
    time_s: f64,
    seen: &[Observation],
    map: &Map,
) -> Result<Estimate, LocalizeError> {
    localizer.update(&mut Cx { now: Time::from_secs(time_s), trace }, Seen::sorted(seen), map)
}

const PLACE: [f64; 3] = [2.0, 1.5, 0.3];

/// Estimates on a way of a meter in the smallest office.
fn follow(localizer: &mut dyn Localizer, trace: &Trace, map: &Map) -> Vec<Estimate> {
    let (office, mut rng) = (Office::exact("5x5"), stream(4, "beams"));
    let step = |k: usize| {
        let way = pose2(0.05 * k as f64, 0.0, 0.0);
        let pose = pose2(PLACE[0], PLACE[1], PLACE[2]) * way;
        let time_s = 0.5 * k as f64;
        let ranges = scan(&office, &pose, (time_s, &Hardship::default()), 0.015, &mut rng);
        let seen = [observed(0, time_s, odometry(way)), observed(1, time_s, laser(ranges))];
        update(localizer, trace, time_s, &seen, map).unwrap()
    };
    (0..20).map(step).collect()
}

#[test]
fn it_cannot_search_and_says_so_until_it_is_told_where_the_robot_is() {
    let map = map_of(Office::exact("5x5").grid);
    let mut localizer = built(&TriangulationParams::default(), 1);
    let trace = Trace::unwatched();
    let unasked = update(localizer.as_mut(), &trace, 0.0, &[], &map);
    assert_eq!(unasked, Err(LocalizeError::NotStarted));
    localizer.start(&Prior::Unknown, &map).unwrap();
    let lost = follow(localizer.as_mut(), &trace, &map);
    assert!(lost.iter().all(|estimate| estimate.status == Status::Lost && estimate.check().is_ok()));
    let saved = Prior::Saved(vec![1_u8, 2].into());
    assert!(matches!(localizer.start(&saved, &map), Err(LocalizeError::Prior { .. })));
    localizer.start(&start_at(pose2(PLACE[0], PLACE[1], PLACE[2])), &map).unwrap();
    let found = follow(localizer.as_mut(), &trace, &map);
    assert!(found.iter().all(|estimate| estimate.status == Status::Tracking));
}

#[test]
fn counters_show_landmarks_relations_estimates_and_starved_scans() {
    let map = map_of(Office::exact("5x5").grid);
    let mut localizer = built(&TriangulationParams::default(), 1);
    localizer.start(&start_at(pose2(PLACE[0], PLACE[1], PLACE[2])), &map).unwrap();
    let trace = Trace::watched();
    let mut last = |time_s: f64, way_m: f64, ranges: Vec<f32>| {
        let seen =
            [observed(0, time_s, odometry(pose2(way_m, 0.0, 0.0))), observed(1, time_s, laser(ranges))];
        update(localizer.as_mut(), &trace, time_s, &seen, &map).unwrap();
        let (_, counters) = trace.take();
        ["landmarks", "relations", "estimates", "starved"]
            .map(|name| counters.iter().rev().find(|(n, _)| *n == name).unwrap().1)
    };
    let (office, quiet) = (Office::exact("5x5"), Hardship { has_walker: false, ..Hardship::default() });
    let at = |way_m: f64| pose2(PLACE[0], PLACE[1], PLACE[2]) * pose2(way_m, 0.0, 0.0);
    let seen = |way_m: f64| scan(&office, &at(way_m), (0.0, &quiet), 0.0, &mut stream(1, "beams"));
    let [landmarks, relations, estimates, starved] = last(1.0, 0.1, seen(0.1));
    assert!(landmarks >= relations && relations >= 4.0 && estimates >= 2.0 && starved == 0.0);
    assert_eq!(last(2.0, 0.2, vec![f32::NAN; 361]), [0.0, 0.0, 0.0, 1.0]);
    assert_eq!(last(3.0, 0.3, vec![f32::INFINITY; 361])[3], 2.0);
    let [_, relations, _, starved] = last(4.0, 0.4, seen(0.4));
    assert!(relations >= 4.0 && starved == 2.0, "starved scans add up");
}

#[test]
fn noise_on_landmarks_comes_from_the_seed_and_only_if_it_is_asked_for() {
    let map = map_of(Office::exact("5x5").grid);
    let run = |params: &TriangulationParams, seed: u64| {
        let mut localizer = built(params, seed);
        let mut once = || {
            localizer.start(&start_at(pose2(PLACE[0], PLACE[1], PLACE[2])), &map).unwrap();
            follow(localizer.as_mut(), &Trace::unwatched(), &map)
        };
        let first = once();
        assert_eq!(first, once(), "the same after a new start");
        first
    };
    let calm = TriangulationParams::default();
    let noise = Some(LandmarkNoiseParams::default());
    let noisy = TriangulationParams { landmark_noise: noise, ..calm.clone() };
    assert_eq!(run(&calm, 1), run(&calm, 2), "no chance plays a part");
    assert_eq!(run(&noisy, 1), run(&noisy, 1));
    assert_ne!(run(&noisy, 1), run(&noisy, 2));
    assert_ne!(run(&noisy, 1), run(&calm, 1));
}

#[test]
fn scans_of_nothing_and_maps_of_one_cell_are_survived() {
    let one_cell = |value: f32| {
        let header = GridHeader {
            width: 1,
            height: 1,
            resolution_m: 0.05,
            origin: [0.0; 3],
            occupied_above: Grid::OCCUPIED_ABOVE,
            free_below: Grid::FREE_BELOW,
        };
        Grid::new(header, vec![value].into()).unwrap()
    };
    let maps = [one_cell(-Grid::CERTAIN), one_cell(Grid::CERTAIN), one_cell(0.0), Office::exact("5x5").grid];
    let scans = [
        vec![],
        vec![f32::NAN; 361],
        vec![f32::INFINITY; 361],
        vec![0.0; 361],
        vec![-1.0; 361],
        vec![f32::NAN, 1.0, f32::NAN],
        (0..361).map(|k| if k % 2 == 0 { f32::NAN } else { 1.0 + 0.01 * k as f32 }).collect(),
    ];
    for thesis_mode in [false, true] {
        for map in &maps {
            for start in [pose2(0.02, 0.02, 0.0), pose2(-50.0, 1e6, 3.0)] {
                let params = TriangulationParams { thesis_mode, ..TriangulationParams::default() };
                let mut localizer = built(&params, 1);
                let map = map_of(map.clone());
                localizer.start(&start_at(start), &map).unwrap();
                for (k, ranges) in scans.iter().cycle().take(3 * scans.len()).enumerate() {
                    let time_s = 5.0 * k as f64;
                    let seen = [
                        observed(0, time_s, odometry(pose2(0.1 * k as f64, 0.0, 0.0))),
                        observed(1, time_s, laser(ranges.clone())),
                    ];
                    let trace = Trace::unwatched();
                    let estimate = update(localizer.as_mut(), &trace, time_s, &seen, &map).unwrap();
                    estimate.check().unwrap();
                    let off = estimate.pose2().translation.vector - start.translation.vector;
                    assert!((off.norm() - 0.1 * k as f64).abs() < 1e-6, "the odometry stands: {off}");
                }
            }
        }
    }
}

#[test]
fn parameters_that_cannot_be_are_all_told() {
    assert!(TriangulationParams::default().check().is_empty());
    let bad = TriangulationParams {
        period_s: -1.0,
        search_m: 0.0,
        map_deviation_m: -0.1,
        least_sine: 1.0,
        least_explained: f64::NAN,
        landmark_noise: Some(LandmarkNoiseParams { share: 1.2, distance_m: -1.0, bearing_deg: f64::NAN }),
        ..TriangulationParams::default()
    };
    let faults: Vec<String> = bad.check().into_iter().map(|fault| fault.path).collect();
    for key in [
        "period_s",
        "search_m",
        "map_deviation_m",
        "least_sine",
        "least_explained",
        "landmark_noise.share",
        "landmark_noise.distance_m",
        "landmark_noise.bearing_deg",
    ] {
        assert!(faults.iter().any(|fault| fault == key), "{key}: {faults:?}");
    }
    assert_eq!(faults.len(), 8, "{faults:?}");
    // A map of exact walls is allowed: its cells are taken into account anyhow.
    let exact = TriangulationParams { map_deviation_m: 0.0, ..TriangulationParams::default() };
    assert!(exact.check().is_empty());
}
