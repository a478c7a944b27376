//! `rumbo eval slam`: SLAM plugins on real logs, one row for each log and pipeline.

mod table;

use super::relations::in_time_of;
use crate::drive::drive_engine;
use crate::exit::{Exit, Failure};
use crate::load::{self, Ready};
use crate::record::Recorder;
use crate::run::poses::Poses;
use crate::run::{on_interrupt, write_picture};
use crate::terminal::{Terminal, make_folder_of};
use crate::usage::{forget_peak_memory, peak_memory_mb, thread_cpu_s};
use rumbo_core::engine::{EndReason, Engine};
use rumbo_core::time::Span;
use rumbo_kit::relations::{Relation, pose_near, read_relations, relation_errors};
use rumbo_kit::spread::Spread;
use rumbo_kit::trajectory::{StampedPose, Trajectory};
use serde::Serialize;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use table::{head, line};

/// Stamps this close are the same.
const SAME_STAMP_S: f64 = 0.000_05;

/// Errors, speed and memory of SLAM plugins on robot logs: a row for each log and pipeline
///
/// Every pipeline plays every log as its world (`world.file`). Where the robot was at its scans, as the plugin thought at
/// the time and as it knows at the end of the run, is judged by known relations between scans (as `rumbo eval relations`),
/// which lie beside the log: NAME.clf.gz and NAME.relations.gz; NAME-part.clf.gz takes them too.
#[derive(clap::Args)]
pub struct Args {
    /// Pipelines with a [slam] whose world is a log
    #[arg(required = true)]
    pipelines: Vec<PathBuf>,
    /// A robot log; may be given several times
    #[arg(long = "log", value_name = "LOG", required = true)]
    logs: Vec<PathBuf>,
    /// Change a value of all pipelines, for example --set slam.levels=3
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Write a picture of map and way of each row here, as LOG-PIPELINE.png
    #[arg(long, value_name = "FOLDER")]
    pictures: Option<PathBuf>,
    /// Print the rows as JSON
    #[arg(long)]
    json: bool,
}

/// Errors of one set of poses.
#[derive(Serialize)]
struct Errors {
    n_used: usize,
    translation_m: Spread,
    rotation_rad: Spread,
}

#[derive(Serialize)]
struct Row {
    log: String,
    pipeline: String,
    plugin: String,
    reason: EndReason,
    n_relations: usize,
    /// Where the plugin thought that the robot was, at each scan.
    at_the_time: Option<Errors>,
    /// Where it knows at the end that the robot was; absent where it keeps no trajectory.
    at_the_end: Option<Errors>,
    /// Share of the steps in which it said that it tracked its way.
    tracked_share: f64,
    log_s: f64,
    #[serde(flatten)]
    cost: Cost,
}

/// What a row cost, with the map at its end.
#[derive(Serialize)]
struct Cost {
    wall_s: f64,
    cpu_s: Option<f64>,
    peak_memory_mb: Option<f64>,
}

impl Args {
    fn picture(&self, log: &Path, pipeline: &Path) -> Option<PathBuf> {
        let name = format!("{}-{}.png", name_of(log), name_of(pipeline));
        self.pictures.as_ref().map(|folder| folder.join(name))
    }

    /// Refuses two rows with one picture and makes the folder, before hours of work.
    fn prepare_pictures(&self) -> Result<(), Failure> {
        let rows = self.logs.iter().flat_map(|log| self.pipelines.iter().map(move |of| (log, of)));
        let mut named = BTreeSet::new();
        for picture in rows.filter_map(|(log, pipeline)| self.picture(log, pipeline)) {
            if named.contains(&picture) {
                let message =
                    format!("two rows would write {}; rename a log or a pipeline", picture.display());
                return Err(Failure::Usage(message));
            }
            named.insert(picture);
        }
        named.first().map_or(Ok(()), |picture| make_folder_of(picture))
    }
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let interrupt = on_interrupt()?;
    let relations: Result<Vec<_>, _> = args.logs.iter().map(|log| relations_of(log)).collect();
    let (relations, mut rows) = (relations?, Vec::new());
    args.prepare_pictures()?;
    if !args.json {
        terminal.say(terminal.soft(&head()));
    }
    for (log, relations) in args.logs.iter().zip(&relations) {
        for pipeline in &args.pipelines {
            let row = row_of(args, log, pipeline, relations, &interrupt, terminal)?;
            if row.reason == EndReason::Interrupted {
                return Ok(Exit::Interrupted);
            }
            if !args.json {
                terminal.say(line(&row));
            }
            rows.push(row);
        }
    }
    if args.json {
        terminal.json(&rows)?;
    }
    let all_played = rows.iter().all(|row| row.reason == EndReason::Ended);
    Ok(if all_played { Exit::Success } else { Exit::NoSuccess })
}

/// The relations beside a log: `x-y.clf.gz` has `x-y.relations.gz`, `x-y.relations`, or those of `x`.
fn relations_of(log: &Path) -> Result<Vec<Relation>, Failure> {
    let name = log.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let whole = name.split('.').next().unwrap_or_default();
    let stems = std::iter::successors(Some(whole), shorter);
    let beside = |stem: &str, ending: &str| log.with_file_name(format!("{stem}.{ending}"));
    let found = stems.flat_map(|stem| [beside(stem, "relations.gz"), beside(stem, "relations")]);
    let path = found.into_iter().find(|path| path.exists()).ok_or_else(|| {
        let (log, missing) = (log.display(), beside(whole, "relations.gz"));
        Failure::Usage(format!("{log} has no relations beside it: there is no {}", missing.display()))
    })?;
    read_relations(&path).map(|(relations, _)| relations).map_err(|error| Failure::Usage(error.to_string()))
}

/// A name without its last part.
fn shorter<'n>(name: &&'n str) -> Option<&'n str> {
    name.rsplit_once('-').map(|(front, _)| front)
}

fn row_of(
    args: &Args,
    log: &Path,
    pipeline: &Path,
    relations: &[Relation],
    interrupt: &AtomicBool,
    terminal: &Terminal,
) -> Result<Row, Failure> {
    let ready = ready(args, log, pipeline, terminal)?;
    let Some(slam) = &ready.pipeline.slam else {
        return Err(Failure::Usage(format!("{} has no [slam] to judge", pipeline.display())));
    };
    let built = Engine::build(&ready.pipeline);
    let mut engine = built.map_err(|error| ready.explain(&error, args.json, terminal))?;
    let (file, mut poses) = (pipeline.display().to_string(), Poses::default());
    let (driven, cost) = priced(|| {
        let (of, config, recorder) = (&ready.pipeline, &ready.config, Recorder::default());
        drive_engine(&mut engine, of, &file, config, recorder, &mut [&mut poses], interrupt)
    });
    if let Some(detail) = driven.end.detail.as_ref().filter(|_| driven.end.reason != EndReason::Ended) {
        terminal.error(&format!("{file} on {}: {detail}", log.display()));
    }
    let picture = args.picture(log, pipeline).filter(|_| driven.end.reason != EndReason::Interrupted);
    if let Some(Err(failure)) = picture.map(|picture| write_picture(&picture, &driven.record)) {
        // The figures of hours are worth more than a picture.
        terminal.error(&failure.to_string());
    }
    let known = engine.trajectory();
    let known = known.map_err(|error| Failure::Internal(format!("{file}: {error}")))?;
    let known = known.iter().map(|pose| (pose.stamp, pose.map_from_base)).map(stamped).collect();
    let thought = poses.poses().map(stamped).collect();
    Ok(Row {
        log: name_of(log),
        pipeline: name_of(pipeline),
        plugin: slam.entry.name.clone(),
        reason: driven.end.reason,
        n_relations: relations.len(),
        at_the_time: errors(log, thought, relations)?,
        at_the_end: errors(log, known, relations)?,
        tracked_share: driven.record.outcome.and_then(|outcome| outcome.tracked_share).unwrap_or(0.0),
        log_s: (engine.view().now - engine.view().started).as_secs(),
        cost,
    })
}

/// Does something, and says what it cost.
fn priced<T>(work: impl FnOnce() -> T) -> (T, Cost) {
    forget_peak_memory();
    let (clock, cpu_before) = (Instant::now(), thread_cpu_s());
    let done = work();
    let (wall_s, cpu_after) = (clock.elapsed().as_secs_f64(), thread_cpu_s());
    let cpu_s = cpu_after.zip(cpu_before).map(|(after, before)| after - before);
    (done, Cost { wall_s, cpu_s, peak_memory_mb: peak_memory_mb() })
}

fn ready(args: &Args, log: &Path, pipeline: &Path, terminal: &Terminal) -> Result<Ready, Failure> {
    // A path from the working folder stays one, whatever folder the pipeline is in.
    let log = std::path::absolute(log).unwrap_or_else(|_| log.to_path_buf());
    let file = toml::Value::from(log.display().to_string());
    let sets: Vec<String> = args.sets.iter().cloned().chain([format!("world.file={file}")]).collect();
    load::checked(pipeline, &sets, args.json, terminal)
}

fn stamped((stamp, world_from_body): (rumbo_core::time::Time, rumbo_core::frames::Pose3)) -> StampedPose {
    StampedPose { stamp, world_from_body }
}

fn errors(log: &Path, poses: Vec<StampedPose>, relations: &[Relation]) -> Result<Option<Errors>, Failure> {
    let (poses, _) = Trajectory::of(in_time_of(log, &poses)?);
    let tolerance = Span::from_secs(SAME_STAMP_S);
    let errors = relation_errors(relations, |stamp| pose_near(&poses, stamp, tolerance));
    let n_used = relations.len() - errors.n_missed;
    let spreads = Spread::of(errors.translation_m).zip(Spread::of(errors.rotation_rad));
    Ok(spreads.map(|(translation_m, rotation_rad)| Errors { n_used, translation_m, rotation_rad }))
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    name.split('.').next().unwrap_or_default().to_owned()
}
