//! `rumbo plot`: draws a saved run again, or a pipeline before it runs.

mod preview;

use crate::exit::{Exit, Failure};
use crate::load;
use crate::record::RunRecord;
use crate::report;
use crate::run::write_picture;
use crate::terminal::{Terminal, write_file};
use std::path::{Path, PathBuf};

/// Draw a saved run again, or a pipeline before it runs
///
/// From a file of `rumbo run --save-run` the same report and picture are written. From a pipeline, the picture shows
/// map, start, goals, and what the sensors see from the start.
#[derive(clap::Args)]
pub struct Args {
    /// A saved run (.json) or a pipeline (.toml)
    file: PathBuf,
    /// Change a value of a pipeline
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Write the picture here
    #[arg(long, value_name = "FILE")]
    picture: Option<PathBuf>,
    /// Write the report here
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Print the written files as JSON
    #[arg(long)]
    json: bool,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let record = if args.file.extension().is_some_and(|extension| extension == "json") {
        saved(&args.file)?
    } else {
        let ready = load::pipeline(&args.file, &args.sets, args.json, terminal)?;
        let record = preview::preview(&ready, &args.file.display().to_string());
        record.map_err(|error| ready.explain(&error, args.json, terminal))?
    };
    let stem = args.file.file_stem().unwrap_or_default();
    let usual = || Path::new("out").join(stem).with_extension("png");
    let picture = args.picture.clone().or_else(|| args.report.is_none().then(usual));
    let mut written = serde_json::Map::new();
    if let Some(path) = &picture {
        write_picture(path, &record)?;
        written.insert("picture".into(), path.display().to_string().into());
    }
    if let Some(path) = &args.report {
        write_file(path, report::html(&record).as_bytes())?;
        written.insert("report".into(), path.display().to_string().into());
    }
    if args.json {
        terminal.json(&written)?;
    } else {
        for (what, path) in &written {
            terminal.say(format!("{what}  {}", path.as_str().unwrap_or_default()));
        }
    }
    Ok(Exit::Success)
}

fn saved(path: &Path) -> Result<RunRecord, Failure> {
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::Usage(format!("cannot read {}: {error}", path.display())))?;
    RunRecord::from_json(&text).map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))
}
