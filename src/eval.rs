//! `rumbo eval`: how good trajectories and maps are.

mod figures;
mod graph;
mod map;
mod relations;
mod slam;
mod trajectory;
mod view;

use crate::exit::{Exit, Failure};
use crate::terminal::Terminal;
use rumbo_kit::trajectory::{TrajectoryFile, TrajectoryFormat, read_trajectory};
use std::path::Path;

/// Compare trajectories and maps with a truth
///
/// Figures are printed for people; --json prints them for programs. The exit code says whether there are figures, not
/// whether they are good.
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(clap::Subcommand)]
enum What {
    Trajectory(trajectory::Args),
    Relations(relations::Args),
    Map(map::Args),
    Slam(slam::Args),
    Graph(graph::Args),
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    match &args.what {
        What::Trajectory(args) => trajectory::run(args, terminal),
        What::Relations(args) => relations::run(args, terminal),
        What::Map(args) => map::run(args, terminal),
        What::Slam(args) => slam::run(args, terminal),
        What::Graph(args) => graph::run(args, terminal),
    }
}

/// How a file of poses is understood.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// t tx ty tz qx qy qz qw
    Tum,
    /// Twelve numbers a line, without stamps
    Kitti,
    /// t x y theta
    Planar,
    /// The poses of laser messages (or vertices) in a robot log
    Log,
    /// The odometer in a robot log
    Odometry,
}

impl From<Format> for TrajectoryFormat {
    fn from(format: Format) -> TrajectoryFormat {
        match format {
            Format::Tum => TrajectoryFormat::Tum,
            Format::Kitti => TrajectoryFormat::Kitti,
            Format::Planar => TrajectoryFormat::Planar,
            Format::Log => TrajectoryFormat::Log,
            Format::Odometry => TrajectoryFormat::Odometry,
        }
    }
}

/// Reads a trajectory and tells people what is odd about its file.
fn read(
    path: &Path,
    format: Option<Format>,
    times: Option<&Path>,
    terminal: &Terminal,
) -> Result<TrajectoryFile, Failure> {
    let read = read_trajectory(path, format.map(TrajectoryFormat::from), times);
    let read = read.map_err(|error| Failure::Usage(error.to_string()))?;
    note(path, &read.notes, terminal);
    Ok(read)
}

fn note(path: &Path, notes: &[String], terminal: &Terminal) {
    for note in notes {
        terminal.say(format!("{} {}: {note}", terminal.bad("note:"), path.display()));
    }
}

/// A number that must be finite and at least zero.
fn not_negative(text: &str) -> Result<f64, String> {
    let number: Result<f64, _> = text.parse();
    match number {
        Ok(number) if number.is_finite() && number >= 0.0 => Ok(number),
        _ => Err("expected a number of at least 0".to_owned()),
    }
}

/// A number that must be finite and above zero.
fn positive(text: &str) -> Result<f64, String> {
    match not_negative(text) {
        Ok(number) if number > 0.0 => Ok(number),
        _ => Err("expected a number above 0".to_owned()),
    }
}
