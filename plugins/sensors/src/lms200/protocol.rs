//! The telegrams of the LMS 2xx family: bytes to meaning and back, without a port.
//!
//! Source: SICK, *Telegrams for Configuring and Operating the LMS 2xx* (telegram listing), chapters 3 to 10. The widely
//! published telegrams and their checksums are the test vectors.

mod answer;
mod checksum;
mod command;
mod configuration;
mod frame;
mod line_speed;
mod measured;
mod mode;
mod reading;
mod status;

pub use answer::{BadTelegram, Reply, Telegram};
pub use checksum::checksum;
pub use command::{Command, Variant};
pub use configuration::Configuration;
pub use frame::{
    ACK, DEVICE_TO_HOST, Decoder, HOST_TO_DEVICE, MOST_LEN, NAK, OVERHEAD, STX, Tally, Token, encode,
};
pub use line_speed::LineSpeed;
pub use measured::{CountUnit, Indices, Measured};
pub use mode::{FACTORY_PASSWORD, IndexRange, Mode};
pub use reading::{MeasuringMode, Reading};
pub use status::{Severity, StatusByte, StatusReport};

#[cfg(test)]
mod tests;
