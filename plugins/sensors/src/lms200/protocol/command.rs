//! What the host says.

use super::{Configuration, HOST_TO_DEVICE, IndexRange, Mode, encode};

/// Field of view and resolution in the device's own numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Variant {
    /// Degrees.
    pub field_deg: u16,
    /// Hundredths of a degree.
    pub resolution_centideg: u16,
}

impl Variant {
    /// All that the device can do. A quarter of a degree over 180 is not among them.
    pub const OFFERED: [Variant; 5] = [
        Variant { field_deg: 100, resolution_centideg: 100 },
        Variant { field_deg: 100, resolution_centideg: 50 },
        Variant { field_deg: 100, resolution_centideg: 25 },
        Variant { field_deg: 180, resolution_centideg: 100 },
        Variant { field_deg: 180, resolution_centideg: 50 },
    ];

    /// Values of a scan.
    pub fn n_values(self) -> usize {
        usize::from(self.field_deg) * 100 / usize::from(self.resolution_centideg.max(1)) + 1
    }

    /// Turns of the mirror for a scan: finer scans are interlaced from several.
    pub fn n_turns(self) -> u32 {
        100 / u32::from(self.resolution_centideg.max(1))
    }

    pub(super) fn to_bytes(self) -> [u8; 4] {
        IndexRange { first: self.field_deg, last: self.resolution_centideg }.to_bytes()
    }

    pub(super) fn of_bytes(bytes: [u8; 4]) -> Self {
        let IndexRange { first, last } = IndexRange::of_bytes(bytes);
        Self { field_deg: first, resolution_centideg: last }
    }
}

/// A command with its data.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Command {
    /// Start anew as after power-on.
    Reset,
    /// Change the operating mode.
    Switch(Mode),
    /// The values of one scan, in the mode on request.
    OneScan,
    /// Status report.
    Status,
    /// Stored errors.
    Errors,
    /// Operating hours and switch-on counter.
    Hours,
    /// The mean over so many scans.
    Mean(u8),
    /// Part of the values.
    Part(IndexRange),
    /// Type of the device.
    Type,
    /// Change field of view and resolution.
    Variant(Variant),
    /// Whether the speed of the line outlives a loss of power.
    KeepSpeed(u8),
    /// Read the configuration.
    ReadConfiguration,
    /// Write the configuration, in installation mode.
    WriteConfiguration(Configuration),
}

impl Command {
    /// The number of the command; that of its answer is greater by 0x80.
    pub fn code(&self) -> u8 {
        match self {
            Self::Reset => 0x10,
            Self::Switch(_) => 0x20,
            Self::OneScan => 0x30,
            Self::Status => 0x31,
            Self::Errors => 0x32,
            Self::Hours => 0x35,
            Self::Mean(_) => 0x36,
            Self::Part(_) => 0x37,
            Self::Type => 0x3A,
            Self::Variant(_) => 0x3B,
            Self::KeepSpeed(_) => 0x66,
            Self::ReadConfiguration => 0x74,
            Self::WriteConfiguration(_) => 0x77,
        }
    }

    /// Code and data.
    pub fn payload(&self) -> Vec<u8> {
        let mut payload = vec![self.code()];
        match self {
            Self::Switch(mode) => mode.write(&mut payload),
            Self::OneScan => payload.push(0x01),
            Self::Mean(n_scans) => payload.push(*n_scans),
            Self::Part(part) => payload.extend(part.to_bytes()),
            Self::Variant(variant) => payload.extend(variant.to_bytes()),
            Self::KeepSpeed(keep) => payload.push(*keep),
            Self::WriteConfiguration(configuration) => payload.extend(configuration.bytes()),
            _ => {}
        }
        payload
    }

    /// The whole telegram.
    pub fn to_bytes(&self) -> Vec<u8> {
        encode(HOST_TO_DEVICE, &self.payload())
    }

    /// The command of a payload, if there is such a command.
    pub fn of_payload(payload: &[u8]) -> Option<Self> {
        Some(match *payload {
            [0x10] => Self::Reset,
            [0x20, ref mode @ ..] => Self::Switch(Mode::read(mode)?),
            [0x30, 0x01] => Self::OneScan,
            [0x31] => Self::Status,
            [0x32] => Self::Errors,
            [0x35] => Self::Hours,
            [0x36, n_scans @ 2..=250] => Self::Mean(n_scans),
            [0x37, a, b, c, d] => Self::Part(IndexRange::of_bytes([a, b, c, d])),
            [0x3A] => Self::Type,
            [0x3B, a, b, c, d] => Self::Variant(Variant::of_bytes([a, b, c, d])),
            [0x66, keep] => Self::KeepSpeed(keep),
            [0x74] => Self::ReadConfiguration,
            [0x77, ref bytes @ ..] => Self::WriteConfiguration(Configuration::of_bytes(bytes)?),
            _ => return None,
        })
    }
}
