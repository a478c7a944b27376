//! The figures of `docs/benchmarks.md` for the registration of scans: processor time and error of each scan of a drive
//! against the one before it, from where the odometer says.
//!
//! `cargo run --release -p rumbo-kit --example scan_odometry_figures SCANS.scn`. The file holds scans with the poses that they
//! were taken from: `SCN1`, number of scans and of beams (u32), first bearing, step and reach (f32), then for each scan two
//! poses (three f64 each, true and odometry) and its ranges (f32).
#![allow(clippy::print_stdout)]

use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, Pose3, pose2};
use rumbo_core::messages::LaserScan;
use rumbo_kit::scan_odometry::{KeyScan, LineKind, PosePrior, Registrar, ScanOdometrySettings, ScanPoints};
use rustix::time::{ClockId, clock_gettime};
use std::error::Error;

struct Taken {
    map_from_base: Pose2,
    odom_from_base: Pose2,
    scan: LaserScan,
}

fn cpu_s() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9
}

fn read(path: &str) -> Result<Vec<Taken>, Box<dyn Error>> {
    let bytes = std::fs::read(path)?;
    let u32_at = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(u32::from_le_bytes);
    let f32_at = |at: usize| bytes.get(at..at + 4)?.try_into().ok().map(f32::from_le_bytes);
    let f64_at = |at: usize| bytes.get(at..at + 8)?.try_into().ok().map(f64::from_le_bytes);
    let header = || Some((u32_at(4)? as usize, u32_at(8)? as usize, f32_at(12)?, f32_at(16)?, f32_at(20)?));
    let (n_scans, n_beams, first, step, reach) = header().ok_or("the header is incomplete")?;
    let one = |k: usize| {
        let at = 24 + k * (48 + 4 * n_beams);
        let pose = |at: usize| Some(pose2(f64_at(at)?, f64_at(at + 8)?, f64_at(at + 16)?));
        let ranges: Option<Vec<f32>> = (0..n_beams).map(|beam| f32_at(at + 48 + 4 * beam)).collect();
        // A beam that meets nothing has the reach itself.
        let ranges: Vec<f32> =
            ranges?.into_iter().map(|range| if range < reach { range } else { f32::INFINITY }).collect();
        let scan = LaserScan {
            first_bearing_rad: first.into(),
            bearing_step_rad: step.into(),
            max_range_m: reach,
            ranges_m: ranges.into(),
            ..LaserScan::default()
        };
        Some(Taken { map_from_base: pose(at)?, odom_from_base: pose(at + 24)?, scan })
    };
    (0..n_scans).map(|k| one(k).ok_or_else(|| "a scan is incomplete".into())).collect()
}

/// Microseconds a pair, and the errors of the place in millimeters, least first.
fn run(drive: &[Taken], settings: &ScanOdometrySettings) -> (f64, Vec<f64>) {
    let (mut points, mut key, mut registrar) =
        (ScanPoints::default(), KeyScan::default(), Registrar::default());
    let mut errors_mm = Vec::with_capacity(drive.len());
    let begin = cpu_s();
    for (before, now) in drive.iter().zip(drive.iter().skip(1)) {
        points.place(&before.scan, &Pose3::identity());
        key.take(&points, settings);
        points.place(&now.scan, &Pose3::identity());
        let key_from_base = before.odom_from_base.inverse() * now.odom_from_base;
        let prior = PosePrior { key_from_base, covariance: Matrix3::identity() * 1e-4 };
        let matched = registrar.register(&key, &points, &prior, settings);
        let truth = before.map_from_base.inverse() * now.map_from_base;
        errors_mm.push(1e3 * (matched.key_from_base.translation.vector - truth.translation.vector).norm());
    }
    let spent_us = 1e6 * (cpu_s() - begin) / errors_mm.len().max(1) as f64;
    errors_mm.sort_by(f64::total_cmp);
    (spent_us, errors_mm)
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("name a file of scans")?;
    let drive = read(&path)?;
    for (name, lines) in [("fitted lines", LineKind::Fitted), ("lines through neighbors", LineKind::Neighbor)]
    {
        let settings = ScanOdometrySettings { lines, ..ScanOdometrySettings::default() };
        let runs: Vec<(f64, Vec<f64>)> = (0..7).map(|_| run(&drive, &settings)).collect();
        let least_us = runs.iter().map(|run| run.0).fold(f64::INFINITY, f64::min);
        let errors_mm = runs.first().map(|run| run.1.as_slice()).unwrap_or_default();
        let share =
            |share: f64| errors_mm.get((share * errors_mm.len() as f64) as usize).copied().unwrap_or(0.0);
        println!(
            "{name}: {least_us:.1} us a pair, {} pairs; median {:.2} mm, 90 % {:.2} mm, 99 % {:.1} mm",
            errors_mm.len(),
            share(0.5),
            share(0.9),
            share(0.99)
        );
    }
    Ok(())
}
