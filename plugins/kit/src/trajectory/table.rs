//! Lines of numbers that are all read or refused, unlike those of a log.

use std::path::{Path, PathBuf};

use super::TrajectoryError;
use crate::log_file::lines::{Line, Lines};
use crate::log_file::{Count, Damage, FaultKind, LineFault};

/// The rows of a file: its lines but for comments and empty ones.
pub(crate) struct Table {
    path: PathBuf,
    lines: Lines,
    has_line_end: bool,
    not_finite: Option<Count<LineFault>>,
    damage: Option<Damage>,
}

/// A line with something in it.
pub(crate) struct Row<'a> {
    /// Its number, from 1.
    pub line: u64,
    /// The line without its end.
    pub words: &'a [u8],
}

impl Table {
    /// Opens a file; `expected` is what its lines should look like.
    pub fn open(path: &Path, expected: &str) -> Result<Table, TrajectoryError> {
        let lines = Lines::open(path).map_err(|error| TrajectoryError::of_lines(error, expected))?;
        Ok(Table { path: path.to_owned(), lines, has_line_end: true, not_finite: None, damage: None })
    }

    /// The next row.
    pub fn next(&mut self) -> Option<Row<'_>> {
        loop {
            match self.lines.next() {
                Line::Whole => self.has_line_end = true,
                Line::Unfinished => self.has_line_end = false,
                Line::TooLong => {
                    let found = "a line without end".to_owned();
                    self.damage = Some(Damage { line: self.lines.number, is_truncated: false, found });
                    return None;
                }
                Line::Damaged(damage) => {
                    self.damage = Some(damage);
                    return None;
                }
                Line::End => return None,
            }
            let words = self.lines.bytes.trim_ascii();
            if !words.is_empty() && !words.starts_with(b"#") {
                break;
            }
        }
        Some(Row { line: self.lines.number, words: self.lines.bytes.trim_ascii() })
    }

    /// What was read from the last row, unless it is not finite or cut off, which is noted; every other fault is an
    /// error.
    pub fn accept<T>(
        &mut self,
        read: Result<T, LineFault>,
        format: &'static str,
    ) -> Result<Option<T>, TrajectoryError> {
        match read {
            Ok(value) => Ok(Some(value)),
            Err(fault) if fault.kind == FaultKind::NotFinite => {
                self.not_finite.get_or_insert(Count { n: 0, first: fault }).n += 1;
                Ok(None)
            }
            Err(fault) if !self.has_line_end => {
                let found = format!("{} is {}", fault.field, fault.found);
                self.damage.get_or_insert(Damage { line: fault.line, is_truncated: true, found });
                Ok(None)
            }
            Err(fault) => Err(TrajectoryError::of_line(&self.path, fault, format)),
        }
    }

    /// A sentence for each thing that people should know.
    pub fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.damage.iter().map(ToString::to_string).collect();
        if let Some(Count { n, first }) = &self.not_finite {
            let lines = if *n == 1 { "line was" } else { "lines were" };
            notes.push(format!("{n} {lines} left out, first {first}"));
        }
        notes
    }

    /// Why there was no row at all.
    pub fn why_empty(&self) -> String {
        match &self.damage {
            Some(damage) => damage.to_string(),
            None => format!("{} lines, all of them empty or comments", self.lines.number),
        }
    }
}
