//! `rumbo eval trajectory`: absolute and relative errors of a trajectory.

use super::{Format, figures, positive, read, view};
use crate::exit::{Exit, Failure};
use crate::terminal::{Terminal, write_file};
use rumbo_core::time::{Span, Time};
use rumbo_kit::spread::Spread;
use rumbo_kit::trajectory::{
    Alignment, PairChoice, PosePair, Similarity, Step, Trajectory, TrajectoryFile, absolute_errors, align,
    index_pairs, pose_pairs, relative_errors,
};
use serde::Serialize;
use std::path::PathBuf;

/// Errors of a trajectory against the true one: absolute (ATE) and relative (RPE)
///
/// Both files may be TUM (`t tx ty tz qx qy qz qw`), KITTI (12 numbers a line), lines of `t x y theta`, or robot logs;
/// plain or gzip. Poses are paired by their stamps, the nearest first, each once.
#[derive(clap::Args)]
pub struct Args {
    /// The trajectory to judge
    estimate: PathBuf,
    /// The true one
    truth: PathBuf,
    /// How the estimate is laid over the truth first
    #[arg(long, value_enum, default_value = "se3")]
    align: Align,
    /// Stamps closer than this belong together
    #[arg(long, value_name = "SECONDS", default_value = "0.02", value_parser = positive)]
    max_gap: f64,
    /// Step of the relative error
    #[arg(long, value_name = "NUMBER", default_value = "1", value_parser = positive)]
    rpe_delta: f64,
    /// Unit of that step; meters are counted along the estimate
    #[arg(long, value_enum, default_value = "frames")]
    rpe_unit: Unit,
    /// From which poses a step is made
    #[arg(long, value_enum, default_value = "consecutive")]
    rpe_pairs: Pairs,
    /// Format of the estimate, instead of looking
    #[arg(long, value_enum)]
    estimate_format: Option<Format>,
    /// Format of the truth, instead of looking
    #[arg(long, value_enum)]
    truth_format: Option<Format>,
    /// One stamp a line for the poses of KITTI files
    #[arg(long, value_name = "FILE")]
    times: Option<PathBuf>,
    /// Write a picture of both here
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Print the figures as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Align {
    /// As it is
    None,
    /// Moved and turned
    Se3,
    /// Moved, turned and scaled
    Sim3,
    /// Moved, and turned about the vertical axis only
    Yaw,
    /// First pose onto first pose
    First,
}

#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
enum Unit {
    /// Pairs of poses
    Frames,
    /// Seconds
    S,
    /// Meters
    M,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Pairs {
    /// Step after step, from the first pose on
    Consecutive,
    /// One from every pose
    Overlapping,
    /// Every pose with every later one, whatever the step
    All,
}

#[derive(Serialize)]
struct Figures {
    n_estimate: usize,
    n_truth: usize,
    n_pairs: usize,
    /// Share of the truth's time between the first pair and the last.
    coverage: f64,
    length_m: f64,
    scale: f64,
    /// x, y, z and quaternion x, y, z, w.
    truth_from_estimate: [f64; 7],
    ate_m: Spread,
    rpe_m: Option<Spread>,
    rpe_rad: Option<Spread>,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let step = step(args)?;
    let times = args.times.as_deref();
    let estimate = read(&args.estimate, args.estimate_format, times, terminal)?;
    let truth = read(&args.truth, args.truth_format, times, terminal)?;
    let pairs = paired(args, &estimate, &truth)?;
    let alignment = align(&pairs, args.align.into()).map_err(|error| Failure::Usage(error.to_string()))?;
    let figures = judged(args, step, [&estimate.trajectory, &truth.trajectory], &pairs, &alignment)?;
    if let Some(path) = &args.picture {
        let sketch = view::overlay(&pairs, &alignment, &figures.headline());
        write_file(path, &view::png(&sketch)?)?;
    }
    if args.json {
        terminal.json(&figures)?;
    } else {
        say(args, &figures, terminal);
    }
    Ok(Exit::Success)
}

impl From<Align> for Alignment {
    fn from(align: Align) -> Alignment {
        match align {
            Align::None => Alignment::None,
            Align::Se3 => Alignment::Se3,
            Align::Sim3 => Alignment::Sim3,
            Align::Yaw => Alignment::Yaw,
            Align::First => Alignment::First,
        }
    }
}

fn step(args: &Args) -> Result<Step, Failure> {
    match args.rpe_unit {
        Unit::S => Ok(Step::Seconds(args.rpe_delta)),
        Unit::M => Ok(Step::Meters(args.rpe_delta)),
        Unit::Frames if args.rpe_delta.fract() == 0.0 => Ok(Step::Frames(args.rpe_delta as usize)),
        Unit::Frames => Err(Failure::Usage(format!(
            "--rpe-delta is {}, expected a whole number of frames; name another unit with --rpe-unit",
            args.rpe_delta
        ))),
    }
}

/// The poses that belong together; at least two.
fn paired(args: &Args, estimate: &TrajectoryFile, truth: &TrajectoryFile) -> Result<Vec<PosePair>, Failure> {
    if estimate.has_stamps != truth.has_stamps {
        let bare = if estimate.has_stamps { &args.truth } else { &args.estimate };
        let message =
            format!("{} has no stamps and the other file has; give them with --times", bare.display());
        return Err(Failure::Usage(message));
    }
    if args.rpe_unit == Unit::S && !estimate.has_stamps {
        return Err(Failure::Usage("a step in seconds needs stamps; give them with --times".to_owned()));
    }
    let pairs = pose_pairs(&truth.trajectory, &estimate.trajectory, Span::from_secs(args.max_gap));
    if pairs.len() >= 2 {
        return Ok(pairs);
    }
    let found = match pairs.len() {
        0 => "no two stamps",
        _ => "only one pair of stamps",
    };
    Err(Failure::Usage(format!(
        "{found} closer than {} s, expected at least 2 pairs\n  estimate: {}\n  truth: {}\n  are both clocks the \
         same? A larger --max-gap takes stamps that are farther apart",
        args.max_gap,
        range(&estimate.trajectory),
        range(&truth.trajectory)
    )))
}

fn range(trajectory: &Trajectory) -> String {
    let n = trajectory.poses().len();
    let seconds = |stamp: Time| format!("{:.6}", stamp.as_secs());
    match trajectory.time_range() {
        Some((first, last)) => format!("{n} poses from {} s to {} s", seconds(first), seconds(last)),
        None => "no pose".to_owned(),
    }
}

fn judged(
    args: &Args,
    step: Step,
    [estimate, truth]: [&Trajectory; 2],
    pairs: &[PosePair],
    alignment: &Similarity,
) -> Result<Figures, Failure> {
    let bug = || Failure::Internal("there are pairs and no errors; this is a bug".to_owned());
    let choice = match args.rpe_pairs {
        Pairs::Consecutive => PairChoice::Consecutive,
        Pairs::Overlapping => PairChoice::EveryStart,
        Pairs::All => PairChoice::All,
    };
    too_many(pairs.len(), choice)?;
    let relative = relative_errors(pairs, alignment, &index_pairs(pairs, step, choice));
    let duration = |range: Option<(Time, Time)>| range.map_or(0.0, |(from, to)| (to - from).as_secs());
    let paired = pairs.first().zip(pairs.last()).map(|(first, last)| (first.stamp, last.stamp));
    let covered = duration(paired) / duration(truth.time_range()).max(f64::MIN_POSITIVE);
    let pose = &alignment.truth_from_estimate;
    let (t, q) = (pose.translation.vector, pose.rotation.coords);
    Ok(Figures {
        n_estimate: estimate.poses().len(),
        n_truth: truth.poses().len(),
        n_pairs: pairs.len(),
        coverage: covered,
        length_m: truth.length_m(),
        scale: alignment.scale,
        truth_from_estimate: [t.x, t.y, t.z, q.x, q.y, q.z, q.w],
        ate_m: Spread::of(absolute_errors(pairs, alignment)).ok_or_else(bug)?,
        rpe_m: Spread::of(relative.translation_m),
        rpe_rad: Spread::of(relative.rotation_rad),
    })
}

/// Every pose with every other one is a square.
fn too_many(n: usize, choice: PairChoice) -> Result<(), Failure> {
    const MOST: usize = 50_000_000;
    let n_compared = n.saturating_mul(n.saturating_sub(1)) / 2;
    if choice != PairChoice::All || n_compared <= MOST {
        return Ok(());
    }
    Err(Failure::Usage(format!(
        "all pairs of {n} poses are {n_compared} comparisons, expected at most {MOST}; name --rpe-pairs overlapping and \
         a step"
    )))
}

impl Figures {
    fn headline(&self) -> String {
        format!("{} pairs, ATE rmse {:.4} m, max {:.4} m", self.n_pairs, self.ate_m.rmse, self.ate_m.max)
    }
}

fn say(args: &Args, figures: &Figures, terminal: &Terminal) {
    let title = format!("{} against {}", args.estimate.display(), args.truth.display());
    let mut rows = vec![
        ("pairs", format!("{} of {} and {} poses", figures.n_pairs, figures.n_estimate, figures.n_truth)),
        ("covered", format!("{:.1} % of the truth's time", 100.0 * figures.coverage)),
        ("length", format!("{:.3} m", figures.length_m)),
    ];
    if args.align == Align::Sim3 {
        rows.push(("scale", format!("{:.6}", figures.scale)));
    }
    if let Some(path) = &args.picture {
        rows.push(("picture", path.display().to_string()));
    }
    figures::lines(&title, &rows, terminal);
    let mut errors = vec![("ATE", "m", 1.0, figures.ate_m)];
    errors.extend(figures.rpe_m.map(|spread| ("RPE translation", "m", 1.0, spread)));
    errors.extend(figures.rpe_rad.map(|spread| ("RPE rotation", "deg", 1.0_f64.to_degrees(), spread)));
    figures::spreads(&errors, terminal);
    if figures.rpe_m.is_none() {
        terminal.say("  no two poses are one step apart, so there is no RPE; make --rpe-delta smaller");
    }
}
