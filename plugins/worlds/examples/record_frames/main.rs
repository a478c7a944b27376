//! Writes `pipelines/logs/laboratory_frames`: depth pictures of a robot in the laboratory, with poses.
//!
//! `cargo run --release -p rumbo-worlds --example record_frames [FOLDER]`
#![allow(missing_docs, clippy::print_stdout)]

use std::path::{Path, PathBuf};

mod recorder;
mod shipped;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let pipelines = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../pipelines");
    let shipped = || pipelines.join("logs/laboratory_frames");
    let folder = std::env::args_os().nth(1).map_or_else(shipped, PathBuf::from);
    let n = shipped::recorder(&pipelines).record(&folder)?;
    println!("{n} pictures in {}", folder.display());
    Ok(())
}
