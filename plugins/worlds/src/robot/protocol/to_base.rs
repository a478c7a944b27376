//! What the host says.

use std::fmt;

use rumbo_core::frames::Twist;

use super::fields::{BadLine, Fields, twist_text};

/// A line to the base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToBase {
    /// Begins a session, or asks again who is there.
    Hello {
        /// The version that the host speaks.
        version: u16,
    },
    /// A wanted velocity.
    Drive(Twist),
    /// The end of the session.
    Bye,
}

impl fmt::Display for ToBase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hello { version } => write!(f, "HELLO {version}"),
            Self::Drive(twist) => write!(f, "DRIVE {}", twist_text(twist)),
            Self::Bye => f.write_str("BYE"),
        }
    }
}

impl ToBase {
    /// What the text of a line means.
    pub fn parse(text: &str) -> Result<Self, BadLine> {
        let (word, rest) = Fields::of(text);
        let (read, fields) = match word {
            "HELLO" => {
                let mut fields = Fields::new("HELLO", rest);
                (Self::Hello { version: fields.number("a version")? }, fields)
            }
            "DRIVE" => {
                let mut fields = Fields::new("DRIVE", rest);
                (Self::Drive(fields.twist()?), fields)
            }
            "BYE" => (Self::Bye, Fields::new("BYE", rest)),
            other => return Err(BadLine::Unknown(other.to_owned())),
        };
        fields.end().map(|()| read)
    }
}
