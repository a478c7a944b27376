//! A forklift that cannot turn on the spot, as it may be left standing: 100 random places and headings in the warehouse, its
//! hull 0.3 to 1.0 m from a wall or a rack, each with a random goal.
//!
//! `cargo run --release --example forklift_starts [-- N_STARTS]` drives each with both planners, and fails unless 95 of
//! 100 arrive with each, and none touches anything.
#![allow(clippy::print_stdout)]

use rumbo_core::engine::{Engine, Metrics, Summary};
use rumbo_core::frames::{Point2, Pose2, pose2};
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::Registry;
use rumbo_core::rng::{Rng, RngExt, stream};
use std::error::Error;
use std::f64::consts::PI;
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

const PIPELINE: &str = "pipelines/forklift_warehouse.toml";
/// The hall and its racks, as `pipelines/worlds/fc_warehouse.toml` has them: from and to, meters.
const HALL_M: [f64; 2] = [40.0, 30.0];
const RACKS_M: [[f64; 4]; 10] = [
    [16.0, 16.0, 24.0, 17.0],
    [16.0, 20.0, 24.0, 21.0],
    [4.0, 8.0, 10.0, 9.0],
    [4.0, 13.0, 10.0, 14.0],
    [4.0, 18.0, 10.0, 19.0],
    [4.0, 23.0, 10.0, 24.0],
    [30.0, 8.0, 36.0, 9.0],
    [30.0, 13.0, 36.0, 14.0],
    [30.0, 18.0, 36.0, 19.0],
    [30.0, 23.0, 36.0, 24.0],
];
/// The forklift's hull: from and to, meters.
const HULL_M: [[f64; 2]; 2] = [[-1.6, -0.5], [1.2, 0.5]];
/// The hull is so far from everything at the start, the base at least as far as the planner's paths, meters.
const HULL_CLEARANCE_M: [f64; 2] = [0.3, 1.0];
const BASE_CLEARANCE_M: f64 = 0.85;
/// Goals are this far from everything, and so far from the start, meters.
const GOAL_CLEARANCE_M: f64 = 1.8;
const WAY_M: [f64; 2] = [4.0, 30.0];

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let n: u64 = std::env::args().nth(1).map_or(Ok(100), |text| text.parse())?;
    let registry = rumbo::registry()?;
    let mut is_good = true;
    for planner in ["dp", "fictitious_charges"] {
        let (mut n_arrived, mut n_touching) = (0, 0);
        for seed in 1..=n {
            let (start, goal) = ends(&mut stream(seed, "forklift_starts"));
            let summary = drive(planner, &start, goal, seed, &registry)?;
            n_arrived += u64::from(summary.arrived);
            n_touching += u64::from(summary.contacts != Some(0));
            if !summary.arrived || summary.contacts != Some(0) {
                let detail = summary.detail.unwrap_or_default();
                println!("{planner} seed {seed}: {start} to {goal}: {}, {detail}", summary.reason);
            }
        }
        println!("{planner}: {n_arrived} of {n} arrived, {n_touching} touched something");
        is_good &= 100 * n_arrived >= 95 * n && n_touching == 0;
    }
    Ok(if is_good { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// A start and a goal.
fn ends(rng: &mut Rng) -> (Pose2, Point2) {
    let mut place = || Point2::new(rng.random_range(0.0..HALL_M[0]), rng.random_range(0.0..HALL_M[1]));
    loop {
        let (at, goal, turned) = (place(), place(), place());
        let start = pose2(at.x, at.y, PI * (2.0 * turned.x / HALL_M[0] - 1.0));
        let hull_m = hull_clearance_m(&start);
        let may_stand = (HULL_CLEARANCE_M[0]..HULL_CLEARANCE_M[1]).contains(&hull_m);
        let may_drive = clearance_m(at) >= BASE_CLEARANCE_M && clearance_m(goal) >= GOAL_CLEARANCE_M;
        if may_stand && may_drive && (WAY_M[0]..WAY_M[1]).contains(&(goal - at).norm()) {
            return (start, goal);
        }
    }
}

/// Distance to the nearest wall or rack; zero inside of a rack, meters.
fn clearance_m(at: Point2) -> f64 {
    let to_walls = at.x.min(at.y).min(HALL_M[0] - at.x).min(HALL_M[1] - at.y);
    let to_rack = |[x0, y0, x1, y1]: [f64; 4]| {
        (x0 - at.x).max(at.x - x1).max(0.0).hypot((y0 - at.y).max(at.y - y1).max(0.0))
    };
    RACKS_M.into_iter().map(to_rack).fold(to_walls, f64::min)
}

/// The least clearance of points around the hull, meters.
fn hull_clearance_m(pose: &Pose2) -> f64 {
    let [low, high] = HULL_M;
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]]].map(Point2::from);
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let points = sides.flat_map(|(a, b)| (0..28).map(move |k| a + (b - a) * (f64::from(k) / 28.0)));
    points.map(|point| clearance_m(pose * point)).fold(f64::INFINITY, f64::min)
}

fn drive(
    planner: &str,
    start: &Pose2,
    goal: Point2,
    seed: u64,
    registry: &Registry,
) -> Result<Summary, Box<dyn Error>> {
    let (x, y, yaw_deg) = (start.translation.x, start.translation.y, start.rotation.angle().to_degrees());
    let sets = [
        format!("seed={seed}"),
        format!("planner.plugin={planner}"),
        format!("world.start={{ x_m = {x}, y_m = {y}, yaw_deg = {yaw_deg} }}"),
        format!("mission.waypoints=[{{ x_m = {}, y_m = {} }}]", goal.x, goal.y),
    ];
    let loaded = Loaded::read(Path::new(PIPELINE), &sets, registry);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    let mut metrics = Metrics::new();
    let end = Engine::build(pipeline)?.run(&mut [&mut metrics], &AtomicBool::new(false));
    Ok(metrics.summary(end.reason, end.detail))
}
