//! `rumbo map`: builds a map from a log or by running a pipeline, and saves it.

mod of_log;
mod watch;

use crate::drive::{Driven, drive_engine};
use crate::exit::{Exit, Failure};
use crate::load::{self, Ready};
use crate::outcome::Outcome;
use crate::record::Recorder;
use crate::report;
use crate::run::summary::notices;
use crate::run::{exit_of, on_interrupt, write_picture};
use crate::terminal::{Terminal, make_folder_of, write_file};
use rumbo_core::engine::{EndReason, Engine, Observer, SavedMap};
use rumbo_core::map::Grid;
use rumbo_kit::map_file::{MapFileError, MapImage, PictureFormat, SavedAs, save_map};
use serde::Serialize;
use std::path::{Path, PathBuf};
use watch::MapWatch;

/// Build a map from a recorded log or a pipeline, and save it as map_server files
///
/// A pipeline (.toml) is run, and its map is saved as it is at the end; what its map builders must remember until the next
/// visit is written beside it, as MAP.yaml.NAME. Anything else is taken as a robot log: its laser becomes a grid, seen from
/// the poses inside the log or from those in --poses.
#[derive(clap::Args)]
pub struct Args {
    /// A robot log (CARMEN or Wean Hall, plain or gzip), or a pipeline (.toml)
    file: PathBuf,
    /// Poses for a log: lines of `t x y theta`, plain or gzip, or another log with poses inside
    #[arg(long, value_name = "FILE")]
    poses: Option<PathBuf>,
    /// Edge of a cell for a log, meters
    #[arg(long, value_name = "METERS", default_value_t = 0.05)]
    resolution: f64,
    /// Change a value of the pipeline, also of the one that stands behind a log
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// The map's YAML file; the picture of its cells is written beside it
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// What the file keeps of each cell
    #[arg(long, value_enum, default_value = "trinary")]
    values: Values,
    /// Format of the cells
    #[arg(long, value_enum, default_value = "pgm")]
    format: Format,
    /// Write the report here
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write a picture of map and way here
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write the map only
    #[arg(long)]
    no_report: bool,
    /// Print the figures as one JSON object
    #[arg(long)]
    json: bool,
    /// Say nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Values {
    /// Free, occupied or unknown: what every tool reads
    Trinary,
    /// The probability of each cell in percent, as a gray; needs --format png
    Scale,
    /// The probability of each cell in percent
    Raw,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    /// What every tool reads
    Pgm,
    /// A fraction of the size
    Png,
}

/// What was made.
#[derive(Serialize)]
struct Made {
    map: String,
    width: usize,
    height: usize,
    resolution_m: f64,
    n_scans: u64,
    n_inserted: u64,
    n_occupied: usize,
    n_free: usize,
    /// What map builders keep beside the map.
    kept: Vec<String>,
    run: Option<Outcome>,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let ready = ready(args, terminal)?;
    let interrupt = on_interrupt()?;
    let mut watch = MapWatch::new(!args.quiet && terminal.has_people());
    let file = args.file.display().to_string();
    let mut observers: Vec<&mut dyn Observer> = vec![&mut watch];
    let mut engine =
        Engine::build(&ready.pipeline).map_err(|error| ready.explain(&error, args.json, terminal))?;
    let (pipeline, recorder) = (&ready.pipeline, Recorder::default());
    let driven =
        drive_engine(&mut engine, pipeline, &file, &ready.config, recorder, &mut observers, &interrupt);
    watch.finish();
    let saved = engine.save_map().map_err(|error| Failure::Usage(format!("cannot save the map: {error}")))?;
    let grid = saved.map.grid.as_ref().filter(|grid| grid.known_extent().is_some());
    let Some(grid) = grid else { return Err(no_map(&driven, &watch)) };
    let yaml = args.named(&args.output, "yaml");
    let made = save(args, grid, &yaml, &watch, &driven)?;
    let made = Made { kept: keep(&saved, &yaml)?, ..made };
    let written = write_reports(args, &driven)?;
    if !args.quiet {
        say(&made, &driven, &written, terminal);
    }
    if args.json {
        terminal.json(&made)?;
    }
    Ok(made.run.as_ref().map_or(Exit::Success, exit_of))
}

impl Args {
    /// A file below `out/`, named after the log or the pipeline, unless another one was named.
    fn named(&self, named: &Option<PathBuf>, extension: &str) -> PathBuf {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let stem = name.split('.').find(|part| !part.is_empty()).unwrap_or("map").to_owned();
        named.clone().unwrap_or_else(|| Path::new("out").join(stem + "-map").with_extension(extension))
    }
}

fn ready(args: &Args, terminal: &Terminal) -> Result<Ready, Failure> {
    let is_pipeline = args.file.extension().is_some_and(|extension| extension == "toml");
    if is_pipeline {
        if args.poses.is_some() {
            let message = "--poses is for logs; name a [localizer] in the pipeline instead";
            return Err(Failure::Usage(message.to_owned()));
        }
        return load::pipeline(&args.file, &args.sets, args.json, terminal);
    }
    let text = of_log::pipeline_text(&args.file, args.poses.as_deref(), args.resolution);
    let shown = Path::new("(the pipeline behind a log)");
    let loaded = load::from_text(shown, &text, &args.sets, &load::registry()?);
    loaded.map_err(|refused| refused.tell(args.json, terminal))
}

/// Why there is nothing to save.
fn no_map(driven: &Driven, watch: &MapWatch) -> Failure {
    let mut message = match (&driven.map.grid, watch.n_scans) {
        (None, _) => "the pipeline has no map layer `grid`; name a [map_builder] that gives one".to_owned(),
        (Some(_), 0) => "the map is empty: no laser scan came".to_owned(),
        (Some(_), n) => format!(
            "the map is empty: none of {n} laser scans was inserted; is there a pose for their time, and is the \
             localizer sure of it?"
        ),
    };
    let outcome = driven.record.outcome.as_ref();
    if let Some(detail) = outcome.and_then(|outcome| outcome.detail.as_ref()) {
        message += &format!("\n  the run said: {detail}");
    }
    let troubles = driven.record.events.iter().filter(|event| event.is_trouble);
    for event in troubles.take(5) {
        message += &format!("\n  {:.1} s: {}", event.time_s, event.text);
    }
    Failure::Usage(message)
}

fn save(args: &Args, grid: &Grid, yaml: &Path, watch: &MapWatch, driven: &Driven) -> Result<Made, Failure> {
    let saved_as = match args.values {
        Values::Trinary => SavedAs::Trinary,
        Values::Scale => SavedAs::Scale,
        Values::Raw => SavedAs::Raw,
    };
    let format = match args.format {
        Format::Pgm => PictureFormat::Pgm,
        Format::Png => PictureFormat::Png,
    };
    let Some(image) = MapImage::of_grid(grid, saved_as) else {
        return Err(Failure::Internal("the map lost its cells; this is a bug".to_owned()));
    };
    make_folder_of(yaml)?;
    save_map(yaml, &image, saved_as, format).map_err(|error| match error {
        MapFileError::Unsayable { .. } => Failure::Usage(error.to_string()),
        _ => Failure::Internal(error.to_string()),
    })?;
    Ok(Made {
        map: yaml.display().to_string(),
        width: image.width,
        height: image.height,
        resolution_m: image.resolution_m,
        n_scans: watch.n_scans,
        n_inserted: watch.n_inserted,
        n_occupied: image.cells.iter().filter(|percent| **percent > 50).count(),
        n_free: image.cells.iter().filter(|percent| (0..50).contains(*percent)).count(),
        kept: Vec::new(),
        run: driven.record.outcome.clone(),
    })
}

/// Writes what map builders must remember beside the map; each file is moved to its place once it is whole.
fn keep(saved: &SavedMap, yaml: &Path) -> Result<Vec<String>, Failure> {
    let mut written = Vec::new();
    for (name, bytes) in &saved.kept {
        let path = yaml.with_added_extension(file_word(name));
        if written.contains(&path.display().to_string()) {
            let message = format!("two map builders would write {}; give them other names", path.display());
            return Err(Failure::Usage(message));
        }
        let part = path.with_added_extension(format!("{}.part", std::process::id()));
        write_file(&part, bytes)?;
        std::fs::rename(&part, &path)
            .map_err(|error| Failure::Internal(format!("cannot write {}: {error}", path.display())))?;
        written.push(path.display().to_string());
    }
    Ok(written)
}

/// The name of a map builder, without what has a meaning in paths.
fn file_word(name: &str) -> String {
    let is_plain = |letter: char| letter.is_alphanumeric() || "-_".contains(letter);
    name.chars().map(|letter| if is_plain(letter) { letter } else { '_' }).collect()
}

fn write_reports(args: &Args, driven: &Driven) -> Result<Vec<(&'static str, PathBuf)>, Failure> {
    let mut written = Vec::new();
    if args.report.is_some() || !args.no_report {
        let path = args.named(&args.report, "html");
        write_file(&path, report::html(&driven.record).as_bytes())?;
        written.push(("report", path));
    }
    if args.picture.is_some() || !args.no_report {
        // The cells themselves may be written as `-map.png`.
        let path = args.picture.clone().unwrap_or_else(|| args.named(&None, "picture.png"));
        write_picture(&path, &driven.record)?;
        written.push(("picture", path));
    }
    Ok(written)
}

fn say(made: &Made, driven: &Driven, written: &[(&str, PathBuf)], terminal: &Terminal) {
    let meters = |cells: usize| cells as f64 * made.resolution_m;
    let mut rows = vec![
        ("size", format!("{} x {} cells of {} m", made.width, made.height, made.resolution_m)),
        ("covers", format!("{:.1} m x {:.1} m", meters(made.width), meters(made.height))),
        ("free", format!("{:.1} m²", meters(made.n_free) * made.resolution_m)),
        ("scans", format!("{}, of which {} changed the map", made.n_scans, made.n_inserted)),
        ("map", made.map.clone()),
    ];
    rows.extend(made.kept.iter().map(|path| ("memory", path.clone())));
    rows.extend(written.iter().map(|(name, path)| (*name, path.display().to_string())));
    let is_interrupted = made.run.as_ref().is_some_and(|run| run.reason == EndReason::Interrupted);
    let end = if is_interrupted {
        terminal.bad(": interrupted, the map is of what was seen until then")
    } else {
        String::new()
    };
    terminal.say(terminal.strong(&driven.record.name) + &end);
    notices(&driven.record.events, terminal).for_each(|line| terminal.say(line));
    for (name, value) in rows {
        terminal.say(format!("  {}  {value}", terminal.soft(&format!("{name:7}"))));
    }
}
