//! Common Data Representation, the encoding of ROS 2 messages: numbers aligned to their own size, sequences and texts
//! behind their length (OMG, *DDS Interoperability Wire Protocol* 2.5, section 10; XCDR version 1).
//!
//! The crates that do this, `cdr` and `cdr-encoding`, go through serde element by element; a scan of ours is one copy.

pub use super::cdr_writer::CdrWriter;

/// Bytes in front of the message that say how it is encoded.
pub(super) const HEADER: usize = 4;

/// Why a message cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CdrError {
    /// It ends too early.
    #[error("the message has {len} bytes, expected at least {wanted}")]
    Short {
        /// How long it is.
        len: usize,
        /// How long it would have to be.
        wanted: usize,
    },
    /// It is encoded in another way.
    #[error("the message says encoding {0:#06x}, expected plain CDR (0x0000 or 0x0001)")]
    Encoding(u16),
    /// A value that nobody knows.
    #[error("{field} is {found}, expected {expected}")]
    Value {
        /// Which field.
        field: &'static str,
        /// What it holds.
        found: String,
        /// What it should hold.
        expected: &'static str,
    },
}

/// Reads one message of either byte order.
#[derive(Debug, Clone)]
pub struct CdrReader<'a> {
    bytes: &'a [u8],
    at: usize,
    is_little: bool,
}

macro_rules! read_numbers {
    ($($name:ident: $t:ty),*) => { $(
        /// A number.
        pub fn $name(&mut self) -> Result<$t, CdrError> {
            let bytes = self.number()?;
            Ok(if self.is_little { <$t>::from_le_bytes(bytes) } else { <$t>::from_be_bytes(bytes) })
        }
    )* };
}

impl<'a> CdrReader<'a> {
    /// A message with its encapsulation header.
    pub fn new(message: &'a [u8]) -> Result<CdrReader<'a>, CdrError> {
        let short = CdrError::Short { len: message.len(), wanted: HEADER };
        let (header, bytes) = message.split_first_chunk::<HEADER>().ok_or(short)?;
        let encoding = u16::from_be_bytes([header[0], header[1]]);
        match encoding {
            0 | 1 => Ok(CdrReader { bytes, at: 0, is_little: encoding == 1 }),
            other => Err(CdrError::Encoding(other)),
        }
    }

    fn take(&mut self, len: usize) -> Result<&'a [u8], CdrError> {
        let wanted = self.at.saturating_add(len);
        let short = CdrError::Short { len: HEADER + self.bytes.len(), wanted: wanted.saturating_add(HEADER) };
        let taken = self.bytes.get(self.at..wanted).ok_or(short)?;
        self.at = wanted;
        Ok(taken)
    }

    fn number<const N: usize>(&mut self) -> Result<[u8; N], CdrError> {
        self.at = self.at.next_multiple_of(N);
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        Ok(bytes)
    }

    read_numbers!(u8: u8, i8: i8, u16: u16, i16: i16, u32: u32, i32: i32, u64: u64, i64: i64, f32: f32, f64: f64);

    /// Yes or no.
    pub fn bool(&mut self) -> Result<bool, CdrError> {
        Ok(self.u8()? != 0)
    }

    /// A text; what is no UTF-8 in it is replaced.
    pub fn text(&mut self) -> Result<String, CdrError> {
        let len = self.u32()? as usize;
        let bytes = self.take(len)?;
        let text = bytes.strip_suffix(&[0]).unwrap_or(bytes);
        Ok(String::from_utf8_lossy(text).into_owned())
    }

    /// The length of a sequence of elements that take at least `least` bytes each.
    pub fn length(&mut self, least: usize) -> Result<usize, CdrError> {
        let len = self.u32()? as usize;
        let wanted = self.at.saturating_add(len.saturating_mul(least));
        if wanted > self.bytes.len() {
            return Err(CdrError::Short { len: HEADER + self.bytes.len(), wanted: wanted + HEADER });
        }
        Ok(len)
    }

    /// An array of a fixed length.
    pub fn array<const N: usize>(&mut self) -> Result<[f64; N], CdrError> {
        let mut values = [0.0; N];
        for value in &mut values {
            *value = self.f64()?;
        }
        Ok(values)
    }

    /// A sequence.
    pub fn f64s(&mut self) -> Result<Vec<f64>, CdrError> {
        (0..self.length(8)?).map(|_| self.f64()).collect()
    }

    /// A sequence.
    pub fn f32s(&mut self) -> Result<Vec<f32>, CdrError> {
        (0..self.length(4)?).map(|_| self.f32()).collect()
    }

    /// A sequence.
    pub fn u16s(&mut self) -> Result<Vec<u16>, CdrError> {
        (0..self.length(2)?).map(|_| self.u16()).collect()
    }

    /// A sequence.
    pub fn octets(&mut self) -> Result<&'a [u8], CdrError> {
        let len = self.length(1)?;
        self.take(len)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_to_their_own_size_behind_the_header() {
        let mut cdr = CdrWriter::default();
        cdr.begin().u8(7);
        cdr.f64(1.5);
        cdr.text("ab");
        cdr.f64s(&[]);
        cdr.u16(0x0102);
        let expected: &[u8] = &[
            0, 1, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xf8, 0x3f, 3, 0, 0, 0, b'a', b'b', 0, 0,
            0, 0, 0, 0, 2, 1,
        ];
        assert_eq!(cdr.bytes(), expected);
    }

    #[test]
    fn both_byte_orders_are_read() {
        let big = [0, 0, 0, 0, 0, 0, 0, 2, 0x3f, 0x80, 0, 0, 0xc0, 0, 0, 0];
        assert_eq!(CdrReader::new(&big).unwrap().f32s(), Ok(vec![1.0, -2.0]));
        let little = [0, 1, 0, 0, 2, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xc0];
        assert_eq!(CdrReader::new(&little).unwrap().f32s(), Ok(vec![1.0, -2.0]));
    }

    #[test]
    fn a_length_that_the_message_cannot_hold_is_refused_before_room_is_made() {
        let lies = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff];
        assert!(matches!(CdrReader::new(&lies).unwrap().f64s(), Err(CdrError::Short { len: 8, .. })));
        assert!(matches!(CdrReader::new(&lies).unwrap().text(), Err(CdrError::Short { .. })));
        assert_eq!(CdrReader::new(&[0, 9, 0, 0]).err(), Some(CdrError::Encoding(9)));
        assert!(CdrReader::new(&[0]).is_err());
    }

    #[test]
    fn every_bit_of_a_number_survives_not_a_numbers_too() {
        let odd = f64::from_bits(0x7ff0_0000_0000_0abc);
        let mut cdr = CdrWriter::default();
        cdr.begin().array(&[odd, -0.0]);
        cdr.f32s(&[f32::from_bits(0x7f80_0001)]);
        let mut reader = CdrReader::new(cdr.bytes()).unwrap();
        assert_eq!(reader.array::<2>().unwrap().map(f64::to_bits), [odd.to_bits(), (-0.0f64).to_bits()]);
        assert_eq!(reader.f32s().unwrap()[0].to_bits(), 0x7f80_0001);
    }
}
