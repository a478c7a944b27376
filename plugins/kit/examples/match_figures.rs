//! The figures of `docs/benchmarks.md` for scan matching: error, and processor time of one match, on the work that other
//! libraries are timed on.
//!
//! `cargo run --release -p rumbo-kit --example match_figures SCANS.scn`. The file holds scans with the poses that they were
//! taken from: `SCN1`, number of scans and of beams (u32), first bearing, step and reach (f32), then for each scan two poses
//! (three f64 each, true and odometry) and its ranges (f32).
#![allow(clippy::print_stdout)]

use rumbo_core::frames::{Point2, Pose2, Pose3, pose2};
use rumbo_core::map::Map;
use rumbo_core::messages::LaserScan;
use rumbo_kit::occupancy::{BeamLimits, Evidence, FreeSpace, MapperSettings, Pyramid, ScanMapper};
use rumbo_kit::scan_match::{
    MatchSettings, PolishSettings, ScanPoints, ScanPreparation, SurfaceMap, levels_of, levels_within,
    match_scan,
};
use rustix::time::{ClockId, clock_gettime};
use std::error::Error;

const CELL_M: f64 = 0.05;

struct Taken {
    truth: Pose2,
    odom: Pose2,
    scan: LaserScan,
    points: ScanPoints,
}

fn cpu_s() -> f64 {
    let now = clock_gettime(ClockId::ThreadCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

fn read(path: &str) -> Result<Vec<Taken>, Box<dyn Error>> {
    let bytes = std::fs::read(path)?;
    let u32_at = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    let f32_at = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(f32::from_le_bytes);
    let f64_at = |at: usize| bytes.get(at..at + 8)?.try_into().ok().map(f64::from_le_bytes);
    let header = || Some((u32_at(4)? as usize, u32_at(8)? as usize, f32_at(12)?, f32_at(16)?, f32_at(20)?));
    let (n_scans, n_beams, first, step, reach_m) = header().ok_or("the header is incomplete")?;
    let one = |k: usize| {
        let at = 24 + k * (48 + 4 * n_beams);
        let pose = |at: usize| Some(pose2(f64_at(at)?, f64_at(at + 8)?, f64_at(at + 16)?));
        let ranges: Option<Vec<f32>> = (0..n_beams).map(|beam| f32_at(at + 48 + 4 * beam)).collect();
        let ranges: Vec<f32> =
            ranges?.into_iter().map(|range| if range < reach_m { range } else { f32::INFINITY }).collect();
        let scan = LaserScan {
            first_bearing_rad: first.into(),
            bearing_step_rad: step.into(),
            max_range_m: reach_m,
            ranges_m: ranges.into(),
            ..LaserScan::default()
        };
        let mut points = ScanPoints::default();
        let preparation = ScanPreparation { min_range_m: 0.1, ..ScanPreparation::default() };
        preparation.prepare(&scan, &Pose3::identity(), &mut points);
        Some(Taken { truth: pose(at)?, odom: pose(at + 24)?, scan, points })
    };
    (0..n_scans).map(|k| one(k).ok_or_else(|| "a scan is incomplete".into())).collect()
}

struct Mapped {
    map: Map,
    surfaces: SurfaceMap,
    mapper: ScanMapper,
}

impl Mapped {
    fn new(size: u32, around: Point2, free: f64) -> Result<Mapped, Box<dyn Error>> {
        let evidence = Evidence::new(free, 0.9, 0.01, 0.99).map_err(|_| "impossible evidence")?;
        let pyramid = Pyramid { resolution_m: CELL_M, levels: 5, block_cells: 256, max_cells: 100_000_000 };
        let mapper = ScanMapper::new(MapperSettings {
            evidence,
            pyramid,
            limits: BeamLimits { min_range_m: 0.1, max_range_m: 30.0, clear_range_m: 0.0 },
            free_space: FreeSpace::Area { widest_wedge_rad: 0.02 },
            auto_grow: true,
        });
        let mut map = Map::default();
        pyramid.lay(&mut map, size, around, [0.5; 2])?;
        let level_from_map = map.grid.as_ref().ok_or("no grid")?.grid_from_map();
        Ok(Mapped { map, surfaces: SurfaceMap::new(CELL_M, level_from_map), mapper })
    }

    fn insert(&mut self, taken: &Taken, pose: &Pose2) -> Result<(), Box<dyn Error>> {
        self.mapper.insert(&taken.scan, pose, &Pose3::identity(), &mut self.map)?;
        self.surfaces.insert(&taken.points, pose);
        Ok(())
    }
}

#[derive(Default)]
struct Figures {
    errors_m: Vec<f64>,
    errors_rad: Vec<f64>,
    seconds: Vec<f64>,
    n_evaluations: u32,
}

impl Figures {
    /// Matches once to look and a few times for the clock.
    fn run(
        &mut self,
        on: &Mapped,
        points: &ScanPoints,
        start: &Pose2,
        truth: &Pose2,
        reach_m: f64,
        polished: bool,
    ) {
        let settings = MatchSettings {
            finest_converge_cells: if polished { 0.1 } else { 0.0 },
            ..MatchSettings::quick()
        };
        let polish = PolishSettings::default();
        let mut best_s = f64::INFINITY;
        let mut last = None;
        for _ in 0..3 {
            let begin = cpu_s();
            let levels = levels_of(&on.map);
            let mut found = match_scan(levels_within(&levels, reach_m), points, start, None, &settings);
            if let Some(found) = found.as_mut().filter(|_| polished) {
                polish.polish(found, &on.surfaces, points, None, &settings.covariance);
            }
            best_s = best_s.min(cpu_s() - begin);
            last = found;
        }
        if let Some(found) = last {
            let error = truth.inverse() * found.map_from_base;
            self.errors_m.push(error.translation.vector.norm());
            self.errors_rad.push(error.rotation.angle().abs());
            self.seconds.push(best_s);
            self.n_evaluations += found.n_evaluations;
        }
    }

    fn print(mut self, what: &str) {
        let at = |values: &mut Vec<f64>, share: f64| {
            values.sort_by(f64::total_cmp);
            values.get((values.len() as f64 * share) as usize).copied().unwrap_or(f64::NAN)
        };
        let n = self.seconds.len();
        let [e50, e90, e99] = [0.5, 0.9, 0.99].map(|share| 1e3 * at(&mut self.errors_m, share));
        let r50 = 1e3 * at(&mut self.errors_rad, 0.5);
        let [s0, s50, s99] = [0.0, 0.5, 0.99].map(|share| 1e6 * at(&mut self.seconds, share));
        let looks = f64::from(self.n_evaluations) / n as f64;
        println!(
            "{what:44} error median {e50:6.2} mm {r50:5.2} mrad, p90 {e90:6.2} mm, p99 {e99:6.1} mm; least {s0:6.1} us, median {s50:6.1} us, p99 {s99:6.1} us; {looks:.1} looks, {n} matches"
        );
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let taken = read(&std::env::args().nth(1).ok_or("the first argument names a file of scans")?)?;
    for polished in [false, true] {
        let name = if polished { "polished" } else { "cells alone" };
        // Two scans half a meter apart, from the odometer and 5.8 cm and 1.7 degrees beside it.
        let mut pairs = Figures::default();
        for (k, now) in taken.iter().enumerate().take(505).skip(5) {
            let before = &taken[k - 5];
            let mut on = Mapped::new(512, Point2::origin(), 0.4)?;
            on.insert(before, &Pose2::identity())?;
            let start = before.odom.inverse() * now.odom * pose2(0.05, -0.03, 0.03);
            let truth = before.truth.inverse() * now.truth;
            pairs.run(&on, &now.points, &start, &truth, 0.3, polished);
        }
        pairs.print(&format!("two scans, {name}"));
        let mut on = Mapped::new(1024, Point2::new(25.0, 25.0), 0.45)?;
        for taken in taken.iter().step_by(2) {
            on.insert(taken, &taken.truth)?;
        }
        for (what, away, reach_m) in [
            ("from far off", pose2(0.08, -0.06, 0.05), f64::INFINITY),
            ("from far off, known", pose2(0.08, -0.06, 0.05), 0.3),
            ("tracking", pose2(0.01, -0.01, 0.003), 0.05),
        ] {
            let mut figures = Figures::default();
            for now in taken.iter().skip(1).step_by(4) {
                figures.run(&on, &now.points, &(now.truth * away), &now.truth, reach_m, polished);
            }
            figures.print(&format!("map of 500 scans, {what}, {name}"));
        }
    }
    Ok(())
}
