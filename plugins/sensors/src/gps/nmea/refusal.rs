//! Why a line is not used.

/// What is wrong with a line, or with a sentence whose checksum is right.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// Another sentence began, or the line was lost, before this one ended.
    #[error("cut off: another sentence began before this one ended")]
    CutOff,
    /// The end of a line whose beginning was lost, or something that is no NMEA at all.
    #[error("no sentence: the line has no `$`")]
    NoStart,
    /// No sentence is so long.
    #[error(
        "longer than any sentence: more than {} bytes without an end of line",
        super::sentences::MOST_BYTES
    )]
    TooLong,
    /// Two hexadecimal digits after a `*` must end it.
    #[error("checksum missing")]
    NoChecksum,
    /// Something came to harm on the way.
    #[error("checksum mismatch: computed {computed:02X}, received {received:02X}")]
    Checksum {
        /// That of the characters that have come.
        computed: u8,
        /// The one that has come.
        received: u8,
    },
    /// A sentence is printable ASCII and begins with talker and type.
    #[error("no sentence: expected `$`, talker and type in printable characters")]
    Form,
    /// It may mean something else by GGA.
    #[error("talker `{0}` is unknown, expected GP, GN, GL, GA or GB")]
    Talker(String),
    /// Fields may be empty, but not missing.
    #[error("{found} fields, expected 14")]
    FieldCount {
        /// How many there are.
        found: usize,
    },
    /// A field that is not what it must be.
    #[error("{field} is not as in NMEA 0183")]
    Field {
        /// Its name.
        field: &'static str,
    },
    /// A number that no place or time has.
    #[error("{field} out of range")]
    Range {
        /// Its name.
        field: &'static str,
    },
}
