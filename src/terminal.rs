//! People on standard error, data on standard output.

use crate::exit::Failure;
use serde::Serialize;
use std::io::{ErrorKind, IsTerminal, Write as _};
use std::path::Path;

/// The two ends of the terminal.
#[derive(Debug, Clone, Copy)]
pub struct Terminal {
    colors: bool,
    people: bool,
}

impl Terminal {
    /// `colors`: yes, no, or what the environment says (<https://no-color.org>).
    pub fn new(colors: Option<bool>) -> Terminal {
        let people = std::io::stderr().is_terminal();
        let refused = std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty())
            || std::env::var_os("TERM").is_some_and(|value| value == "dumb");
        Terminal { colors: colors.unwrap_or(people && !refused), people }
    }

    /// Colors are wanted.
    pub fn has_colors(&self) -> bool {
        self.colors
    }

    /// Somebody looks at standard error while it happens.
    pub fn has_people(&self) -> bool {
        self.people
    }

    /// A line for people.
    pub fn say(&self, line: impl AsRef<str>) {
        // Without standard error there is nobody to tell, and no reason to stop the robot.
        let _ = writeln!(std::io::stderr().lock(), "{}", line.as_ref());
    }

    /// What went wrong.
    pub fn error(&self, message: &str) {
        self.say(format!("{} {message}", self.bad("error:")));
    }

    /// Text in the color of success.
    pub fn good(&self, text: &str) -> String {
        self.paint("32;1", text)
    }

    /// Text in the color of trouble.
    pub fn bad(&self, text: &str) -> String {
        self.paint("31;1", text)
    }

    /// Heavy text.
    pub fn strong(&self, text: &str) -> String {
        self.paint("1", text)
    }

    /// Less important text.
    pub fn soft(&self, text: &str) -> String {
        self.paint("2", text)
    }

    fn paint(&self, code: &str, text: &str) -> String {
        if self.colors { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() }
    }

    /// Data for the next program.
    pub fn data(&self, text: &str) -> Result<(), Failure> {
        let mut out = std::io::stdout().lock();
        let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
        written.map_err(|error| match error.kind() {
            ErrorKind::BrokenPipe => Failure::NobodyReads,
            _ => Failure::Internal(format!("cannot write to standard output: {error}")),
        })
    }

    /// One JSON value for the next program, on lines that people can read.
    pub fn json(&self, value: &impl Serialize) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(value);
        let text = text.map_err(|error| Failure::Internal(format!("cannot write JSON: {error}")))?;
        self.data(&(text + "\n"))
    }
}

/// Writes a file and the folders above it.
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    make_folder_of(path)?;
    std::fs::write(path, bytes)
        .map_err(|error| Failure::Internal(format!("cannot write {}: {error}", path.display())))
}

/// Makes the folders above a file.
pub fn make_folder_of(path: &Path) -> Result<(), Failure> {
    let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty());
    parent
        .map_or(Ok(()), std::fs::create_dir_all)
        .map_err(|error| Failure::Internal(format!("cannot write {}: {error}", path.display())))
}
