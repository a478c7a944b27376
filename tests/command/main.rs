//! The built command, as people and programs use it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod check;
mod compare;
mod emulate;
mod eval;
mod help;
mod map;
mod marks;
#[cfg(unix)]
mod new;
mod plot;
mod plugins;
mod readme;
mod record;
mod replay;
mod run;
mod same_bytes;
mod slam;
mod test;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The office, shipped with the command.
const OFFICE: &str = "pipelines/office.toml";
/// A short way, so that a run takes a moment.
const SHORT: &str = "mission.waypoints=[{ x_m = 3.0, y_m = 5.0 }]";

/// The built command in the folder of the sources.
fn rumbo(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rumbo"));
    command.args(args).current_dir(env!("CARGO_MANIFEST_DIR")).env_remove("NO_COLOR");
    command
}

/// What it gave.
struct Given {
    code: i32,
    stdout: String,
    stderr: String,
}

impl Given {
    fn json(&self) -> serde_json::Value {
        serde_json::from_str(&self.stdout).unwrap_or_else(|error| panic!("{error}: {}", self.stdout))
    }
}

fn given(command: &mut Command) -> Given {
    let Output { status, stdout, stderr } = command.output().unwrap();
    Given {
        code: status.code().unwrap_or(-1),
        stdout: String::from_utf8(stdout).unwrap(),
        stderr: String::from_utf8(stderr).unwrap(),
    }
}

fn give(args: &[&str]) -> Given {
    given(&mut rumbo(args))
}

/// An empty folder of this test's own.
fn scratch(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// A file in a folder of this test's own.
fn file(name: &str, text: &str) -> String {
    let path = scratch(name).join("pipeline.toml");
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}
