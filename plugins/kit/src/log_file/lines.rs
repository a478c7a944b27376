//! The lines of a file, plain or gzip, with a bound on what one line may cost.

use std::fs::File;
use std::io::{BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::error::{Damage, LogError};

/// A longer line is not text, bytes.
pub(crate) const LONGEST_LINE: u64 = 16 << 20;

/// First bytes of every gzip file (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// Lines one after the other; the last one read is in `bytes`.
pub(crate) struct Lines {
    input: Box<dyn BufRead + Send>,
    /// The line without its end.
    pub bytes: Vec<u8>,
    /// Its number, from 1.
    pub number: u64,
    /// Bytes of text so far.
    pub n_bytes: u64,
    pending: Option<Damage>,
}

impl std::fmt::Debug for Lines {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Lines({})", self.number)
    }
}

/// What came of asking for a line.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Line {
    /// There is one.
    Whole,
    /// There is one, but the file ends inside it or it has no line end.
    Unfinished,
    /// One was jumped over: it is too long.
    TooLong,
    /// There is none.
    End,
    /// The file cannot be read any further.
    Damaged(Damage),
}

impl Lines {
    const BUFFER: usize = 1 << 17;

    /// Opens a file and looks whether it is gzip.
    pub fn open(path: &Path) -> Result<Lines, LogError> {
        let unreadable = |source| LogError::Unreadable { path: path.to_owned(), source };
        if path.is_dir() {
            return Err(LogError::Folder { path: path.to_owned() });
        }
        let mut file = BufReader::with_capacity(Self::BUFFER, File::open(path).map_err(unreadable)?);
        let start = file.fill_buf().map_err(unreadable)?;
        if start.is_empty() {
            return Err(LogError::Empty { path: path.to_owned() });
        }
        let input: Box<dyn BufRead + Send> = if start.starts_with(&GZIP) {
            Box::new(BufReader::with_capacity(Self::BUFFER, MultiGzDecoder::new(file)))
        } else {
            Box::new(file)
        };
        Ok(Lines { input, bytes: Vec::with_capacity(1 << 12), number: 0, n_bytes: 0, pending: None })
    }

    /// Reads the next line into `bytes`.
    pub fn next(&mut self) -> Line {
        if let Some(damage) = self.pending.take() {
            return Line::Damaged(damage);
        }
        self.bytes.clear();
        match self.read_part() {
            Ok(_) if self.bytes.is_empty() => return Line::End,
            Ok(_) => self.number += 1,
            Err(error) => {
                self.number += 1;
                let damage = self.damage(&error);
                if self.bytes.is_empty() {
                    return Line::Damaged(damage);
                }
                self.pending = Some(damage);
                return Line::Unfinished;
            }
        }
        if self.bytes.last() == Some(&b'\n') {
            self.bytes.pop();
            return Line::Whole;
        }
        if self.bytes.len() as u64 >= LONGEST_LINE { self.skip_line() } else { Line::Unfinished }
    }

    fn read_part(&mut self) -> std::io::Result<usize> {
        let n = self.input.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.bytes)?;
        self.n_bytes += n as u64;
        Ok(n)
    }

    /// Jumps over the rest of a line, keeping no more than one part of it at a time.
    fn skip_line(&mut self) -> Line {
        loop {
            self.bytes.clear();
            match self.read_part() {
                Ok(_) if self.bytes.is_empty() || self.bytes.last() == Some(&b'\n') => break,
                Ok(_) => {}
                Err(error) => {
                    self.pending = Some(self.damage(&error));
                    break;
                }
            }
        }
        // A line without end must not keep its memory either.
        self.bytes = Vec::with_capacity(1 << 12);
        Line::TooLong
    }

    fn damage(&self, error: &std::io::Error) -> Damage {
        let is_truncated = error.kind() == ErrorKind::UnexpectedEof;
        let found = if is_truncated { "the gzip stream ends early".to_owned() } else { error.to_string() };
        Damage { line: self.number.max(1), is_truncated, found }
    }
}
