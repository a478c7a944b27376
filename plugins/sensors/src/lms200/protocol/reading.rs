//! What a value says: a distance with flags, or why there is none.

/// How the 16 bits of a value are shared between distance and flags.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeasuringMode {
    /// 13 bits; fields A and B, dazzle.
    FieldsAbDazzle,
    /// 13 bits; reflector level 0 to 7.
    Reflector8,
    /// 13 bits; fields A, B and C.
    FieldsAbc,
    /// 14 bits; reflector level 0 to 3.
    Reflector4,
    /// 14 bits; fields A and B.
    FieldsAb,
    /// 15 bits; reflector level 0 or 1.
    Reflector2,
    /// 15 bits; field A.
    FieldA,
    /// 16 bits.
    Distance,
    /// No distance at all: reflectivity.
    Reflectivity,
}

impl MeasuringMode {
    const CODES: [(Self, u8, u32); 9] = [
        (Self::FieldsAbDazzle, 0x00, 13),
        (Self::Reflector8, 0x01, 13),
        (Self::FieldsAbc, 0x02, 13),
        (Self::Reflector4, 0x03, 14),
        (Self::FieldsAb, 0x04, 14),
        (Self::Reflector2, 0x05, 15),
        (Self::FieldA, 0x06, 15),
        (Self::Distance, 0x0F, 16),
        (Self::Reflectivity, 0x3F, 0),
    ];

    /// In the configuration.
    pub fn code(self) -> u8 {
        Self::CODES.iter().find(|(mode, ..)| *mode == self).map_or(0, |(_, code, _)| *code)
    }

    /// The mode of a code of the configuration.
    pub fn of_code(code: u8) -> Option<Self> {
        Self::CODES.iter().find(|(_, known, _)| *known == code).map(|(mode, ..)| *mode)
    }

    /// Bits of the distance; 0 where there is no distance.
    pub fn distance_bits(self) -> u32 {
        Self::CODES.iter().find(|(mode, ..)| *mode == self).map_or(0, |(.., bits)| *bits)
    }

    /// The flags are the level of a reflector.
    pub fn has_reflector_level(self) -> bool {
        matches!(self, Self::Reflector8 | Self::Reflector4 | Self::Reflector2)
    }

    /// The largest count that is a distance.
    pub fn largest_count(self) -> u16 {
        self.mask().saturating_sub(9)
    }

    /// The flags of a value, moved to the lowest bits.
    pub fn flags(self, word: u16) -> u8 {
        word.checked_shr(self.distance_bits()).map_or(0, |flags| flags as u8)
    }

    /// What the distance of a value says.
    pub fn reading(self, word: u16) -> Reading {
        let count = word & self.mask();
        if count <= self.largest_count() {
            return Reading::Count(count);
        }
        match count & 0x000F {
            0x7 => Reading::NothingWithinReach,
            0xA => Reading::ChannelError,
            0xB => Reading::WeakSignal,
            0xD => Reading::Overflow,
            0xE => Reading::Dazzled,
            0xF => Reading::NotValid,
            _ => Reading::Reserved,
        }
    }

    /// The value that says this distance (in counts) with these flags; nothing within reach without a distance that can
    /// be said.
    pub fn word(self, count: Option<u16>, flags: u8) -> u16 {
        let nothing = self.mask().saturating_sub(8);
        let distance = count.filter(|count| *count <= self.largest_count()).unwrap_or(nothing);
        distance | u16::from(flags).checked_shl(self.distance_bits()).unwrap_or(0)
    }

    fn mask(self) -> u16 {
        match self.distance_bits() {
            0 => 0,
            bits => u16::MAX >> (16 - bits),
        }
    }
}

/// A distance or the reason why there is none. The codes are those of the listing for 13 bits (0x1FF7 to 0x1FFF), with
/// the higher bits set where there are more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reading {
    /// A distance in counts.
    Count(u16),
    /// Nothing came back from as far as the device sees: the way is clear that far.
    NothingWithinReach,
    /// Error when reading channel 1.
    ChannelError,
    /// Signal too weak against the noise.
    WeakSignal,
    /// The computation overflowed.
    Overflow,
    /// Dazzled.
    Dazzled,
    /// Not valid.
    NotValid,
    /// A code without meaning.
    Reserved,
}
