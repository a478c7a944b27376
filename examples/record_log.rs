//! A run in simulation, written as a CARMEN log: scans with the true pose and the odometer's, and the odometer itself.
//!
//! `cargo run --release --example record_log -- PIPELINE.toml LOG.clf.gz [KEY=VALUE...]`. The shipped
//! `pipelines/logs/office_tour.clf.gz` was written from `pipelines/office_tour.toml` with
//! `sensor.front_laser.resolution_deg=1.0 sensor.front_laser.rate_hz=1.0 sensor.wheels.rate_hz=4.0`.
#![allow(clippy::print_stdout)]

use flate2::Compression;
use flate2::write::GzEncoder;
use rumbo_core::engine::{Engine, Observer, StepView};
use rumbo_core::frames::{Pose2, flatten};
use rumbo_core::messages::{Data, LaserScan, Odometry};
use rumbo_core::pipeline::Loaded;
use rumbo_core::time::Time;
use std::error::Error;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// Stamps count from here, as those of real logs count from long ago, seconds.
const FIRST_STAMP_S: f64 = 1_000_000_000.0;
/// What a SICK scanner writes where it sees nothing, meters.
const NOTHING_SEEN_M: f32 = 81.83;

/// Writes down what comes by.
struct LogWriter {
    log: GzEncoder<File>,
    failed: Option<std::io::Error>,
    n_scans: usize,
    n_odometry: usize,
}

impl LogWriter {
    fn line(&mut self, text: &str) {
        if let Err(error) = writeln!(self.log, "{text}") {
            self.failed.get_or_insert(error);
        }
    }

    fn odometry(&mut self, stamp: Time, odometry: &Odometry) {
        let Odometry { odom_from_base, twist, .. } = odometry;
        let (pose, end) = (numbers(odom_from_base), ending(stamp));
        self.line(&format!("ODOM {pose} {:.4} {:.4} 0 {end}", twist.forward_m_s, twist.turn_rad_s));
        self.n_odometry += 1;
    }

    fn scan(&mut self, stamp: Time, scan: &LaserScan, truth: &Pose2, odom_from_base: &Pose2) {
        let ranges: Vec<String> = scan
            .ranges_m
            .iter()
            .map(|range| if range.is_finite() { *range } else { NOTHING_SEEN_M })
            .map(|range| format!("{range:.2}"))
            .collect();
        let (truth, odometer) = (numbers(truth), numbers(odom_from_base));
        let text =
            format!("FLASER {} {} {truth} {odometer} {}", ranges.len(), ranges.join(" "), ending(stamp));
        self.line(&text);
        self.n_scans += 1;
    }
}

fn numbers(pose: &Pose2) -> String {
    format!("{:.4} {:.4} {:.5}", pose.translation.x, pose.translation.y, pose.rotation.angle())
}

fn ending(stamp: Time) -> String {
    let seconds = stamp.as_secs();
    format!("{:.6} rumbo {seconds:.6}", FIRST_STAMP_S + seconds)
}

impl Observer for LogWriter {
    fn on_step(&mut self, view: &StepView<'_>) {
        for observation in view.observations {
            match (&observation.data, view.truth) {
                (Data::Odometry(odometry), _) => self.odometry(observation.stamp, odometry),
                (Data::LaserScan(scan), Some(truth)) => {
                    self.scan(observation.stamp, scan, &flatten(&truth.map_from_base), &view.odom_from_base);
                }
                _ => {}
            }
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let (Some(pipeline), Some(log)) = (arguments.next(), arguments.next()) else {
        return Err("usage: record_log PIPELINE.toml LOG.clf.gz [KEY=VALUE...]".into());
    };
    let sets: Vec<String> = arguments.collect();
    let loaded = Loaded::read(Path::new(&pipeline), &sets, &rumbo::registry()?);
    let pipeline = loaded.sound().ok_or_else(|| loaded.lines().join("\n"))?;
    let log = GzEncoder::new(File::create(log)?, Compression::best());
    let mut writer = LogWriter { log, failed: None, n_scans: 0, n_odometry: 0 };
    writer.line("# CARMEN Logfile");
    writer.line("# message formats defined: PARAM ODOM FLASER");
    writer.line("PARAM robot_frontlaser_offset 0.0 nohost 0");
    let end = Engine::build(pipeline)?.run(&mut [&mut writer], &AtomicBool::new(false));
    writer.failed.map_or(Ok(()), Err)?;
    writer.log.finish()?;
    println!("{}: {} scans, {} odometry readings", end.reason, writer.n_scans, writer.n_odometry);
    Ok(())
}
