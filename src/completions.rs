//! `rumbo completions`: what the shell needs to complete commands.

use crate::cli::Cli;
use crate::exit::{Exit, Failure};
use crate::terminal::Terminal;
use clap::CommandFactory as _;
use clap_complete::Shell;

/// Print completions for a shell
///
/// For example: rumbo completions bash > ~/.local/share/bash-completion/completions/rumbo
#[derive(clap::Args)]
pub struct Args {
    /// The shell
    shell: Shell,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "rumbo", &mut script);
    terminal.data(&String::from_utf8_lossy(&script))?;
    Ok(Exit::Success)
}
