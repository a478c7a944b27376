//! What is in robot logs: `scan_counts FILE_OR_FOLDER...` prints a table of scans, beams, odometry lines, duration,
//! backward steps and faults of every log, and how fast it was read.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rumbo_core::time::Time;
use rumbo_kit::log_file::{BeamOverride, LogError, LogReader, Timeline, Told};

fn main() {
    let mut logs = Vec::new();
    for argument in std::env::args_os().skip(1) {
        collect(Path::new(&argument), &mut logs);
    }
    println!(
        "{:<40} {:>7} {:>6} {:>7} {:>9} {:>10} {:>6} {:>8} {:>9} {:>7}",
        "log", "scans", "beams", "odom", "seconds", "back (las)", "(odom)", "in order", "faults", "MB/s"
    );
    for log in logs {
        if let Err(error) = row(&log) {
            eprintln!("{error}");
        }
    }
}

/// Every file below a folder whose name is that of a log.
fn collect(path: &Path, logs: &mut Vec<PathBuf>) {
    let Ok(entries) = std::fs::read_dir(path) else {
        logs.push(path.to_owned());
        return;
    };
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    for path in paths {
        let name = path.to_string_lossy().into_owned();
        if path.is_dir() || [".log", ".log.gz", ".clf", ".clf.gz"].iter().any(|end| name.ends_with(end)) {
            collect(&path, logs);
        }
    }
}

fn row(path: &Path) -> Result<(), LogError> {
    let clock = Instant::now();
    let mut reader = LogReader::open(path, BeamOverride::default())?;
    let (mut beams, mut n_odometry, mut span) = (BTreeMap::<usize, u64>::new(), 0_u64, None::<(Time, Time)>);
    while let Some(item) = reader.next() {
        let Ok(record) = item else { continue };
        let stamp = match record.told {
            Told::Scan(scan) => {
                *beams.entry(scan.ranges_m.len()).or_default() += 1;
                reader.recycle(scan.ranges_m);
                scan.stamp
            }
            Told::Odometry(odometry) => {
                n_odometry += 1;
                odometry.stamp
            }
            _ => continue,
        };
        span = Some(span.map_or((stamp, stamp), |(low, high)| (low.min(stamp), high.max(stamp))));
    }
    let seconds = clock.elapsed().as_secs_f64();
    let megabytes = reader.n_bytes() as f64 / 1e6;
    let mut timeline = Timeline::open(path, BeamOverride::default())?;
    let n_in_order = timeline.by_ref().count();
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let kinds: Vec<String> = beams.keys().map(ToString::to_string).collect();
    println!(
        "{name:<40} {:>7} {:>6} {n_odometry:>7} {:>9.1} {:>10} {:>6} {n_in_order:>8} {:>9} {:>7.1}",
        beams.values().sum::<u64>(),
        kinds.join("+"),
        span.map_or(0.0, |(low, high)| (high - low).as_secs()),
        timeline.order().front_laser.n + timeline.order().rear_laser.n,
        timeline.order().odometry.n,
        reader.tally().n_faults(),
        megabytes / seconds,
    );
    for sentence in reader.tally().sentences().into_iter().chain(timeline.order().sentences()) {
        println!("    {sentence}");
    }
    Ok(())
}
