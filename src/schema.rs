//! `rumbo schema`: what a pipeline file may say, for editors.

use crate::exit::{Exit, Failure};
use crate::load;
use crate::terminal::Terminal;

/// Print the JSON schema of pipeline files
///
/// Editors that know `#:schema rumbo.schema.json` complete and check pipelines with it.
#[derive(clap::Args)]
pub struct Args {}

/// Does it.
pub fn run(_: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    terminal.json(&rumbo_core::pipeline::schema(&load::registry()?))?;
    Ok(Exit::Success)
}
