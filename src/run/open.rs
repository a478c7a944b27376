//! Shows a file in the program that the desktop has for it.

use std::io;
use std::path::Path;
use std::process::{Command, Stdio};

/// Asks the desktop to open a file, and does not wait for it.
pub fn open(path: &Path) -> io::Result<()> {
    let mut command = if cfg!(target_os = "macos") {
        Command::new("open")
    } else if cfg!(windows) {
        Command::new("explorer")
    } else {
        Command::new("xdg-open")
    };
    let path = std::path::absolute(path)?;
    command.arg(path).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().map(drop)
}
