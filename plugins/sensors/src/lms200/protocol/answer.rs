//! What the device says.

use super::{Configuration, DEVICE_TO_HOST, IndexRange, Measured, StatusByte, StatusReport, Variant, encode};

/// An answer, or what the device says unasked.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reply {
    /// 0x90: the device woke up; its type.
    PowerOn(String),
    /// 0x91: the reset begins.
    ResetBegins,
    /// 0x92: there is no such command, or not now.
    NotAccepted,
    /// 0xA0: result of a change of mode: 0 accepted, 1 wrong password, 2 fault of the device.
    ModeSwitched(u8),
    /// 0xB0: a scan.
    Scan(Measured),
    /// 0xB1: status report.
    Status(StatusReport),
    /// 0xB2: stored errors: type and number.
    Errors(Vec<[u8; 2]>),
    /// 0xB5: operating hours and switch-on counter, as they are.
    Hours(Vec<u8>),
    /// 0xB6: mean over so many scans.
    Mean(u8, Measured),
    /// 0xB7: part of a scan.
    Part(IndexRange, Measured),
    /// 0xBA: type of the device.
    Type(String),
    /// 0xBB: whether the variant was accepted, and the one in force.
    Variant(bool, Variant),
    /// 0xBF: mean of a part over so many scans.
    MeanOfPart(u8, IndexRange, Measured),
    /// 0xE6: result of the order to keep the speed.
    SpeedKept(u8),
    /// 0xF4: the configuration.
    Configuration(Configuration),
    /// 0xF7: whether it was written, and the one in force.
    ConfigurationWritten(bool, Configuration),
}

/// Why a payload with a right checksum is no answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum BadTelegram {
    /// Unknown code.
    #[error("no answer has the code {0:#04x}")]
    Code(u8),
    /// Too short, or not as long as it says.
    #[error("the telegram is not as long as it says")]
    Length,
    /// A unit that does not exist.
    #[error("the unit of the distances is none that the device has")]
    Unit,
}

/// An answer with the state of the device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Telegram {
    /// What it says.
    pub reply: Reply,
    /// How it is.
    pub status: StatusByte,
}

impl Telegram {
    /// The telegram of a payload.
    pub fn of_payload(payload: &[u8]) -> Result<Self, BadTelegram> {
        let [code, data @ .., status] = payload else { return Err(BadTelegram::Length) };
        Ok(Self { reply: Reply::read(*code, data)?, status: StatusByte(*status) })
    }

    /// Code, data and status.
    pub fn payload(&self) -> Vec<u8> {
        let mut payload = vec![self.reply.code()];
        self.reply.write(&mut payload);
        payload.push(self.status.0);
        payload
    }

    /// The whole telegram.
    pub fn to_bytes(&self) -> Vec<u8> {
        encode(DEVICE_TO_HOST, &self.payload())
    }
}

impl Reply {
    /// The number of the answer: that of the command and 0x80, with three exceptions.
    pub fn code(&self) -> u8 {
        match self {
            Self::PowerOn(_) => 0x90,
            Self::ResetBegins => 0x91,
            Self::NotAccepted => 0x92,
            Self::ModeSwitched(_) => 0xA0,
            Self::Scan(_) => 0xB0,
            Self::Status(_) => 0xB1,
            Self::Errors(_) => 0xB2,
            Self::Hours(_) => 0xB5,
            Self::Mean(..) => 0xB6,
            Self::Part(..) => 0xB7,
            Self::Type(_) => 0xBA,
            Self::Variant(..) => 0xBB,
            Self::MeanOfPart(..) => 0xBF,
            Self::SpeedKept(_) => 0xE6,
            Self::Configuration(_) => 0xF4,
            Self::ConfigurationWritten(..) => 0xF7,
        }
    }

    fn write(&self, payload: &mut Vec<u8>) {
        match self {
            Self::ResetBegins | Self::NotAccepted => {}
            Self::PowerOn(text) | Self::Type(text) => payload.extend(text.bytes()),
            Self::ModeSwitched(result) | Self::SpeedKept(result) => payload.push(*result),
            Self::Scan(measured) => measured.write(payload),
            Self::Status(report) => payload.extend(report.bytes()),
            Self::Errors(errors) => payload.extend(errors.iter().flatten()),
            Self::Hours(bytes) => payload.extend(bytes),
            Self::Mean(n_scans, measured) => {
                payload.push(*n_scans);
                measured.write(payload);
            }
            Self::Part(part, measured) => {
                payload.extend(part.to_bytes());
                measured.write(payload);
            }
            Self::Variant(is_accepted, variant) => {
                payload.push(u8::from(*is_accepted));
                payload.extend(variant.to_bytes());
            }
            Self::MeanOfPart(n_scans, part, measured) => {
                payload.push(*n_scans);
                payload.extend(part.to_bytes());
                measured.write(payload);
            }
            Self::Configuration(configuration) => payload.extend(configuration.bytes()),
            Self::ConfigurationWritten(is_accepted, configuration) => {
                payload.push(u8::from(*is_accepted));
                payload.extend(configuration.bytes());
            }
        }
    }

    fn read(code: u8, data: &[u8]) -> Result<Self, BadTelegram> {
        let configuration = |bytes: &[u8]| Configuration::of_bytes(bytes).ok_or(BadTelegram::Length);
        Ok(match (code, data) {
            (0x90, text) => Self::PowerOn(String::from_utf8_lossy(text).into_owned()),
            (0x91, []) => Self::ResetBegins,
            (0x92, []) => Self::NotAccepted,
            (0xA0, &[result]) => Self::ModeSwitched(result),
            (0xB0, measured) => Self::Scan(Measured::read(measured)?),
            (0xB1, report) => Self::Status(StatusReport::of_bytes(report)),
            (0xB2, pairs) => match pairs.as_chunks() {
                (pairs, []) => Self::Errors(pairs.to_vec()),
                _ => return Err(BadTelegram::Length),
            },
            (0xB5, bytes) => Self::Hours(bytes.to_vec()),
            (0xB6, [n_scans, measured @ ..]) => Self::Mean(*n_scans, Measured::read(measured)?),
            (0xB7, &[a, b, c, d, ref measured @ ..]) => {
                Self::Part(IndexRange::of_bytes([a, b, c, d]), Measured::read(measured)?)
            }
            (0xBA, text) => Self::Type(String::from_utf8_lossy(text).into_owned()),
            (0xBB, &[result, a, b, c, d]) => Self::Variant(result == 1, Variant::of_bytes([a, b, c, d])),
            (0xBF, &[n_scans, a, b, c, d, ref measured @ ..]) => {
                Self::MeanOfPart(n_scans, IndexRange::of_bytes([a, b, c, d]), Measured::read(measured)?)
            }
            (0xE6, &[result]) => Self::SpeedKept(result),
            (0xF4, bytes) => Self::Configuration(configuration(bytes)?),
            (0xF7, [result, bytes @ ..]) => Self::ConfigurationWritten(*result == 1, configuration(bytes)?),
            (0xA0 | 0x91 | 0x92 | 0xB6 | 0xB7 | 0xBB | 0xBF | 0xE6 | 0xF7, _) => {
                return Err(BadTelegram::Length);
            }
            (code, _) => return Err(BadTelegram::Code(code)),
        })
    }
}
