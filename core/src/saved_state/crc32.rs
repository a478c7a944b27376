//! CRC-32 of ISO 3309 and IEEE 802.3 (polynomial 0x04C11DB7, reflected), byte by byte.

/// Remainders of all bytes.
const TABLE: [u32; 256] = table();

const fn table() -> [u32; 256] {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut rest, mut bit) = (byte as u32, 0);
        while bit < 8 {
            rest = if rest & 1 == 1 { (rest >> 1) ^ 0xEDB8_8320 } else { rest >> 1 };
            bit += 1;
        }
        table[byte] = rest;
        byte += 1;
    }
    table
}

/// The sum of bytes.
pub(super) fn crc32(bytes: &[u8]) -> u32 {
    let next = |sum: u32, byte: &u8| (sum >> 8) ^ TABLE[usize::from(sum as u8 ^ byte)];
    !bytes.iter().fold(u32::MAX, next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_sums() {
        // The check value of the catalog of CRC algorithms (CRC-32/ISO-HDLC), and what other programs give for the empty
        // text, one zero byte and `a`.
        for (text, sum) in
            [(&b"123456789"[..], 0xCBF4_3926), (b"", 0), (b"\0", 0xD202_EF8D), (b"a", 0xE8B7_BE43)]
        {
            assert_eq!(crc32(text), sum, "{text:?}");
        }
    }
}
