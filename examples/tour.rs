//! A tour of a building: goals spread over all its rooms, each reached from the one before.
//!
//! `cargo run --release --example tour -- MAP.yaml [N_GOALS] [SEED]` takes any ROS map_server map, draws the goals as
//! far from each other as can be in the free space that is connected, drives to each, and fails unless all are reached
//! without contact.
#![allow(clippy::print_stdout)]

use rumbo_core::engine::{Engine, Metrics, Summary};
use rumbo_core::pipeline::Loaded;
use rumbo_core::registry::Registry;
use rumbo_kit::distance_field::squared_distance_field;
use rumbo_kit::map_file::{DEFAULT_MAX_CELLS, MapImage, load_map};
use rumbo_kit::{GridSize, NEIGHBORS_8};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

/// Goals keep this distance from everything, meters: more than the planner's preferred clearance.
const CLEARANCE_M: f64 = 0.5;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let map = PathBuf::from(arguments.next().ok_or("name a map: tour MAP.yaml [N_GOALS] [SEED]")?)
        .canonicalize()?;
    let n_goals: usize = arguments.next().map_or(Ok(20), |text| text.parse())?;
    let seed: u64 = arguments.next().map_or(Ok(1), |text| text.parse())?;
    let image = load_map(&map, DEFAULT_MAX_CELLS)?;
    let stops = spread(&image, n_goals + 1)?;
    let registry = rumbo::registry()?;
    println!(
        "{:>4}  {:>16}  {:>11}  {:>8}  {:>8}  {:>9}",
        "goal", "at (m)", "end", "way (m)", "time (s)", "least (m)"
    );
    let mut n_good = 0;
    for (leg, ends) in stops.windows(2).enumerate() {
        let summary = drive(&map, ends[0], ends[1], seed + leg as u64, &registry)?;
        n_good += usize::from(summary.arrived && summary.contacts == Some(0));
        println!(
            "{:>4}  ({:>6.2}, {:>6.2})  {:>11}  {:>8.2}  {:>8.1}  {:>9.3}  {}",
            leg + 1,
            ends[1].0,
            ends[1].1,
            summary.reason.to_string(),
            summary.path_m,
            summary.time_s,
            summary.min_clearance_m.unwrap_or(f64::NAN),
            summary.detail.unwrap_or_default()
        );
    }
    println!("{n_good} of {n_goals} goals reached without contact");
    Ok(if n_good == n_goals { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// One leg with the robot and the stages of the office pipeline.
fn drive(
    map: &Path,
    from: (f64, f64),
    to: (f64, f64),
    seed: u64,
    registry: &Registry,
) -> Result<Summary, Box<dyn Error>> {
    let sets = [
        format!("seed={seed}"),
        format!("world.map={:?}", map.display().to_string()),
        format!("world.start={{ x_m = {}, y_m = {}, yaw_deg = 0.0 }}", from.0, from.1),
        format!("mission.waypoints=[{{ x_m = {}, y_m = {} }}]", to.0, to.1),
    ];
    let loaded = Loaded::read(Path::new("pipelines/office.toml"), &sets, registry);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    let mut metrics = Metrics::new();
    let end = Engine::build(pipeline)?.run(&mut [&mut metrics], &AtomicBool::new(false));
    Ok(metrics.summary(end.reason, end.detail))
}

/// Places of the largest connected free space, each as far as possible from those before it.
fn spread(image: &MapImage, n: usize) -> Result<Vec<(f64, f64)>, Box<dyn Error>> {
    let size = GridSize::new(image.width, image.height);
    let free: Vec<bool> = image.cells.iter().map(|percent| (0..=50).contains(percent)).collect();
    let marked: Vec<u8> = free.iter().map(|free| u8::from(!free)).collect();
    let keep = (CLEARANCE_M / image.resolution_m).powi(2);
    let open: Vec<bool> =
        squared_distance_field(size, &marked).iter().map(|d| f64::from(*d) >= keep).collect();
    let room = largest_room(size, &open);
    let mut stops = vec![*room.first().ok_or("the map has no free space for the robot")?];
    let mut nearest = vec![f64::INFINITY; room.len()];
    while stops.len() < n {
        let last = size.col_row(stops[stops.len() - 1]);
        for (cell, nearest) in room.iter().zip(&mut nearest) {
            let (col, row) = size.col_row(*cell);
            let far = (col as f64 - last.0 as f64).hypot(row as f64 - last.1 as f64);
            *nearest = nearest.min(far);
        }
        let farthest = (0..room.len()).max_by(|a, b| nearest[*a].total_cmp(&nearest[*b]));
        stops.push(room[farthest.ok_or("no room")?]);
    }
    let place = |cell: usize| {
        let (col, row) = size.col_row(cell);
        let meters = |count: usize| (count as f64 + 0.5) * image.resolution_m;
        (image.origin[0] + meters(col), image.origin[1] + meters(row))
    };
    Ok(stops.into_iter().map(place).collect())
}

/// Cells of the largest connected part.
fn largest_room(size: GridSize, open: &[bool]) -> Vec<usize> {
    let mut seen = vec![false; open.len()];
    let mut largest = Vec::new();
    for seed in 0..open.len() {
        if seen[seed] || !open[seed] {
            continue;
        }
        seen[seed] = true;
        let mut room = vec![seed];
        let mut next = 0;
        while let Some(&cell) = room.get(next) {
            next += 1;
            for (dx, dy) in NEIGHBORS_8 {
                if let Some(near) = size.neighbor(cell, dx, dy).filter(|near| open[*near] && !seen[*near]) {
                    seen[near] = true;
                    room.push(near);
                }
            }
        }
        if room.len() > largest.len() {
            largest = room;
        }
    }
    largest
}
