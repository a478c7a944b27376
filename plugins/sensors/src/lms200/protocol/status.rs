//! How the device is: the byte at the end of every telegram, and the report on request.

use super::{LineSpeed, MeasuringMode, Variant};

/// The last byte of every telegram of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StatusByte(pub u8);

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Nothing.
    Fine,
    /// Information.
    Information,
    /// Warning.
    Warning,
    /// Error.
    Error,
    /// Fatal error.
    Fatal,
}

impl StatusByte {
    /// A healthy LMS 200: no error, family 2 (LMS type 6).
    pub const HEALTHY: StatusByte = StatusByte(0x10);

    /// How bad it is; unknown codes are fatal.
    pub fn severity(self) -> Severity {
        match self.0 & 0b111 {
            0 => Severity::Fine,
            1 => Severity::Information,
            2 => Severity::Warning,
            3 => Severity::Error,
            _ => Severity::Fatal,
        }
    }

    /// Family of the device: 2 is LMS type 6, to which the LMS 200-30106 belongs.
    pub fn family(self) -> u8 {
        self.0 >> 3 & 0b11
    }

    /// The device has started anew.
    pub fn has_restarted(self) -> bool {
        self.0 & 1 << 5 != 0
    }

    /// Measured values are implausible.
    pub fn is_implausible(self) -> bool {
        self.0 & 1 << 6 != 0
    }

    /// The front window is dirty.
    pub fn is_polluted(self) -> bool {
        self.0 & 1 << 7 != 0
    }
}

/// The status report. Its length differs between versions: everything is looked up by its place, which counts from the
/// code of the answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StatusReport {
    /// From behind the code.
    bytes: Vec<u8>,
}

impl StatusReport {
    /// A report.
    pub fn of_bytes(bytes: &[u8]) -> Self {
        Self { bytes: bytes.to_vec() }
    }

    /// All of it, from behind the code.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Software version.
    pub fn version(&self) -> Option<String> {
        self.bytes.get(0..7).map(|text| String::from_utf8_lossy(text).trim_end().to_owned())
    }

    /// Number of the operating mode.
    pub fn mode_code(&self) -> Option<u8> {
        self.byte(8)
    }

    /// The device says that it is broken.
    pub fn is_defective(&self) -> Option<bool> {
        self.byte(9).map(|byte| byte != 0)
    }

    /// Measuring mode.
    pub fn measuring_mode(&self) -> Option<MeasuringMode> {
        self.byte(102).and_then(MeasuringMode::of_code)
    }

    /// Field of view and resolution in force.
    pub fn variant(&self) -> Option<Variant> {
        Some(Variant { field_deg: self.word(107)?, resolution_centideg: self.word(109)? })
    }

    /// Speed of the line.
    pub fn speed(&self) -> Option<LineSpeed> {
        let code = self.word(116)?;
        LineSpeed::ALL.into_iter().find(|speed| speed.status_code() == code)
    }

    /// 0 centimeters, 1 millimeters.
    pub fn unit_code(&self) -> Option<u8> {
        self.byte(122)
    }

    /// Puts bytes at a place, as far as the report reaches.
    pub fn put(&mut self, place: usize, bytes: &[u8]) {
        let places = self.bytes.iter_mut().skip(place.saturating_sub(1));
        places.zip(bytes).for_each(|(to, byte)| *to = *byte);
    }

    /// Puts the speed of the line into its place.
    pub fn put_speed(&mut self, speed: LineSpeed) {
        self.put(116, &speed.status_code().to_le_bytes());
    }

    fn byte(&self, place: usize) -> Option<u8> {
        self.bytes.get(place.checked_sub(1)?).copied()
    }

    fn word(&self, place: usize) -> Option<u16> {
        Some(u16::from_le_bytes([self.byte(place)?, self.byte(place + 1)?]))
    }
}
