//! `rumbo compare`: algorithms x worlds x seeds, with intervals.

mod by_world;
mod csv;
mod design;
mod draw;
mod figures;
mod fingerprint;
mod free_space;
mod ground;
mod journal;
mod page;
mod pareto;
mod plots;
mod progress;
mod range;
mod result;
mod statistics;
mod study;
mod summary;
mod swap;
mod sweep;
mod table;
mod worlds;

use crate::exit::{Exit, Failure};
use crate::load::{self, Ready};
use crate::run::on_interrupt;
use crate::terminal::{Terminal, make_folder_of, write_file};
use design::{Design, effective};
use journal::{Journal, JournalError};
use progress::Progress;
use rumbo_core::registry::Registry;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use study::Study;
use summary::{Results, Summary, summarize};
use worlds::Place;

/// Compare plugins over worlds and seeds: success, time, way, clearance, errors and CPU, with intervals
///
/// Every combination of the swaps runs in every world with every seed. Each run that ended is kept in
/// FOLDER/runs.jsonl: after an interrupt the same command goes on where it was.
#[derive(clap::Args)]
pub struct Args {
    /// The pipeline that the alternatives are made of, or a study file that names it
    ///
    /// A study has everything that is said here, and what each seed draws, in a file: see docs/compare.md.
    file: PathBuf,
    /// Plugins that take a part's place in turn, for example --swap planner=dp,a_star
    #[arg(long = "swap", value_name = "SECTION=PLUGIN,PLUGIN", value_parser = swap::parse)]
    swaps: Vec<swap::Swap>,
    /// World or map files that take the place of the pipeline's, as a pattern in quotes
    ///
    /// A file NAME.mission.toml beside a world gives start and waypoints; else both are drawn from the seed.
    #[arg(long, value_name = "GLOB")]
    worlds: Vec<String>,
    /// Seeds for each alternative in each world; 20 when absent
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    seeds: Option<u32>,
    /// The first seed; the others follow
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(..=1 << 62))]
    first_seed: u64,
    /// Change a value for all alternatives
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Draw a value for each seed, the same for all alternatives, for example world.slip.speed=0.0..0.05
    #[arg(long = "set-range", value_name = "KEY=A..B", value_parser = range::parse)]
    ranges: Vec<range::SetRange>,
    /// Missions that each seed draws in each world; without --worlds in the pipeline's own world
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    missions: Option<u32>,
    /// Runs at the same time; as many as there are processors when absent
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Where to write; a folder below out/ named after the pipeline when absent
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Print the summary as one JSON object
    #[arg(long)]
    json: bool,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let registry = load::registry()?;
    let study = Study::read(&args.file).map_err(Failure::Usage)?.unwrap_or_default();
    let design = design(args, &study, &registry, terminal)?;
    let fingerprint = design.fingerprint(&registry);
    let folder = args.folder();
    let path = folder.join("runs.jsonl");
    make_folder_of(&path)?;
    let (journal, mut results) = Journal::open(&path, &design, &fingerprint).map_err(failure)?;
    let n_runs = design.runs().len();
    if !results.is_empty() {
        terminal.say(format!("{} of {n_runs} runs are done already, in {}", results.len(), path.display()));
    }
    let stop = on_interrupt()?;
    let progress = Progress::new(n_runs - results.len(), terminal.has_people());
    let n_threads = args.threads.map_or_else(n_processors, usize::from);
    let ended = sweep::sweep(&design, &registry, journal, &mut results, n_threads, &progress, &stop);
    progress.finish();
    ended.map_err(failure)?;
    let summary = summarize(&design, &results);
    write(&folder, &design, &fingerprint, &results, &summary)?;
    terminal.say(table::table(&summary, terminal));
    terminal.say(format!("report  {}", folder.join("report.html").display()));
    if args.json {
        terminal.json(&serde_json::json!({
            "design": fingerprint, "n_runs": n_runs, "n_done": results.len(), "folder": folder.display().to_string(),
            "alternatives": summary.alternatives, "worlds": summary.by_world, "differences": summary.differences,
            "objectives": summary.objectives,
        }))?;
    }
    if stop.load(Ordering::Relaxed) && results.len() < n_runs {
        let n_done = results.len();
        terminal
            .say(format!("interrupted after {n_done} of {n_runs} runs; the same command goes on from here"));
        return Ok(Exit::Interrupted);
    }
    Ok(Exit::Success)
}

impl Args {
    fn folder(&self) -> PathBuf {
        let stem = self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        self.output.clone().unwrap_or_else(|| Path::new("out").join(stem + "-compare"))
    }
}

fn n_processors() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn failure(error: JournalError) -> Failure {
    match error {
        JournalError::Io { .. } => Failure::Internal(error.to_string()),
        _ => Failure::Usage(error.to_string()),
    }
}

fn design(args: &Args, study: &Study, registry: &Registry, terminal: &Terminal) -> Result<Design, Failure> {
    let file = if study.is_none() { &args.file } else { &study.pipeline };
    let sets: Vec<String> = study.set.iter().chain(&args.sets).cloned().collect();
    let swaps: Vec<swap::Swap> = study.swaps().chain(args.swaps.iter().cloned()).collect();
    let base = load::pipeline(file, &sets, args.json, terminal)?;
    let whole = effective(&base);
    swap::check(&swaps, &whole, (file, &sets), registry).map_err(Failure::Usage)?;
    let n_seeds = args.seeds.or(study.seeds).unwrap_or(20);
    let design = Design {
        title: study.title.clone(),
        base: file.clone(),
        ranges: study.ranges().chain(args.ranges.iter().cloned()).collect(),
        alternatives: swap::alternatives(&swaps, &study.alternative),
        places: places(args, study, &base, &whole).map_err(Failure::Usage)?,
        seeds: (args.first_seed..).take(n_seeds as usize).collect(),
        show: study.show.clone(),
        sets,
    };
    // One alternative may not fit together: that is a result. If none does, the command is at fault.
    let mut first = None;
    for run in design.runs().iter().take(design.alternatives.len()) {
        // A world without room for what is drawn is a result, too.
        let Ok(drawn) = design.drawn(run) else { return Ok(design) };
        match design.load(run, &drawn, registry) {
            Ok(_) => return Ok(design),
            Err(refused) => {
                first.get_or_insert(refused);
            }
        }
    }
    Err(first.map_or_else(
        || Failure::Internal("a design without runs; this is a bug".to_owned()),
        |refused| refused.tell(args.json, terminal),
    ))
}

fn places(args: &Args, study: &Study, base: &Ready, whole: &serde_json::Value) -> Result<Vec<Place>, String> {
    let patterns = if args.worlds.is_empty() { &study.worlds } else { &args.worlds };
    let radius_m = base.pipeline.robot.hull().outer_radius_m();
    let n_missions = args.missions.unwrap_or(1);
    if !patterns.is_empty() {
        if let Some(file) = fixed_map(whole) {
            return Err(format!(
                "the pipeline's map_builder reads {file} in every world; leave out `file`, so that it takes the \
                 world's own map"
            ));
        }
        let places = worlds::find(patterns, radius_m, n_missions)?;
        return Ok(worlds::in_scenes(&places, study));
    }
    if args.missions.is_none() && study.is_none() {
        return Ok(vec![Place::own()]);
    }
    let map = whole.pointer("/world/map").and_then(|map| map.as_str());
    let map = map.ok_or("--missions draws places on a map, and the pipeline's world has none")?;
    let place = Place::own_world(&base.pipeline.folder.join(map), radius_m, n_missions)?;
    Ok(worlds::in_scenes(&[place], study))
}

/// The file that a map builder names.
fn fixed_map(whole: &serde_json::Value) -> Option<String> {
    let builders = whole.get("map_builder")?;
    let listed = builders.as_array().map_or_else(|| std::slice::from_ref(builders), Vec::as_slice);
    listed.iter().find_map(|builder| Some(builder.get("file")?.as_str()?.to_owned()))
}

fn write(
    folder: &Path,
    design: &Design,
    fingerprint: &str,
    results: &Results,
    summary: &Summary,
) -> Result<(), Failure> {
    write_file(&folder.join("results.csv"), csv::results(design, results).as_bytes())?;
    write_file(&folder.join("timing.csv"), csv::timing(design, results).as_bytes())?;
    let page = page::html(design, fingerprint, results, summary);
    write_file(&folder.join("report.html"), page.as_bytes())
}
