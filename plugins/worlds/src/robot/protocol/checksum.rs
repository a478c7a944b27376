//! The checksum of a line.

/// CRC-16 with generator 0x1021 and start value 0xFFFF, highest bit first: in catalogs CRC-16/IBM-3740, often called
/// CCITT-FALSE. It finds every single flipped bit and every burst of up to 16 bits.
pub fn checksum(bytes: &[u8]) -> u16 {
    bytes.iter().fold(0xFFFF, |crc, byte| {
        (0..8).fold(
            crc ^ u16::from(*byte) << 8,
            |crc, _| {
                if crc & 0x8000 == 0 { crc << 1 } else { crc << 1 ^ 0x1021 }
            },
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The check value of the catalogs.
    #[test]
    fn the_nine_digits_have_the_published_checksum() {
        assert_eq!(checksum(b"123456789"), 0x29B1);
        assert_eq!(checksum(b""), 0xFFFF);
    }
}
