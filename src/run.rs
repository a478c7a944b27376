//! `rumbo run`: drives the robot and shows what happened.

mod leaves;
pub mod lost;
mod open;
mod pace;
pub mod poses;
mod progress;
mod silent;
pub mod summary;

use crate::drive::drive_engine;
use crate::exit::{Exit, Failure};
use crate::load::{self, Ready};
use crate::outcome::Outcome;
use crate::picture::{Raster, poster};
use crate::record::{Recorder, RunRecord};
use crate::recording::{RunRecording, header_of};
use crate::report;
use crate::terminal::{Terminal, write_file};
use leaves::{Leaves, refuse_impossible, refuse_unsaved};
use lost::{Kept, end_when_lost};
use pace::Pace;
use poses::Poses;
use progress::Progress;
use rumbo_core::engine::{EndReason, Engine, Observer};
use silent::Silent;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Run a pipeline: drive the robot and show what happened
///
/// Writes one HTML page and a picture below out/, named after the pipeline's file.
#[derive(clap::Args)]
pub struct Args {
    /// The pipeline
    file: PathBuf,
    /// Change a value, for example --set planner.minimum_clearance_m=0.2
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Seed of every random stream, instead of the pipeline's
    #[arg(long, value_parser = clap::value_parser!(u64).range(..=i64::MAX as u64))]
    seed: Option<u64>,
    /// The whole run may take this many seconds of the world's time
    #[arg(long, value_name = "SECONDS", value_parser = above_zero)]
    duration: Option<f64>,
    /// Times the speed of real time; as fast as possible when absent
    #[arg(long, value_name = "FACTOR", value_parser = above_zero)]
    speed: Option<f64>,
    /// Write the report here
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write the picture here
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write neither report nor picture, but those that are named
    #[arg(long)]
    no_report: bool,
    /// Save what `rumbo plot` needs to draw this run again
    #[arg(long, value_name = "FILE")]
    save_run: Option<PathBuf>,
    /// Write where the robot thought that it was at each laser scan, as lines of `t x y theta` for `rumbo eval`
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// Write where the robot was at each scan as the plugin in [slam] knows it at the end of the run (after loops were
    /// closed), as lines of `t x y theta` for `rumbo eval`
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,
    /// Save the whole state of the plugin in [slam] at the end of the run, also of one that was interrupted, so that another
    /// run goes on from it: `[slam] resume = FILE`. What was in the file stays until the new state is complete
    #[arg(long, value_name = "FILE")]
    save_state: Option<PathBuf>,
    /// Record the run as MCAP, for viewers and for `rumbo replay`; instead of the pipeline's `record`
    #[arg(long, value_name = "FILE")]
    record: Option<PathBuf>,
    /// Open the report in the browser when the run has ended
    #[arg(long)]
    open: bool,
    /// Print the figures as one JSON object
    #[arg(long)]
    json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// A finite number above zero.
fn above_zero(text: &str) -> Result<f64, String> {
    let number: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    let fits = number > 0.0 && number.is_finite();
    if fits { Ok(number) } else { Err(format!("is {text}, expected a finite number above zero")) }
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let mut ready = load::checked(&args.file, &args.sets(), args.json, terminal)?;
    if let Some(duration_s) = args.duration {
        ready.limit(duration_s);
    }
    let recorded = args.recording(&ready);
    refuse_impossible(args, &ready.pipeline)?;
    let mut poses = args.poses.is_some().then(Poses::default);
    let (record, leaves) = watched_drive(args, &ready, recorded.as_deref(), &mut poses, terminal)?;
    let Some(outcome) = &record.outcome else {
        return Err(Failure::Internal("the run left no figures; this is a bug".into()));
    };
    let mut written = write_files(args, &record)?;
    written.extend(recorded.map(|path| ("recording", path)));
    if let (Some(path), Some(poses)) = (&args.poses, &poses) {
        write_file(path, poses.text().as_bytes())?;
        written.push(("poses", path.clone()));
        if poses.is_empty() && !args.quiet {
            terminal.say(format!(
                "{} no poses: no laser scan came while somebody knew where the robot was",
                terminal.bad("note:")
            ));
        }
    }
    let left = leaves.write(args, &mut written);
    if !args.quiet {
        terminal.say(summary::summary(outcome, &record.events, &written, terminal));
    }
    if args.json {
        terminal.json(outcome)?;
    }
    if args.open {
        open_first(&written, terminal);
    }
    left?;
    Ok(exit_of(outcome))
}

impl Args {
    fn sets(&self) -> Vec<String> {
        let seed = self.seed.map(|seed| format!("seed={seed}"));
        self.sets.iter().cloned().chain(seed).collect()
    }

    /// A file below `out/`, named after the pipeline, unless another one was named.
    fn output(&self, named: &Option<PathBuf>, extension: &str) -> Option<PathBuf> {
        named.clone().or_else(|| (!self.no_report).then(|| self.usual(extension)))
    }

    /// Somebody will look at the whole run.
    fn draws(&self) -> bool {
        !self.no_report || self.report.is_some() || self.picture.is_some() || self.save_run.is_some()
    }

    /// Somebody will look at the way as it is known at the end, or go on from it.
    fn asks_for_way(&self) -> bool {
        self.draws() || self.trajectory.is_some() || self.save_state.is_some()
    }

    fn usual(&self, extension: &str) -> PathBuf {
        Path::new("out").join(self.file.file_stem().unwrap_or_default()).with_extension(extension)
    }

    /// Where to record, if at all.
    fn recording(&self, ready: &Ready) -> Option<PathBuf> {
        self.record.clone().or_else(|| ready.record(|| self.usual("mcap")))
    }
}

fn watched_drive(
    args: &Args,
    ready: &Ready,
    recorded: Option<&Path>,
    poses: &mut Option<Poses>,
    terminal: &Terminal,
) -> Result<(RunRecord, Leaves), Failure> {
    let interrupt = on_interrupt()?;
    let built = Engine::build(&ready.pipeline);
    let mut engine = built.map_err(|error| ready.explain(&error, args.json, terminal))?;
    refuse_unsaved(args, &engine)?;
    let begin = |path| RunRecording::create(path, &header_of(ready, &args.file, args.duration, &engine));
    let mut recording = Kept::new(recorded.map(begin).transpose()?);
    end_when_lost(recording.clone(), *terminal);
    let mut progress = (!args.quiet && terminal.has_people()).then(|| Progress::new(&ready.pipeline));
    let mut pace = args.speed.map(Pace::new);
    let mut silent = Silent::of(&ready.pipeline);
    let mut others: Vec<&mut dyn Observer> = vec![&mut recording, &mut silent];
    others.extend(progress.as_mut().map(|progress| progress as &mut dyn Observer));
    others.extend(poses.as_mut().map(|poses| poses as &mut dyn Observer));
    others.extend(pace.as_mut().map(|pace| pace as &mut dyn Observer));
    let file = args.file.display().to_string();
    let recorder = if args.draws() { Recorder::default() } else { Recorder::of_events() };
    if !args.asks_for_way() {
        engine.keep_no_trajectory();
    }
    let (pipeline, config) = (&ready.pipeline, &ready.config);
    let driven = drive_engine(&mut engine, pipeline, &file, config, recorder, &mut others, &interrupt);
    if let Some(progress) = progress {
        progress.finish();
    }
    if let Some(recording) = recording.take() {
        recording.finish(&driven.end, &engine.view())?;
    }
    if !args.quiet {
        for name in silent.names() {
            let advice = "a recording may have no channel of this name, see `rumbo plugins describe log`";
            terminal.say(format!(
                "{} `{name}` gave nothing during the whole run; {advice}",
                terminal.bad("note:")
            ));
        }
    }
    let leaves = Leaves::of(args, &engine);
    Ok((driven.record, leaves))
}

/// Raised by the first interrupt, which stops the robot; the second ends the program.
pub fn on_interrupt() -> Result<Arc<AtomicBool>, Failure> {
    let flag = Arc::new(AtomicBool::new(false));
    let raised = Arc::clone(&flag);
    let handler = move || {
        if raised.swap(true, Ordering::Relaxed) {
            std::process::exit(Exit::Interrupted.code().into());
        }
    };
    ctrlc::set_handler(handler)
        .map_err(|error| Failure::Internal(format!("cannot catch interrupts: {error}")))?;
    Ok(flag)
}

/// Report, picture and saved run, as far as they are wanted.
fn write_files(args: &Args, record: &RunRecord) -> Result<Vec<(&'static str, PathBuf)>, Failure> {
    let mut written = Vec::new();
    if let Some(path) = args.output(&args.report, "html") {
        write_file(&path, report::html(record).as_bytes())?;
        written.push(("report", path));
    }
    if let Some(path) = args.output(&args.picture, "png") {
        write_picture(&path, record)?;
        written.push(("picture", path));
    }
    if let Some(path) = &args.save_run {
        let json = serde_json::to_vec(record);
        write_file(path, &json.map_err(|error| Failure::Internal(format!("cannot save the run: {error}")))?)?;
        written.push(("saved run", path.clone()));
    }
    Ok(written)
}

/// Opens the report, or the picture where there is no report.
fn open_first(written: &[(&'static str, PathBuf)], terminal: &Terminal) {
    let Some((what, path)) = written.first() else {
        return terminal.say("nothing was written, so there is nothing to open; leave out --no-report");
    };
    if let Err(error) = open::open(path) {
        terminal.say(format!("cannot open the {what} by itself ({error}); open {}", path.display()));
    }
}

/// Draws the run and writes it as PNG.
pub fn write_picture(path: &Path, record: &RunRecord) -> Result<(), Failure> {
    /// Sharp on screens with small pixels.
    const SCALE: f64 = 1.5;
    let png = Raster::draw(&poster(record), SCALE).and_then(|raster| raster.png());
    let png = png.map_err(|error| Failure::Internal(format!("cannot draw the picture: {error}")))?;
    write_file(path, &png)
}

/// What the caller is told of a run.
pub fn exit_of(outcome: &Outcome) -> Exit {
    match outcome.reason {
        EndReason::Interrupted => Exit::Interrupted,
        _ if outcome.is_success() => Exit::Success,
        _ => Exit::NoSuccess,
    }
}
