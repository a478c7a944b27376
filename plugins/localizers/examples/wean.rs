//! Global localization on the logs of Wean Hall: the robot may be anywhere at the start; is it found at the end?
//!
//! `cargo run --release -p rumbo-localizers --example wean -- FOLDER [first_seed [last_seed [params]]]`, where `params`
//! is TOML such as `max_particles = 30000`. The folder holds `wean.yaml`, `robotdata1.log.gz` and
//! `robotdata1-reference.txt`, and so on to 3. Success is an end within 1.0 m and 10 degrees of the reference's end.
#![allow(clippy::print_stdout, clippy::expect_used, clippy::panic)]

use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, Pose3, Twist, pose2};
use rumbo_core::map::{Grid, GridHeader, Map};
use rumbo_core::messages::{Data, Estimate, LaserScan, Observation, Odometry, Prior, Seen, SensorId, Status};
use rumbo_core::registry::{Params, Plugin};
use rumbo_core::stages::{BuildContext, Cx};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, load_map};
use rumbo_localizers::particle_filter::ParticleFilterParams;
use std::io::Read;
use std::path::Path;

/// The building is large, and neighboring offices look alike: many guesses, and trust in each beam so small that the
/// furniture, which the map does not show, does not decide between offices.
const PARAMS: &str =
    "max_particles = 100000\nlikelihood_exponent = 0.05\nleast_effective_share = 0.1\nslip_share = 0.02";

fn main() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments.next().expect("name the folder of the logs");
    let folder = Path::new(&folder);
    let mut number = |default: u64| arguments.next().map_or(default, |word| word.parse().expect("a number"));
    let (first, last) = (number(1), number(10));
    let text = arguments.next().unwrap_or_else(|| PARAMS.to_owned());
    let params: ParticleFilterParams = toml::from_str(&text).expect("parameters of the particle filter");
    assert!(params.check().is_empty(), "{:?}", params.check());
    let map = map(&folder.join("wean.yaml"));
    println!("{text}");
    let mut missed = Vec::new();
    for (log, least_share) in LEAST_FOUND {
        let observations = observations(&folder.join(format!("robotdata{log}.log.gz")));
        let reference = reference(&folder.join(format!("robotdata{log}-reference.txt")));
        let runs: Vec<Run> =
            (first..=last).map(|seed| run(&params, seed, &map, &observations, &reference)).collect();
        for (seed, run) in (first..).zip(&runs) {
            println!("log {log} seed {seed:3}: {run}");
        }
        let n = runs.iter().filter(|run| run.is_success()).count();
        println!("log {log}: {n} of {} found", runs.len());
        if (n as f64) < least_share * runs.len() as f64 {
            missed.push(format!("log {log}"));
        }
    }
    if missed.is_empty() { Ok(()) } else { Err(format!("too few found: {}", missed.join(", "))) }
}

/// Share of the seeds that must find the robot, for each log; the second is the hard one.
const LEAST_FOUND: [(u32, f64); 3] = [(1, 1.0), (2, 0.8), (3, 1.0)];

/// How a run ended.
struct Run {
    end_error_m: f64,
    end_error_deg: f64,
    status: Status,
    /// Time of the first tracking, whether that was the true place, and how often tracking was false.
    first_tracking_s: Option<f64>,
    false_share: f64,
    n_lost: u32,
}

impl Run {
    fn is_success(&self) -> bool {
        self.end_error_m <= 1.0 && self.end_error_deg <= 10.0
    }
}

impl std::fmt::Display for Run {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let word = if self.is_success() { "found" } else { "MISSED" };
        let Run { end_error_m, end_error_deg, status, false_share, n_lost, .. } = self;
        write!(f, "{word:6} {end_error_m:7.2} m {end_error_deg:6.1} deg at the end, {status:?}; ")?;
        match self.first_tracking_s {
            Some(s) => write!(f, "tracking from {s:.0} s, {:.1} % of it false; ", 100.0 * false_share)?,
            None => write!(f, "never tracking; ")?,
        }
        write!(f, "{n_lost} estimates lost")
    }
}

fn run(
    params: &ParticleFilterParams,
    seed: u64,
    map: &Map,
    log: &[Observation],
    reference: &[(f64, Pose2)],
) -> Run {
    let context =
        BuildContext { seed, world_recording: Some("log".into()), ..BuildContext::bare("localizer") };
    let mut localizer = params.build(&context).expect("the parameters were checked");
    localizer.start(&Prior::Unknown, map).expect("the map has free cells");
    let trace = Trace::unwatched();
    let mut last: Option<Estimate> = None;
    let (mut first_tracking_s, mut n_tracking, mut n_false, mut n_lost) = (None, 0, 0, 0);
    for observation in log {
        let mut cx = Cx { now: observation.stamp, trace: &trace };
        let estimate = localizer
            .update(&mut cx, Seen::sorted(std::slice::from_ref(observation)), map)
            .expect("a log without surprises");
        let now_s = observation.stamp.as_secs();
        n_lost += u32::from(estimate.status == Status::Lost);
        if estimate.status == Status::Tracking {
            first_tracking_s.get_or_insert(now_s);
            n_tracking += 1;
            n_false += u32::from(far(&estimate.pose2(), reference, now_s).0 > 1.0);
        }
        last = Some(estimate);
    }
    let last = last.expect("the log is not empty");
    let (end_error_m, end_error_deg) = far(&last.pose2(), reference, f64::INFINITY);
    let false_share = f64::from(n_false) / f64::from(n_tracking.max(1));
    Run { end_error_m, end_error_deg, status: last.status, first_tracking_s, false_share, n_lost }
}

/// Meters and degrees from the reference at a time.
fn far(map_from_base: &Pose2, reference: &[(f64, Pose2)], at_s: f64) -> (f64, f64) {
    let after = reference.partition_point(|(t, _)| *t <= at_s).clamp(1, reference.len() - 1);
    let ((t0, a), (t1, b)) = (&reference[after - 1], &reference[after]);
    let part = ((at_s - t0) / (t1 - t0)).clamp(0.0, 1.0);
    let expected = Pose2::from_parts(
        a.translation.vector.lerp(&b.translation.vector, part).into(),
        a.rotation.slerp(&b.rotation, part),
    );
    let off = expected.inverse() * map_from_base;
    (off.translation.vector.norm(), off.rotation.angle().abs().to_degrees())
}

fn map(yaml: &Path) -> Map {
    let image = load_map(yaml, DEFAULT_MAX_CELLS).expect("the map");
    let header = GridHeader {
        width: image.width as u32,
        height: image.height as u32,
        resolution_m: image.resolution_m,
        origin: image.origin,
        occupied_above: Grid::OCCUPIED_ABOVE,
        free_below: Grid::FREE_BELOW,
    };
    let log_odds = |percent: &i8| match percent {
        100 => Grid::CERTAIN,
        0 => -Grid::CERTAIN,
        -1 => 0.0,
        percent => {
            let p = f32::from(*percent) / 100.0;
            (p / (1.0 - p)).ln()
        }
    };
    let cells: Vec<f32> = image.cells.iter().map(log_odds).collect();
    Map { version: 1, grid: Grid::new(header, Buffer::from(cells)).ok(), ..Map::default() }
}

fn observations(path: &Path) -> Vec<Observation> {
    let mut text = String::new();
    let file = std::fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("a gzip file");
    let mut observations = Vec::new();
    for line in text.lines() {
        let (kind, rest) = line.split_at(1);
        let numbers: Vec<f64> = rest.split_whitespace().map(|word| word.parse().expect("a number")).collect();
        let (stamp, odom_from_base) = (
            Time::from_secs(numbers[numbers.len() - 1]),
            pose2(numbers[0] / 100.0, numbers[1] / 100.0, numbers[2]),
        );
        let observation = |sensor, x_m, data| Observation {
            sensor: SensorId(sensor),
            stamp,
            base_from_sensor: Pose3::translation(x_m, 0.0, 0.0),
            valid: true,
            data,
        };
        let odometry = Odometry { odom_from_base, twist: Twist::ZERO, noise: [0.0; 3] };
        observations.push(observation(0, 0.0, Data::Odometry(odometry)));
        if kind == "L" {
            let ranges: Vec<f32> =
                numbers[6..numbers.len() - 1].iter().map(|cm| *cm as f32 / 100.0).collect();
            let scan = LaserScan {
                first_bearing_rad: -std::f64::consts::FRAC_PI_2,
                bearing_step_rad: 1f64.to_radians(),
                min_range_m: 0.05,
                max_range_m: 80.0,
                ranges_m: ranges.into(),
                ..LaserScan::default()
            };
            observations.push(observation(1, 0.25, Data::LaserScan(scan)));
        }
    }
    observations
}

fn reference(path: &Path) -> Vec<(f64, Pose2)> {
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    let numbers =
        lines.map(|line| line.split_whitespace().map(|word| word.parse().expect("a number")).collect());
    numbers.map(|n: Vec<f64>| (n[0], pose2(n[1], n[2], n[3]))).collect()
}
