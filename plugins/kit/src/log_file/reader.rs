//! From the lines of a file to records.

use std::path::{Path, PathBuf};

use rumbo_core::boundary::{Buffer, BufferPool};
use rumbo_core::frames::Pose2;
use rumbo_core::time::Time;

use super::beam_rule::{BeamOverride, BeamRule};
use super::error::{Damage, FaultKind, LineFault, LogError};
use super::lines::{LONGEST_LINE, Line, Lines};
use super::record::{LaserSide, LogRecord, RecordedScan, Told};
use super::tally::{Count, Tally};
use super::words::{Words, shown};
use super::{carmen, wean_hall};

/// What the readers of lines share: room for numbers, and what was said before.
#[derive(Debug, Default)]
pub(super) struct Desk {
    pub known: BeamOverride,
    pub ranges_m: Vec<f32>,
    pub intensities: Vec<f32>,
    /// The pose of the graph at which the next scan was taken.
    pub vertex: Option<Pose2>,
    guessed: Option<Count<usize>>,
    pool: BufferPool<f32>,
}

impl Desk {
    /// The scan whose ranges were just read.
    pub fn scan(
        &mut self,
        side: LaserSide,
        stamp: Time,
        rule: &BeamRule,
        odom_from_base: Pose2,
    ) -> RecordedScan {
        rule.open(&mut self.ranges_m);
        let ranges_m = pooled(&mut self.pool, &self.ranges_m);
        let BeamRule { first_bearing_rad, bearing_step_rad, max_range_m, .. } = *rule;
        RecordedScan {
            stamp,
            side,
            first_bearing_rad,
            bearing_step_rad,
            max_range_m,
            ranges_m,
            intensities: Buffer::empty(),
            odom_from_base,
            twist: None,
            map_from_base: odom_from_base,
        }
    }

    /// The remissions that were just read.
    pub fn intensities(&mut self) -> Buffer<f32> {
        pooled(&mut self.pool, &self.intensities)
    }

    pub fn note_guess(&mut self, rule: &BeamRule, n_beams: usize) {
        if rule.is_guess {
            self.guessed.get_or_insert(Count { n: 0, first: n_beams }).n += 1;
        }
    }
}

fn pooled(pool: &mut BufferPool<f32>, values: &[f32]) -> Buffer<f32> {
    let mut buffer = pool.take(values.len());
    buffer.make_mut().copy_from_slice(values);
    buffer
}

/// Reads a log line by line, however long it is: an iterator over records and over lines that are none.
#[derive(Debug)]
pub struct LogReader {
    path: PathBuf,
    lines: Lines,
    desk: Desk,
    tally: Tally,
    first: Option<Result<LogRecord, LineFault>>,
    n_records: u64,
    is_over: bool,
}

impl LogReader {
    /// So many lines without a record at the beginning are no log: parameters and comments are records, too.
    const MOST_LINES_BEFORE_FIRST: u64 = 10_000;

    /// Opens a log and reads up to its first record.
    ///
    /// # Errors
    /// [`LogError`] for a file that is missing, a folder, empty, or without any record near its beginning.
    pub fn open(path: &Path, known: BeamOverride) -> Result<LogReader, LogError> {
        let (path, lines) = (path.to_owned(), Lines::open(path)?);
        let (desk, tally) = (Desk { known, ..Desk::default() }, Tally::default());
        let mut reader = LogReader { path, lines, desk, tally, first: None, n_records: 0, is_over: false };
        loop {
            match reader.read() {
                Some(Ok(record)) => {
                    reader.first = Some(Ok(record));
                    return Ok(reader);
                }
                Some(Err(_)) if reader.lines.number < Self::MOST_LINES_BEFORE_FIRST => {}
                _ => return Err(reader.no_records()),
            }
        }
    }

    /// The file that is read.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was skipped so far, and why.
    pub fn tally(&self) -> &Tally {
        &self.tally
    }

    /// Bytes of text read so far, after decompression.
    pub fn n_bytes(&self) -> u64 {
        self.lines.n_bytes
    }

    /// Takes the ranges of a scan that nobody needs any more.
    pub fn recycle(&mut self, buffer: Buffer<f32>) {
        self.desk.pool.recycle(buffer);
    }

    fn no_records(&self) -> LogError {
        let first = self.tally.faults.values().map(|count| &count.first).min_by_key(|fault| fault.line);
        let found = match (first, &self.tally.damage, self.tally.unknown.iter().next()) {
            (_, Some(damage), _) => damage.to_string(),
            (Some(fault), ..) => fault.to_string(),
            (None, None, Some((word, count))) => {
                format!("{} lines, line {} begins with {word}", self.lines.number, count.first)
            }
            (None, None, None) => format!("{} empty lines and comments", self.lines.number),
        };
        let expected =
            "a CARMEN log (FLASER, RLASER, ROBOTLASER1, ODOM, VERTEX2, PARAM) or a Wean Hall log (L, O)";
        LogError::NoRecords { path: self.path.clone(), found, expected }
    }

    /// The next record or faulty line; comments, empty lines and unknown messages are passed over.
    fn read(&mut self) -> Option<Result<LogRecord, LineFault>> {
        while !self.is_over {
            let line = self.lines.next();
            let read = match line {
                Line::Whole | Line::Unfinished => self.read_line(line == Line::Unfinished),
                Line::TooLong => Some(Err(LineFault {
                    line: self.lines.number,
                    kind: FaultKind::LineTooLong,
                    field: "the line".to_owned(),
                    found: format!("longer than {LONGEST_LINE} bytes"),
                    expected: "a line of text".to_owned(),
                })),
                Line::Damaged(damage) => self.end(Some(damage)),
                Line::End => self.end(None),
            };
            match read {
                Some(Err(fault)) => {
                    self.tally.count(&fault);
                    return Some(Err(fault));
                }
                Some(record) => return Some(record),
                // A file of another kind is not read to its end.
                None if self.n_records == 0 && self.lines.number >= Self::MOST_LINES_BEFORE_FIRST => {
                    return None;
                }
                None => {}
            }
        }
        None
    }

    fn end(&mut self, damage: Option<Damage>) -> Option<Result<LogRecord, LineFault>> {
        self.is_over = true;
        // What the file system or gzip says explains the half line before it.
        self.tally.damage = damage.or(self.tally.damage.take());
        None
    }

    fn read_line(&mut self, is_unfinished: bool) -> Option<Result<LogRecord, LineFault>> {
        let (line, mut words) = (self.lines.number, Words::new(self.lines.number, &self.lines.bytes));
        let name = words.next().filter(|name| !name.starts_with(b"#"))?;
        let told = match carmen::told(name, words.clone(), &mut self.desk) {
            Some(told) => Some(told),
            // The last number of these lines is the stamp: a cut through it would go unseen.
            None if is_unfinished => None,
            None => wean_hall::told(name, words, &mut self.desk),
        };
        self.tally.guessed.clone_from(&self.desk.guessed);
        match told {
            Some(Ok(told)) => {
                if let Told::Vertex { map_from_base, .. } = told {
                    self.desk.vertex = Some(map_from_base);
                }
                self.n_records += 1;
                Some(Ok(LogRecord { line, told }))
            }
            Some(Err(_)) | None if is_unfinished => {
                let found = match told {
                    Some(Err(fault)) => {
                        format!("{} is {}, expected {}", fault.field, fault.found, fault.expected)
                    }
                    _ => format!("it ends with {} and without a line end", shown(&self.lines.bytes)),
                };
                self.tally.damage = Some(Damage { line, is_truncated: true, found });
                None
            }
            Some(Err(fault)) => Some(Err(fault)),
            None => {
                let word = shown(name);
                self.tally.count_unknown(word, line);
                None
            }
        }
    }
}

impl Iterator for LogReader {
    type Item = Result<LogRecord, LineFault>;

    fn next(&mut self) -> Option<Self::Item> {
        self.first.take().or_else(|| self.read())
    }
}
