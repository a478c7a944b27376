//! Fields of a line: words and whole numbers between single spaces.

use std::str::{FromStr, Split};

use rumbo_core::frames::Twist;

/// Why a line with a right checksum is not understood.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum BadLine {
    /// A word that this version does not know: of a later one.
    #[error("`{0}` is not known")]
    Unknown(String),
    /// A field is missing, or one too many.
    #[error("`{0}` has the wrong number of fields")]
    Count(&'static str),
    /// A field is no number, or none that may be.
    #[error("`{word}` has `{field}` where it should have {expected}")]
    Field {
        /// The first word of the line.
        word: &'static str,
        /// What stands there.
        field: String,
        /// What should.
        expected: &'static str,
    },
}

/// Meters, radians and their rates go over the line in millionths.
const MILLIONTHS: f64 = 1e6;

/// In millionths; what is too large for the line is cut.
pub(super) fn millionths(value: f64) -> i64 {
    (value * MILLIONTHS).round() as i64
}

/// The fields behind the first word.
pub(super) struct Fields<'a> {
    word: &'static str,
    rest: Split<'a, char>,
}

impl<'a> Fields<'a> {
    /// First word and the rest.
    pub fn of(text: &'a str) -> (&'a str, Split<'a, char>) {
        let mut rest = text.split(' ');
        (rest.next().unwrap_or_default(), rest)
    }

    pub fn new(word: &'static str, rest: Split<'a, char>) -> Self {
        Self { word, rest }
    }

    pub fn text(&mut self) -> Result<&'a str, BadLine> {
        self.rest.next().ok_or(BadLine::Count(self.word))
    }

    pub fn number<T: FromStr>(&mut self, expected: &'static str) -> Result<T, BadLine> {
        let (word, field) = (self.word, self.text()?);
        field.parse().map_err(|_| BadLine::Field { word, field: field.to_owned(), expected })
    }

    /// A number of so many at the most.
    pub fn at_most(&mut self, most: u32, expected: &'static str) -> Result<u32, BadLine> {
        let word = self.word;
        let number = self.number(expected)?;
        let wrong = || BadLine::Field { word, field: format!("{number}"), expected };
        if number <= most { Ok(number) } else { Err(wrong()) }
    }

    /// Meters or radians from millionths of them.
    pub fn length(&mut self, expected: &'static str) -> Result<f64, BadLine> {
        self.number::<i64>(expected).map(|micro| micro as f64 / MILLIONTHS)
    }

    pub fn flag(&mut self) -> Result<bool, BadLine> {
        self.at_most(1, "0 or 1").map(|flag| flag == 1)
    }

    pub fn twist(&mut self) -> Result<Twist, BadLine> {
        Ok(Twist {
            forward_m_s: self.length("a speed in um/s")?,
            left_m_s: self.length("a speed in um/s")?,
            turn_rad_s: self.length("a turn in urad/s")?,
        })
    }

    /// There is nothing more.
    pub fn end(mut self) -> Result<(), BadLine> {
        self.rest.next().map_or(Ok(()), |_| Err(BadLine::Count(self.word)))
    }
}

pub(super) fn twist_text(twist: &Twist) -> String {
    let Twist { forward_m_s, left_m_s, turn_rad_s } = *twist;
    format!("{} {} {}", millionths(forward_m_s), millionths(left_m_s), millionths(turn_rad_s))
}
