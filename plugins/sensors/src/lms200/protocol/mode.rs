//! Operating modes: what command 0x20 switches to.

use super::LineSpeed;

/// Opens installation mode as the device leaves the factory.
pub const FACTORY_PASSWORD: [u8; 8] = *b"SICK_LMS";

/// Values of a scan by their numbers, which begin with 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct IndexRange {
    /// First value.
    pub first: u16,
    /// Last value.
    pub last: u16,
}

impl IndexRange {
    pub(super) fn to_bytes(self) -> [u8; 4] {
        let ([a, b], [c, d]) = (self.first.to_le_bytes(), self.last.to_le_bytes());
        [a, b, c, d]
    }

    pub(super) fn of_bytes([a, b, c, d]: [u8; 4]) -> Self {
        Self { first: u16::from_le_bytes([a, b]), last: u16::from_le_bytes([c, d]) }
    }
}

/// What the device shall do from now on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Configuration may be written; needs the password.
    Installation([u8; 8]),
    /// Diagnosis.
    Diagnosis,
    /// Sends the smallest values: codes 0x20 to 0x23.
    SmallestValues(u8),
    /// Sends all values all the time.
    Continuous,
    /// Sends values when asked: how the device wakes up, and how every continuous output is ended.
    OnRequest,
    /// Sends means over so many scans.
    Means(u8),
    /// Sends part of the values all the time.
    Part(IndexRange),
    /// Sends means of part of the values.
    MeansOfPart(u8, IndexRange),
    /// Sends part of the values with the flags of the fields.
    PartWithFields(IndexRange),
    /// Sends every turn of the mirror as soon as it is measured.
    Partials,
    /// Changes the speed of the line after the answer.
    Speed(LineSpeed),
    /// Sends values and reflectivity; the LMS 200 cannot.
    WithReflectivity(IndexRange),
}

impl Mode {
    /// The number of the mode.
    pub fn code(self) -> u8 {
        match self {
            Self::Installation(_) => 0x00,
            Self::Diagnosis => 0x10,
            Self::SmallestValues(code) => code,
            Self::Continuous => 0x24,
            Self::OnRequest => 0x25,
            Self::Means(_) => 0x26,
            Self::Part(_) => 0x27,
            Self::MeansOfPart(..) => 0x28,
            Self::PartWithFields(_) => 0x29,
            Self::Partials => 0x2A,
            Self::Speed(speed) => speed.mode_code(),
            Self::WithReflectivity(_) => 0x50,
        }
    }

    pub(super) fn write(self, payload: &mut Vec<u8>) {
        payload.push(self.code());
        match self {
            Self::Installation(password) => payload.extend(password),
            Self::Means(n_scans) => payload.push(n_scans),
            Self::MeansOfPart(n_scans, part) => {
                payload.push(n_scans);
                payload.extend(part.to_bytes());
            }
            Self::Part(part) | Self::PartWithFields(part) | Self::WithReflectivity(part) => {
                payload.extend(part.to_bytes());
            }
            _ => {}
        }
    }

    pub(super) fn read(bytes: &[u8]) -> Option<Self> {
        Some(match *bytes {
            [0x00, ref password @ ..] => Self::Installation(password.try_into().ok()?),
            [0x10] => Self::Diagnosis,
            [code @ 0x20..=0x23] => Self::SmallestValues(code),
            [0x24] => Self::Continuous,
            [0x25] => Self::OnRequest,
            [0x26, n_scans] => Self::Means(n_scans),
            [0x27, a, b, c, d] => Self::Part(IndexRange::of_bytes([a, b, c, d])),
            [0x28, n_scans, a, b, c, d] => Self::MeansOfPart(n_scans, IndexRange::of_bytes([a, b, c, d])),
            [0x29, a, b, c, d] => Self::PartWithFields(IndexRange::of_bytes([a, b, c, d])),
            [0x2A] => Self::Partials,
            [0x50, a, b, c, d] => Self::WithReflectivity(IndexRange::of_bytes([a, b, c, d])),
            [code] => Self::Speed(LineSpeed::ALL.into_iter().find(|speed| speed.mode_code() == code)?),
            _ => return None,
        })
    }
}
