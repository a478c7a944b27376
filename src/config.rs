//! `rumbo config`: the pipeline as it takes effect.

use crate::exit::{Exit, Failure};
use crate::load;
use crate::terminal::Terminal;
use std::path::PathBuf;

/// Print the pipeline as it takes effect, with the origin of each value
#[derive(clap::Args)]
pub struct Args {
    /// The pipeline
    file: PathBuf,
    /// Change a value, for example --set planner.plugin=a_star
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print values and origins as JSON
    #[arg(long)]
    json: bool,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let ready = load::pipeline(&args.file, &args.sets, args.json, terminal)?;
    if args.json {
        terminal.json(&ready.to_json())?
    } else {
        terminal.data(&ready.config)?
    }
    Ok(Exit::Success)
}
