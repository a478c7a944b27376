//! `rumbo plugins`: everything that a pipeline can name.

mod describe;
mod pages;
pub(crate) mod parameters;
mod verify;

use crate::exit::{Exit, Failure};
use crate::load;
use crate::terminal::Terminal;
use clap::Subcommand;
use rumbo_core::registry::{Entry, LibraryInfo, Registry, Stage};
use serde_json::json;
use std::path::PathBuf;
use std::sync::Arc;

/// List, describe and verify what a pipeline can name
#[derive(clap::Args)]
pub struct Args {
    #[command(subcommand)]
    verb: Verb,
}

#[derive(Subcommand)]
enum Verb {
    /// List all plugins
    List {
        /// Only those of one section, such as planner
        #[arg(long, value_name = "SECTION")]
        stage: Option<String>,
        /// Print as JSON
        #[arg(long)]
        json: bool,
    },
    /// Show a plugin's parameters, needs and gifts, and an example
    Describe {
        /// Its name, or section.name where two sections have one of this name
        name: String,
        /// Print as JSON
        #[arg(long)]
        json: bool,
    },
    /// Write one page for each plugin into a folder
    Docs {
        /// The folder
        folder: PathBuf,
        /// Write nothing; fail when a page is missing, left over or differs
        #[arg(long)]
        check: bool,
    },
    Verify(verify::Args),
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let registry = load::registry()?;
    match &args.verb {
        Verb::List { stage, json } => list(&registry, stage.as_deref(), *json, terminal),
        Verb::Describe { name, json } => {
            let entry = find(&registry, name)?;
            if *json {
                terminal.json(&describe::as_json(entry))?;
            } else {
                terminal.data(&describe::as_text(entry, terminal))?;
            }
            Ok(Exit::Success)
        }
        Verb::Docs { folder, check } => pages::write(&registry, folder, *check, terminal),
        Verb::Verify(args) => verify::run(registry, args, terminal),
    }
}

fn list(
    registry: &Registry,
    section: Option<&str>,
    json: bool,
    terminal: &Terminal,
) -> Result<Exit, Failure> {
    let stage = section.map(stage_of).transpose()?;
    let entries: Vec<&Entry> = registry
        .iter()
        .map(AsRef::as_ref)
        .filter(|entry: &&Entry| stage.is_none_or(|stage| entry.stage == stage))
        .collect();
    if json {
        let plugins: Vec<_> = entries.iter().map(|entry| summary(entry)).collect();
        terminal.json(&plugins)?;
        return Ok(Exit::Success);
    }
    let width = entries.iter().map(|entry| entry.name.len()).max().unwrap_or(0);
    let mut text = String::new();
    let mut last = None;
    for entry in entries {
        if last.replace(entry.stage) != Some(entry.stage) {
            let gap = if text.is_empty() { "" } else { "\n" };
            text += &format!("{gap}[{}]\n", entry.stage.section());
        }
        text += &format!("  {:width$}  {}\n", entry.name, entry.summary);
        if let Some(library) = &entry.library {
            text += &of_library(library, &entry.version, width);
        }
    }
    terminal.data(&text)?;
    Ok(Exit::Success)
}

/// Where a plugin comes from that is not linked in.
fn of_library(library: &LibraryInfo, version: &str, width: usize) -> String {
    let LibraryInfo { path, sha256, abi: (major, minor), build_info } = library;
    let indent = " ".repeat(width + 4);
    format!(
        "{indent}{version}, {}\n{indent}ABI {major}.{minor}, built by {build_info}\n{indent}sha256 {sha256}\n",
        path.display(),
    )
}

/// What everybody wants to know of a plugin.
fn summary(entry: &Entry) -> serde_json::Value {
    json!({
        "stage": entry.stage.section(), "name": entry.name, "summary": entry.summary,
        "version": entry.version, "origin": entry.origin,
        "library": entry.library.as_ref().map(|library| json!({
            "sha256": library.sha256, "abi": [library.abi.0, library.abi.1], "build_info": library.build_info,
        })),
    })
}

fn stage_of(section: &str) -> Result<Stage, Failure> {
    let found = Stage::ALL.into_iter().find(|stage| stage.section() == section);
    found.ok_or_else(|| {
        let known = Stage::ALL.map(Stage::section);
        let hint = load::did_you_mean(section, known);
        Failure::Usage(format!("no section is called `{section}`{hint}; there are {}", known.join(", ")))
    })
}

fn find<'r>(registry: &'r Registry, name: &str) -> Result<&'r Arc<Entry>, Failure> {
    let (section, bare) = name.split_once('.').map_or((None, name), |(section, bare)| (Some(section), bare));
    let found: Vec<&Arc<Entry>> = registry
        .iter()
        .filter(|entry| entry.name == bare && section.is_none_or(|s| entry.stage.section() == s))
        .collect();
    match found.as_slice() {
        [entry] => Ok(entry),
        [] => {
            let hint = load::did_you_mean(bare, registry.iter().map(|entry| entry.name.as_str()));
            Err(Failure::Usage(format!("no plugin is called `{name}`{hint}; see `rumbo plugins list`")))
        }
        several => {
            let names: Vec<_> = several.iter().map(|e| format!("{}.{}", e.stage.section(), e.name)).collect();
            Err(Failure::Usage(format!("several plugins are called `{name}`; say {}", names.join(" or "))))
        }
    }
}
