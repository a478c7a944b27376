//! NMEA 0183 as receivers send it: sentences with checksums, of which only GGA (the fix) is read.
//!
//! Bytes go through [`Sentences`], which finds and checks sentences however they are cut, and a sentence's fields
//! through [`Fix::of_fields`].

pub(crate) mod decoder;
mod fields;
mod fix;
mod refusal;
mod sentences;

pub use decoder::{Decoder, Heard, Tally};
pub use fields::{Axis, degrees, utc_s};
pub use fix::{Fix, Gga};
pub use refusal::Refusal;
pub use sentences::{Sentence, Sentences, checksum};
