//! The checksum of a telegram.

/// Generator polynomial of the telegram listing.
const GENERATOR: u16 = 0x8005;

/// The checksum over all bytes from the start byte to the last before the checksum.
///
/// The listing's own manner: bytes enter in pairs with the one before, so this is none of the catalog's CRC-16 variants
/// and no table of theirs gives it.
pub fn checksum(bytes: &[u8]) -> u16 {
    let (mut crc, mut previous) = (0u16, 0u8);
    for &byte in bytes {
        let carry = if crc & 0x8000 == 0 { 0 } else { GENERATOR };
        crc = (crc << 1) ^ carry ^ u16::from_be_bytes([previous, byte]);
        previous = byte;
    }
    crc
}
