//! `rumbo replay`: runs a recording again, and says whether it is the same.

mod comparison;
mod difference;
mod figures;
mod report;
mod world;

use crate::exit::{Exit, Failure};
use crate::load::{self, Ready};
use crate::recording::{PROGRAM, file_hash, plugins_of};
use crate::run::on_interrupt;
use crate::terminal::Terminal;
use comparison::Comparison;
use report::Report;
use rumbo_core::engine::{EndReason, Engine, Inbox};
use rumbo_kit::recording::{RecordingReader, RunHeader};
use std::path::{Path, PathBuf};
use world::{Follow, ReplayWorld};

/// Run a recording again: the same bytes, or the first stage, time and field that differ
///
/// With --swap or --set, the recorded inputs go through something else, and the differences are figures, no failure.
#[derive(clap::Args)]
pub struct Args {
    /// The recording, from `rumbo run --record`
    recording: PathBuf,
    /// Put another plugin into a seat, for example --swap planner=a_star or --swap sensor.front_laser=laser_2d
    #[arg(long = "swap", value_name = "SECTION=PLUGIN")]
    swaps: Vec<String>,
    /// Change a value, for example --set planner.minimum_clearance_m=0.2
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print what was found as one JSON object
    #[arg(long)]
    json: bool,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let sets = args.sets()?;
    let follow = if sets.is_empty() { Follow::Steps } else { Follow::Times };
    let (first, second) = (open(&args.recording)?, open(&args.recording)?);
    let header = first.header().clone();
    let ready = pipeline_of(&header, &sets, args.json, terminal)?;
    let notes = notes(&header, &ready, follow);
    let inbox = Inbox::default();
    let is_input = ready.pipeline.sensors.iter().map(|sensor| sensor.inputs.is_empty()).collect();
    let world = ReplayWorld::new(first, follow, is_input, inbox.clone());
    let built = Engine::build_in(&ready.pipeline, Box::new(world));
    let mut engine = built.map_err(|error| Failure::Usage(error.to_string()))?;
    engine.listen(inbox);
    let mut comparison = Comparison::new(second, follow);
    let end = engine.run(&mut [&mut comparison], on_interrupt()?.as_ref());
    if end.reason == EndReason::Interrupted {
        return Ok(Exit::Interrupted);
    }
    let compared = comparison.finish(&end, engine.view().map);
    let report = Report::new(&args.recording, follow, notes, compared, &end);
    terminal.say(report.text(terminal));
    if args.json {
        terminal.json(&report)?;
    }
    Ok(if report.is_good() { Exit::Success } else { Exit::NoSuccess })
}

impl Args {
    /// Swaps as the values that they set, in front of the others.
    fn sets(&self) -> Result<Vec<String>, Failure> {
        let swap = |swap: &String| match swap.split_once('=') {
            Some((section, plugin)) if !section.trim().is_empty() && !plugin.trim().is_empty() => {
                Ok(format!("{}.plugin={}", section.trim(), plugin.trim()))
            }
            _ => Err(Failure::Usage(format!("--swap {swap}: expected SECTION=PLUGIN, as in planner=a_star"))),
        };
        let swaps = self.swaps.iter().map(swap).collect::<Result<Vec<String>, Failure>>()?;
        let sets: Vec<String> = swaps.into_iter().chain(self.sets.iter().cloned()).collect();
        match sets.iter().find(|set| set.trim_start().starts_with("world")) {
            Some(set) => Err(Failure::Usage(format!(
                "{set}: the world of a replay is the recording; run the pipeline instead"
            ))),
            None => Ok(sets),
        }
    }
}

fn open(path: &Path) -> Result<RecordingReader, Failure> {
    RecordingReader::open(path).map_err(|error| Failure::Usage(error.to_string()))
}

/// The recorded pipeline, as if it stood in its file.
fn pipeline_of(
    header: &RunHeader,
    sets: &[String],
    json: bool,
    terminal: &Terminal,
) -> Result<Ready, Failure> {
    let (file, registry) = (Path::new(&header.file), load::registry()?);
    let loaded = load::from_text(file, &header.pipeline, sets, &registry);
    let mut ready = loaded.map_err(|refused| refused.tell(json, terminal))?;
    if let Some(duration_s) = header.duration_s {
        ready.limit(duration_s);
    }
    Ok(ready)
}

/// What may make a replay differ, before it does.
fn notes(header: &RunHeader, ready: &Ready, follow: Follow) -> Vec<String> {
    let mut notes = Vec::new();
    if header.program != PROGRAM {
        notes.push(format!("recorded by {}, this is {PROGRAM}", header.program));
    }
    let plugins = plugins_of(&ready.pipeline);
    let changed = header.plugins.iter().zip(&plugins).filter(|(recorded, now)| recorded != now);
    notes.extend(
        changed.filter(|_| follow == Follow::Steps).map(|(recorded, now)| format!("{recorded} is now {now}")),
    );
    if let Some(map) = header.map_file.as_ref().filter(|map| file_hash(map) != header.map_file_hash) {
        notes.push(format!("{} is no longer the file that was recorded", map.display()));
    }
    if header.is_real_time {
        notes.push("recorded in real time: when a plan arrived depends on the machine".to_owned());
    }
    notes
}

#[cfg(test)]
mod tests;
