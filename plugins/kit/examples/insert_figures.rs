//! The figures of `docs/benchmarks.md` for scans into grids: processor time of each way to insert a scan, least and
//! median of several passes over all scans.
//!
//! `cargo run --release -p rumbo-kit --example insert_figures [SCANS.scn]`. The file holds scans with the poses that
//! they were taken from: `SCN1`, number of scans and of beams (u32), first bearing, step and reach (f32), then for each
//! scan two poses (three f64 each, true and odometry) and its ranges (f32). Without it scans are cast in a generated
//! building.
#![allow(clippy::print_stdout)]

use rumbo_core::frames::{Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_kit::GridSize;
use rumbo_kit::generated_world::GeneratedWorld;
use rumbo_kit::occupancy::{BeamEnds, BeamLimits, Evidence, FreeSpace, Mount2, ScanPainter};
use rumbo_kit::ray::RayGrid;
use rustix::time::{ClockId, clock_gettime};
use std::error::Error;

const RESOLUTION_M: f64 = 0.05;
const SIZE: GridSize = GridSize::new(1000, 1000);
const REACH_M: f32 = 20.0;

struct Taken {
    pose: [f64; 3],
    scan: LaserScan,
}

fn cpu_s() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

fn scan(first_bearing_rad: f64, bearing_step_rad: f64, ranges: Vec<f32>) -> LaserScan {
    let ranges: Vec<f32> =
        ranges.into_iter().map(|range| if range < REACH_M { range } else { f32::INFINITY }).collect();
    LaserScan {
        first_bearing_rad,
        bearing_step_rad,
        max_range_m: REACH_M,
        ranges_m: ranges.into(),
        ..LaserScan::default()
    }
}

fn read(path: &str) -> Result<Vec<Taken>, Box<dyn Error>> {
    let bytes = std::fs::read(path)?;
    let u32_at = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    let f32_at = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(f32::from_le_bytes);
    let f64_at = |at: usize| bytes.get(at..at + 8)?.try_into().ok().map(f64::from_le_bytes);
    let header = || Some((u32_at(4)? as usize, u32_at(8)? as usize, f32_at(12)?, f32_at(16)?));
    let (n_scans, n_beams, first, step) = header().ok_or("the header is incomplete")?;
    let one = |k: usize| {
        let at = 24 + k * (48 + 4 * n_beams);
        let ranges: Option<Vec<f32>> = (0..n_beams).map(|beam| f32_at(at + 48 + 4 * beam)).collect();
        let pose = [f64_at(at)?, f64_at(at + 8)?, f64_at(at + 16)?];
        Some(Taken { pose, scan: scan(first.into(), step.into(), ranges?) })
    };
    (0..n_scans).map(|k| one(k).ok_or_else(|| "a scan is incomplete".into())).collect()
}

fn generate() -> Vec<Taken> {
    let world = GeneratedWorld::indoor(1000, 4242);
    let grid = RayGrid::new(world.size, &world.occupied);
    let step_rad = std::f64::consts::PI / 360.0;
    let cells = (0..world.size.n_cells()).step_by(613).filter(|cell| world.occupied[*cell] == 0).take(1000);
    cells
        .enumerate()
        .map(|(k, cell)| {
            let (col, row) = world.size.col_row(cell);
            let (x, y, yaw) = (col as f64 + 0.5, row as f64 + 0.5, k as f64 * 0.7);
            let bearings =
                (0..361).map(|beam| yaw - std::f64::consts::FRAC_PI_2 + f64::from(beam) * step_rad);
            let directions: Vec<[f64; 2]> = bearings.map(|b| [b.cos(), b.sin()]).collect();
            let mut cells = vec![0.0; directions.len()];
            grid.cast_fan([x, y], 0.0, &directions, f64::from(REACH_M) / RESOLUTION_M, &mut cells);
            let ranges = cells.iter().map(|cells| (cells * RESOLUTION_M) as f32).collect();
            Taken {
                pose: [x * RESOLUTION_M, y * RESOLUTION_M, yaw],
                scan: scan(-std::f64::consts::FRAC_PI_2, step_rad, ranges),
            }
        })
        .collect()
}

fn report(what: &str, taken: &[Taken], free_space: FreeSpace, levels: u32) -> Result<(), Box<dyn Error>> {
    let evidence = Evidence::new(0.4, 0.9, 0.01, 0.99).map_err(|_| "impossible evidence")?;
    let limits = BeamLimits { min_range_m: 0.0, max_range_m: REACH_M.into(), clear_range_m: REACH_M.into() };
    let (mut painter, mut beams) = (ScanPainter::default(), BeamEnds::default());
    let mut seconds: Vec<f64> = Vec::new();
    let mut n_changed = 0;
    for _ in 0..9 {
        let mut grids: Vec<(GridSize, Vec<f32>)> = (0..levels)
            .map(|k| GridSize::new(SIZE.width >> k, SIZE.height >> k))
            .map(|size| (size, vec![0.0; size.n_cells()]))
            .collect();
        let begin = cpu_s();
        for Taken { pose: [x, y, yaw], scan } in taken {
            let mount = Mount2::new(&pose2(*x, *y, *yaw), &Pose3::identity(), RESOLUTION_M);
            beams.place(scan, &mount, &limits);
            for (k, (size, cells)) in grids.iter_mut().enumerate() {
                painter.paint(cells, *size, &beams, 0.5f32.powi(k as i32), free_space, &evidence);
            }
        }
        seconds.push(cpu_s() - begin);
        n_changed = grids[0].1.iter().filter(|cell| **cell != 0.0).count();
    }
    seconds.sort_by(f64::total_cmp);
    let rate = |seconds: f64| taken.len() as f64 / seconds;
    println!(
        "{what:44} least {:8.0} scans/s  median {:8.0} scans/s  ({n_changed} cells known)",
        rate(seconds[0]),
        rate(seconds[seconds.len() / 2])
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let taken = match std::env::args().nth(1) {
        Some(path) => read(&path)?,
        None => generate(),
    };
    let area = FreeSpace::Area { widest_wedge_rad: 0.0192 };
    report("swept area, each cell once a scan", &taken, area, 1)?;
    report("swept area, four levels", &taken, area, 4)?;
    report("beams as lines, each cell once a scan", &taken, FreeSpace::Beams, 1)
}
