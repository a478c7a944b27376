//! `rumbo check`: every fault of a pipeline, without running it.

use crate::exit::{Exit, Failure};
use crate::load;
use crate::terminal::Terminal;
use serde_json::json;
use std::path::PathBuf;

/// Find every fault of pipelines, without running them
#[derive(clap::Args)]
pub struct Args {
    /// The pipelines
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Change a value, for example --set planner.plugin=a_star
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print the faults as JSON
    #[arg(long)]
    json: bool,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let registry = load::registry()?;
    let mut files = Vec::new();
    let mut is_fine = true;
    for path in &args.files {
        let name = path.display().to_string();
        match load::load_and_check(path, &args.sets, &registry) {
            Ok(ready) if args.json => {
                files.push(json!({ "file": name, "faults": [], "warnings": ready.warnings() }));
            }
            Ok(ready) => {
                ready.warn(terminal);
                terminal.say(format!("{name}: {}", terminal.good("no faults")));
            }
            Err(refused) => {
                is_fine = false;
                if args.json {
                    files.push(json!({ "file": name, "faults": refused.to_json() }));
                } else {
                    refused.show(terminal);
                }
            }
        }
    }
    if args.json {
        terminal.json(&files)?;
    }
    Ok(if is_fine { Exit::Success } else { Exit::Faults })
}
