//! The configuration block, which the device keeps without power.

use super::{CountUnit, MeasuringMode};

/// Places in the block.
const AVAILABILITY: usize = 4;
const MEASURING_MODE: usize = 5;
const UNIT: usize = 6;

/// The block as the device sent it. Older firmware has a shorter one, so what is written back has the length of what was
/// read, and differs in the wanted bytes only.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Configuration {
    bytes: Vec<u8>,
}

impl Configuration {
    /// A block, if it is long enough to hold the unit.
    pub fn of_bytes(bytes: &[u8]) -> Option<Self> {
        (bytes.len() > UNIT).then(|| Self { bytes: bytes.to_vec() })
    }

    /// A block with centimeters and measuring mode 0; real devices leave the factory with much the same.
    pub fn factory() -> Self {
        let mut bytes = vec![0, 0, 0x46, 0, 0, 0, 0, 0, 0, 2, 2];
        bytes.resize(34, 0);
        Self { bytes }
    }

    /// All of it.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Unit of distances.
    pub fn unit(&self) -> Option<CountUnit> {
        match self.byte(UNIT) {
            0 => Some(CountUnit::Centimeters),
            1 => Some(CountUnit::Millimeters),
            _ => None,
        }
    }

    /// How values share their bits between distance and flags.
    pub fn measuring_mode(&self) -> Option<MeasuringMode> {
        MeasuringMode::of_code(self.byte(MEASURING_MODE))
    }

    /// Scans end with their index bytes.
    pub fn sends_indices(&self) -> bool {
        self.byte(AVAILABILITY) & 0b10 != 0
    }

    /// The same block with another unit and measuring mode; `unit` of 100 mm cannot be configured and leaves it.
    pub fn with(&self, unit: CountUnit, mode: MeasuringMode) -> Self {
        let mut bytes = self.bytes.clone();
        let unit = match unit {
            CountUnit::Centimeters => Some(0),
            CountUnit::Millimeters => Some(1),
            CountUnit::Decimeters => None,
        };
        let wanted = [(UNIT, unit), (MEASURING_MODE, Some(mode.code()))];
        for (idx, value) in wanted {
            if let (Some(byte), Some(value)) = (bytes.get_mut(idx), value) {
                *byte = value;
            }
        }
        Self { bytes }
    }

    fn byte(&self, idx: usize) -> u8 {
        self.bytes.get(idx).copied().unwrap_or(0)
    }
}
