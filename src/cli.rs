//! The command line: verbs, and what becomes of each.

use crate::exit::Failure;
use crate::run::lost::{Kept, end_when_lost};
use crate::terminal::Terminal;
use crate::{
    check, compare, completions, config, emulate, eval, load, map, new, plot, plugins, replay, run, schema,
    test,
};
use clap::{Parser, Subcommand};
use rumbo_core::boundary::host::on_log;
use std::path::PathBuf;
use std::process::ExitCode;

const EXIT_CODES: &str = "\
Exit codes:
  0    it worked: the robot arrived, the tests passed, the file has no faults
  1    it ran, but the robot did not arrive, a test failed, a replay differs, or a plugin breaks a law
  2    the input has faults: the pipeline, a file that it names, or the command line
  3    rumbo itself failed: a file cannot be written, or there is a bug
  130  interrupted; the robot was stopped first

Results go to standard output, everything for people to standard error.
NO_COLOR and --color never switch colors off.";

/// A robot navigation system from one TOML file.
#[derive(Parser)]
#[command(name = "rumbo", version, about, after_help = EXIT_CODES, max_term_width = 100, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    verb: Verb,
    /// Colors on the terminal
    #[arg(long, global = true, value_name = "WHEN", default_value = "auto")]
    color: Color,
    /// A shared library with more plugins; may be given several times
    // A verb may have an argument called `plugins` of its own.
    #[arg(long = "plugin", id = "library", global = true, value_name = "FILE")]
    libraries: Vec<PathBuf>,
}

#[derive(Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Color {
    Auto,
    Always,
    Never,
}

#[derive(Subcommand)]
enum Verb {
    Run(run::Args),
    Check(check::Args),
    Config(config::Args),
    Schema(schema::Args),
    Plugins(plugins::Args),
    New(new::Args),
    Test(test::Args),
    Replay(replay::Args),
    Compare(compare::Args),
    Map(map::Args),
    Eval(eval::Args),
    Plot(plot::Args),
    Emulate(emulate::Args),
    Completions(completions::Args),
}

/// Lets the system's allocator keep what is given back to it.
///
/// By itself glibc returns large blocks to the system and takes them back a moment later, at a page fault for every 4 KiB:
/// whether it does is decided by a few bytes, so that one more word on the command line cost 1,700 page faults. A block that
/// was given back makes it keep all that is smaller (`M_MMAP_THRESHOLD` in mallopt(3)); the pages of this one are never
/// touched. Other allocators take no notice.
fn keep_memory() {
    const BYTES: usize = 16 << 20;
    drop(std::hint::black_box(Vec::<u8>::with_capacity(BYTES)));
}

/// Does what the command line says.
pub fn main() -> ExitCode {
    keep_memory();
    let cli = Cli::parse();
    let terminal = Terminal::new(match cli.color {
        Color::Auto => None,
        Color::Always => Some(true),
        Color::Never => Some(false),
    });
    load::use_libraries(&cli.libraries);
    end_when_lost(Kept::default(), terminal);
    on_log(move |log| terminal.say(format!("{}: {}: {}", log.target, log.level, log.message)));
    let result = match &cli.verb {
        Verb::Run(args) => run::run(args, &terminal),
        Verb::Check(args) => check::run(args, &terminal),
        Verb::Config(args) => config::run(args, &terminal),
        Verb::Schema(args) => schema::run(args, &terminal),
        Verb::Plugins(args) => plugins::run(args, &terminal),
        Verb::New(args) => new::run(args, &terminal),
        Verb::Test(args) => test::run(args, &terminal),
        Verb::Replay(args) => replay::run(args, &terminal),
        Verb::Compare(args) => compare::run(args, &terminal),
        Verb::Map(args) => map::run(args, &terminal),
        Verb::Eval(args) => eval::run(args, &terminal),
        Verb::Plot(args) => plot::run(args, &terminal),
        Verb::Emulate(args) => emulate::run(args, &terminal),
        Verb::Completions(args) => completions::run(args, &terminal),
    };
    let exit = result.unwrap_or_else(|failure| {
        match &failure {
            Failure::Usage(message) | Failure::Internal(message) => terminal.error(message),
            // Nobody reads on: there is nobody to tell.
            Failure::Told(_) | Failure::NobodyReads => {}
        }
        failure.exit()
    });
    exit.into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn libraries_and_the_arguments_of_verbs_do_not_get_in_each_others_way() {
        let cli = Cli::try_parse_from(["rumbo", "plugins", "verify", "one", "--plugin", "two.so"]).unwrap();
        assert_eq!(cli.libraries, [PathBuf::from("two.so")]);
    }
}
