//! Measured values as the device sends them: a word that says how many and of what kind, then a word for each.

use super::BadTelegram;

/// Unit of the distances of a telegram.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CountUnit {
    /// 10 mm.
    Centimeters,
    /// 1 mm.
    Millimeters,
    /// 100 mm.
    Decimeters,
}

impl CountUnit {
    /// Meters of one count.
    pub fn step_m(self) -> f64 {
        match self {
            Self::Centimeters => 0.01,
            Self::Millimeters => 0.001,
            Self::Decimeters => 0.1,
        }
    }

    /// Counts in a meter.
    pub fn per_meter(self) -> f64 {
        match self {
            Self::Centimeters => 100.0,
            Self::Millimeters => 1000.0,
            Self::Decimeters => 10.0,
        }
    }
}

/// Real-time indices, when the configuration asks for them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Indices {
    /// Counts scans.
    pub scan: u8,
    /// Counts telegrams.
    pub telegram: u8,
}

/// The values of a telegram, from right to left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Measured {
    /// Unit of the distances.
    pub unit: CountUnit,
    /// Number of a partial scan: its first bearing is so many quarters of a degree further.
    pub partial: Option<u8>,
    /// Distances with their flags.
    pub words: Vec<u16>,
    /// Real-time indices.
    pub indices: Option<Indices>,
}

/// Bits of the first word. Published drivers mask the count with 0x3FFF or 0x01FF, which is wrong: it has ten bits.
const COUNT: u16 = 0x03FF;
const IS_PARTIAL: u16 = 1 << 13;

impl Measured {
    pub(super) fn write(&self, payload: &mut Vec<u8>) {
        let unit = match self.unit {
            CountUnit::Centimeters => 0u16,
            CountUnit::Millimeters => 1 << 14,
            CountUnit::Decimeters => 2 << 14,
        };
        let partial = self.partial.map_or(0, |number| IS_PARTIAL | u16::from(number & 0b11) << 11);
        payload.extend((unit | partial | (self.words.len() as u16 & COUNT)).to_le_bytes());
        payload.extend(self.words.iter().flat_map(|word| word.to_le_bytes()));
        payload.extend(self.indices.iter().flat_map(|indices| [indices.scan, indices.telegram]));
    }

    pub(super) fn read(bytes: &[u8]) -> Result<Self, BadTelegram> {
        let Some((&head, rest)) = bytes.split_first_chunk::<2>() else { return Err(BadTelegram::Length) };
        let head = u16::from_le_bytes(head);
        let n_words = usize::from(head & COUNT);
        let (words, rest) = rest.split_at_checked(2 * n_words).ok_or(BadTelegram::Length)?;
        let indices = match *rest {
            [] => None,
            [scan, telegram] => Some(Indices { scan, telegram }),
            _ => return Err(BadTelegram::Length),
        };
        let unit = match head >> 14 {
            0 => CountUnit::Centimeters,
            1 => CountUnit::Millimeters,
            2 => CountUnit::Decimeters,
            _ => return Err(BadTelegram::Unit),
        };
        let partial = (head & IS_PARTIAL != 0).then_some((head >> 11 & 0b11) as u8);
        let words = words.as_chunks().0.iter().map(|word| u16::from_le_bytes(*word)).collect();
        Ok(Self { unit, partial, words, indices })
    }
}
