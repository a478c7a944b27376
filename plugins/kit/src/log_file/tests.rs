//! Logs as they should be and as they are: every format, every fault, every cut.

mod damage;
mod faults;
mod formats;
mod order;
mod poses;

use std::io::Write;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU32, Ordering};

use flate2::Compression;
use flate2::write::GzEncoder;

use super::*;

/// A file that goes with its test.
struct TempFile(PathBuf);

impl TempFile {
    fn new(bytes: &[u8]) -> TempFile {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let n = COUNT.fetch_add(1, Ordering::Relaxed);
        let path = std::env::temp_dir().join(format!("rumbo-log-{}-{n}.clf", std::process::id()));
        std::fs::write(&path, bytes).unwrap();
        TempFile(path)
    }
}

impl Drop for TempFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// All records, all faulty lines, and the tally of a log.
fn read(bytes: &[u8]) -> (Vec<LogRecord>, Vec<LineFault>, Tally) {
    let file = TempFile::new(bytes);
    let mut reader = LogReader::open(&file.0, BeamOverride::default()).unwrap_or_else(|e| panic!("{e}"));
    let (mut records, mut faults) = (Vec::new(), Vec::new());
    for item in reader.by_ref() {
        match item {
            Ok(record) => records.push(record),
            Err(fault) => faults.push(fault),
        }
    }
    (records, faults, reader.tally().clone())
}

fn open_error(bytes: &[u8]) -> String {
    let file = TempFile::new(bytes);
    let message = LogReader::open(&file.0, BeamOverride::default()).unwrap_err().to_string();
    message.replace(&file.0.display().to_string(), "FILE")
}

fn scans(records: &[LogRecord]) -> Vec<&RecordedScan> {
    let scan = |record: &'_ LogRecord| matches!(record.told, Told::Scan(_));
    records
        .iter()
        .filter(|record| scan(record))
        .map(|record| match &record.told {
            Told::Scan(scan) => scan,
            _ => unreachable!(),
        })
        .collect()
}

/// An old laser message with `n` beams of 1.00, 1.01, ... meters.
fn flaser(n: usize, stamp: &str) -> String {
    let ranges: Vec<String> = (0..n).map(|k| format!("{:.2}", 1.0 + 0.01 * k as f64)).collect();
    format!("FLASER {n} {} 1 2 0.5 3 4 -0.5 {stamp} nohost 0.1\n", ranges.join(" "))
}

fn odom(x: f64, stamp: f64) -> String {
    format!("ODOM {x} 0 0 0.2 0.1 0 {stamp:.6} nohost 0\n")
}
