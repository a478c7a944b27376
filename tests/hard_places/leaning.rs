//! Nose down by 45 degrees for five seconds, and level again.

use super::watch::{Drive, Walls, at_95, drive};
use rumbo_core::engine::EndReason;
use std::path::PathBuf;

/// Leaned over within the second before, and level again in the second after.
const LEANING: &str = "world.sway={ pitch_deg = 45.0, frequency_hz = 0.0, from_s = 2.0, to_s = 9.0 }";
const STANDS_S: f64 = 11.0;

/// The drive around the lane, after a while of standing.
fn standing_first(name: &str) -> PathBuf {
    let lane = concat!(env!("CARGO_MANIFEST_DIR"), "/pipelines/drives/rubble_lane.csv");
    let text = std::fs::read_to_string(lane).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let mut out = format!("{}\n0,0,0\n", lines.next().unwrap());
    for line in lines {
        let (seconds, rest) = line.split_once(',').unwrap();
        out += &format!("{},{rest}\n", seconds.parse::<f64>().unwrap() + STANDS_S);
    }
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, out).unwrap();
    path
}
