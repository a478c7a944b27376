//! The texts that values come from, and places in them.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Which text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(u32);

impl SourceId {
    /// Defaults come from here: the program, not a text.
    pub const BUILT_IN: SourceId = SourceId(u32::MAX);
}

/// A piece of a text, in bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Origin {
    /// The text.
    pub source: SourceId,
    /// First byte.
    pub start: usize,
    /// Behind the last byte.
    pub end: usize,
}

impl Origin {
    /// The origin of defaults.
    pub const BUILT_IN: Origin = Origin { source: SourceId::BUILT_IN, start: 0, end: 0 };
}

/// What a text is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum SourceName {
    /// A file, as the user or an `include` wrote it.
    File(PathBuf),
    /// A `--set` argument.
    Set,
}

/// One text.
#[derive(Debug, Clone)]
pub struct Source {
    /// What it is called.
    pub name: SourceName,
    /// The text.
    pub text: Arc<str>,
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.name {
            SourceName::File(path) => write!(f, "{}", path.display()),
            SourceName::Set => write!(f, "--set {}", self.text),
        }
    }
}

/// All texts of a document, in the order in which they were read.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    texts: Vec<Source>,
}

impl Sources {
    /// Adds a text.
    pub fn add(&mut self, name: SourceName, text: &str) -> SourceId {
        self.texts.push(Source { name, text: text.into() });
        SourceId((self.texts.len() - 1) as u32)
    }

    /// The text; none for defaults.
    pub fn get(&self, id: SourceId) -> Option<&Source> {
        self.texts.get(id.0 as usize)
    }

    /// All texts.
    pub fn iter(&self) -> impl Iterator<Item = &Source> {
        self.texts.iter()
    }

    /// Line and column where the piece begins, both counted from 1, columns in characters.
    pub fn line_column(&self, origin: Origin) -> Option<(usize, usize)> {
        let text = &self.get(origin.source)?.text;
        let mut at = origin.start.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let before = &text[..at];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.bytes().filter(|byte| *byte == b'\n').count() + 1;
        Some((line, before[line_start..].chars().count() + 1))
    }

    /// Where a value comes from, in short: `office.toml:12`, `--set` or `default`.
    pub fn short(&self, origin: Origin) -> String {
        match (self.get(origin.source), self.line_column(origin)) {
            (Some(Source { name: SourceName::File(path), .. }), Some((line, _))) => {
                format!("{}:{line}", path.display())
            }
            (Some(_), _) => "--set".to_owned(),
            _ => "default".to_owned(),
        }
    }

    /// The file that was read first.
    pub fn main_file(&self) -> Option<&Path> {
        match &self.texts.first()?.name {
            SourceName::File(path) => Some(path),
            SourceName::Set => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_count_characters_from_one() {
        let mut sources = Sources::default();
        let source = sources.add(SourceName::File("a.toml".into()), "x = 1\nä = 'ö' # é\nz");
        let place = |start| sources.line_column(Origin { source, start, end: start });
        assert_eq!(place(0), Some((1, 1)));
        assert_eq!(place(5), Some((1, 6)), "the newline itself belongs to its line");
        assert_eq!(place(6), Some((2, 1)));
        assert_eq!(place(11), Some((2, 5)), "the two bytes of ä are one column");
        assert_eq!(place(7), Some((2, 1)), "inside a character is at the character");
        assert_eq!(place(9_999), Some((3, 2)), "behind the end is at the end");
        assert_eq!(sources.line_column(Origin::BUILT_IN), None);
    }

    #[test]
    fn short_names_say_file_and_line_or_the_argument() {
        let mut sources = Sources::default();
        let file = sources.add(SourceName::File("a.toml".into()), "x = 1\ny = 2");
        let set = sources.add(SourceName::Set, "x=3");
        assert_eq!(sources.short(Origin { source: file, start: 6, end: 7 }), "a.toml:2");
        assert_eq!(sources.short(Origin { source: set, start: 0, end: 1 }), "--set");
        assert_eq!(sources.short(Origin::BUILT_IN), "default");
    }
}
