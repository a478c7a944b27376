//! One table: comments, and rows of numbers.

use std::path::{Path, PathBuf};

use super::error::MrclamError;
use crate::log_file::lines::{LONGEST_LINE, Line, Lines};
use crate::log_file::words::{Words, shown};
use crate::log_file::{Damage, FaultKind, LineFault, Tally};

/// A row with the number of its line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Row<T> {
    pub line: u64,
    pub told: T,
}

/// What could be read of a file.
#[derive(Debug)]
pub(crate) struct Table<T> {
    pub path: PathBuf,
    pub rows: Vec<Row<T>>,
    pub tally: Tally,
}

/// The table of this name in a folder, plain or else gzip.
pub(crate) fn find(folder: &Path, name: &str) -> Result<PathBuf, MrclamError> {
    if !folder.is_dir() {
        return Err(MrclamError::NoFolder { folder: folder.to_owned() });
    }
    let names = [name.to_owned(), format!("{name}.gz")];
    let found = names.into_iter().map(|name| folder.join(name)).find(|path| path.is_file());
    found.ok_or_else(|| MrclamError::Missing { folder: folder.to_owned(), name: name.to_owned() })
}

/// Reads a whole table; `parse` takes the words of one row.
pub(crate) fn read<T>(
    path: PathBuf,
    message: &'static str,
    parse: impl Fn(&mut Words<'_>) -> Result<T, LineFault>,
) -> Result<Table<T>, MrclamError> {
    let mut lines = Lines::open(&path)?;
    let (mut rows, mut tally) = (Vec::new(), Tally::default());
    loop {
        let line = lines.next();
        match line {
            Line::Whole | Line::Unfinished => {
                let is_blank =
                    lines.bytes.trim_ascii().is_empty() || lines.bytes.trim_ascii().starts_with(b"#");
                if is_blank {
                    continue;
                }
                // A cut through the last number of a row goes unseen; so a row without an end is not trusted.
                if line == Line::Unfinished {
                    let found = "the last line has no end".to_owned();
                    tally.damage = Some(Damage { line: lines.number, is_truncated: true, found });
                    continue;
                }
                match row(Words::new(lines.number, &lines.bytes).of(message), &parse) {
                    Ok(told) => rows.push(Row { line: lines.number, told }),
                    Err(fault) => tally.count(&fault),
                }
            }
            Line::TooLong => tally.count(&LineFault {
                line: lines.number,
                kind: FaultKind::LineTooLong,
                field: message.to_owned(),
                found: format!("longer than {LONGEST_LINE} bytes"),
                expected: "a row of numbers".to_owned(),
            }),
            Line::Damaged(damage) => {
                tally.damage = Some(damage);
                break;
            }
            Line::End => break,
        }
    }
    Ok(Table { path, rows, tally })
}

fn row<T>(
    mut words: Words<'_>,
    parse: impl Fn(&mut Words<'_>) -> Result<T, LineFault>,
) -> Result<T, LineFault> {
    let told = parse(&mut words)?;
    match words.next() {
        None => Ok(told),
        Some(word) => {
            Err(words.fault(FaultKind::CountDiffers, "the row", shown(word), "the end of the line"))
        }
    }
}

/// A number of a subject or a bar code.
pub(crate) fn whole(words: &mut Words<'_>, field: &str) -> Result<u32, LineFault> {
    let value = words.number(field)?;
    if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
        return Ok(value as u32);
    }
    let expected = "a whole number of at least 0";
    Err(words.fault(FaultKind::OutOfRange, field, value.to_string(), expected))
}

/// A number that cannot be negative.
pub(crate) fn not_negative(words: &mut Words<'_>, field: &str) -> Result<f64, LineFault> {
    let value = words.number(field)?;
    if value >= 0.0 {
        return Ok(value);
    }
    Err(words.fault(FaultKind::OutOfRange, field, value.to_string(), "a number of at least 0"))
}

impl<T> Table<T> {
    /// Its name, for people.
    pub fn name(&self) -> String {
        self.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
    }

    /// The table, if there is anything in it.
    pub fn with_rows(self, expected: &'static str) -> Result<Self, MrclamError> {
        if !self.rows.is_empty() {
            return Ok(self);
        }
        let why =
            self.tally.sentences().into_iter().next().map_or_else(String::new, |why| format!(" ({why})"));
        Err(MrclamError::Empty { path: self.path, why, expected })
    }

    /// The table, if every line of it was read.
    pub fn whole(self, expected: &'static str) -> Result<Self, MrclamError> {
        if let Some(damage) = self.tally.damage {
            return Err(MrclamError::Damaged { path: self.path, damage });
        }
        let first = self.tally.faults.values().map(|count| &count.first).min_by_key(|fault| fault.line);
        if let Some(fault) = first {
            return Err(MrclamError::Line { path: self.path, fault: fault.clone() });
        }
        self.with_rows(expected)
    }

    /// What people should know, with the name of the file.
    pub fn sentences(&self) -> Vec<String> {
        let name = self.name();
        self.tally.sentences().into_iter().map(|sentence| format!("{name}: {sentence}")).collect()
    }
}
