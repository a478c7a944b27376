//! `rumbo new`: a plugin of your own that builds, passes its test, and drives a robot.

mod files;
mod name;
mod source;

use crate::exit::{Exit, Failure};
use crate::load;
use crate::terminal::{Terminal, write_file};
use clap::ValueEnum;
use files::{Filled, filled};
use source::Source;
use std::path::{Path, PathBuf};

/// Write a plugin of your own: a crate or a C file, with a pipeline that drives a robot with it
#[derive(clap::Args)]
pub struct Args {
    /// What it shall be
    stage: Kind,
    /// Its name in pipelines: a letter, then letters, digits and _, all small
    name: String,
    /// The language it is written in
    #[arg(long, value_name = "LANGUAGE", default_value = "rust")]
    lang: Language,
    /// Write it into this folder, which must be empty or not there; a new one of the plugin's name when absent
    #[arg(long, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Where a Rust plugin gets rumbo-core from: Rumbo's source folder, or the address of a git repository
    #[arg(long, value_name = "FOLDER or ADDRESS")]
    rumbo: Option<String>,
}

/// The stages that a plugin from elsewhere can fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Kind {
    /// Reads the world
    Sensor,
    /// Keeps what was seen
    MapBuilder,
    /// Says where the robot is
    Localizer,
    /// Maps and localizes at once
    Slam,
    /// Finds a way
    Planner,
    /// Steers along it
    Avoider,
}

impl Kind {
    /// Its section in a pipeline.
    fn section(self) -> &'static str {
        match self {
            Kind::Sensor => "sensor",
            Kind::MapBuilder => "map_builder",
            Kind::Localizer => "localizer",
            Kind::Slam => "slam",
            Kind::Planner => "planner",
            Kind::Avoider => "avoider",
        }
    }
}

/// What plugins can be written in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Language {
    /// A crate
    Rust,
    /// A file for any C compiler
    C,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    name::check(&args.name, &load::linked()?)?;
    let folder = args.output.clone().unwrap_or_else(|| PathBuf::from(&args.name));
    check_is_free(&folder)?;
    let files = match args.lang {
        Language::Rust => {
            let source = Source::of(args.rumbo.as_deref())?;
            filled(args.stage, args.lang, &args.name, &source.dependency())?
        }
        Language::C if args.rumbo.is_some() => {
            return Err(Failure::Usage("--rumbo is for Rust plugins: C needs its header only".into()));
        }
        Language::C => filled(args.stage, args.lang, &args.name, "")?,
    };
    for Filled { path, text } in &files {
        write_file(&folder.join(path), text.as_bytes())?;
    }
    terminal.say(next(&folder, args.lang, &files));
    Ok(Exit::Success)
}

/// Nothing is written over.
fn check_is_free(folder: &Path) -> Result<(), Failure> {
    let is_free = match std::fs::read_dir(folder) {
        Ok(mut entries) => entries.next().is_none(),
        Err(_) => !folder.exists(),
    };
    if is_free {
        return Ok(());
    }
    let shown = folder.display();
    Err(Failure::Usage(format!("{shown} is there already; remove it, or name another one with --output")))
}

/// What was written, and what to do with it.
fn next(folder: &Path, lang: Language, files: &[Filled]) -> String {
    let names: Vec<_> = files.iter().map(|file| file.path).collect();
    let build = match lang {
        Language::Rust => "cargo build --release",
        Language::C => "sh build.sh",
    };
    format!(
        "wrote {} ({})\n\nnow:\n  cd {}\n  {build}\n  rumbo check pipeline.toml\n  rumbo run pipeline.toml --open",
        folder.display(),
        names.join(", "),
        folder.display(),
    )
}
