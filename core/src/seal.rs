//! Bytes that say what they are: a magic word and a version before them, a CRC-32 of all that behind, little-endian. For
//! states and models that a later run goes on from.

/// What bytes of one kind begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Seal {
    /// Which kind they are.
    pub magic: [u8; 8],
    /// Goes up with every change of their layout or meaning.
    pub version: u32,
}

/// Why bytes are not what they should be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Broken {
    /// Another kind.
    Foreign,
    /// This other version.
    Version(u32),
    /// A part is missing or changed.
    Damaged,
}

impl Seal {
    /// The beginning, with room for so many bytes.
    pub fn begin(&self, room: usize) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(room);
        bytes.extend(self.magic);
        bytes.extend(self.version.to_le_bytes());
        bytes
    }

    /// Adds the end.
    pub fn close(mut bytes: Vec<u8>) -> Vec<u8> {
        let checksum = crc32fast::hash(&bytes);
        bytes.extend(checksum.to_le_bytes());
        bytes
    }

    /// What lies between beginning and end.
    ///
    /// # Errors
    /// What is wrong with them.
    pub fn open<'b>(&self, bytes: &'b [u8]) -> Result<Reader<'b>, Broken> {
        let mut rest = Reader(bytes);
        if rest.chunk() != Some(self.magic) {
            return Err(Broken::Foreign);
        }
        let version = rest.u32().ok_or(Broken::Damaged)?;
        if version != self.version {
            return Err(Broken::Version(version));
        }
        let (content, checksum) = bytes.split_last_chunk().ok_or(Broken::Damaged)?;
        if crc32fast::hash(content) != u32::from_le_bytes(*checksum) {
            return Err(Broken::Damaged);
        }
        let n_between = rest.0.len().checked_sub(checksum.len()).ok_or(Broken::Damaged)?;
        Ok(Reader(rest.0.get(..n_between).unwrap_or_default()))
    }
}

/// Reads numbers off the front; nothing where there are too few bytes.
#[derive(Debug, Clone, Copy)]
pub struct Reader<'b>(&'b [u8]);

impl<'b> Reader<'b> {
    /// Nothing is left.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// So many bytes.
    pub fn take(&mut self, n: usize) -> Option<&'b [u8]> {
        let (taken, left) = self.0.split_at_checked(n)?;
        self.0 = left;
        Some(taken)
    }

    /// The next bytes, as many as are asked for.
    pub fn chunk<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, left) = self.0.split_first_chunk()?;
        self.0 = left;
        Some(*taken)
    }

    /// A whole number of four bytes.
    pub fn u32(&mut self) -> Option<u32> {
        self.chunk().map(u32::from_le_bytes)
    }

    /// So many of them.
    pub fn u32s(&mut self, n: usize) -> Option<Vec<u32>> {
        let words = self.take(n.checked_mul(4)?)?;
        Some(words.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
    }

    /// A whole number of eight bytes, with its sign.
    pub fn i64(&mut self) -> Option<i64> {
        self.chunk().map(i64::from_le_bytes)
    }

    /// A number.
    pub fn f64(&mut self) -> Option<f64> {
        self.chunk().map(f64::from_le_bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEAL: Seal = Seal { magic: *b"RUMBOTST", version: 3 };

    #[test]
    fn what_was_sealed_is_read_and_what_is_not_whole_is_told() {
        let mut bytes = SEAL.begin(64);
        bytes.extend(7u32.to_le_bytes());
        bytes.extend((-0.5f64).to_le_bytes());
        let bytes = Seal::close(bytes);
        let mut rest = SEAL.open(&bytes).unwrap();
        assert_eq!((rest.u32(), rest.f64(), rest.is_empty(), rest.u32()), (Some(7), Some(-0.5), true, None));
        let other = Seal { magic: *b"RUMBOOTH", ..SEAL };
        assert_eq!(other.open(&bytes).err(), Some(Broken::Foreign));
        let newer = Seal { version: 4, ..SEAL };
        assert_eq!(newer.open(&bytes).err(), Some(Broken::Version(3)));
        for n in 0..bytes.len() {
            let expected = if n < 8 { Broken::Foreign } else { Broken::Damaged };
            assert_eq!(SEAL.open(&bytes[..n]).err(), Some(expected), "{n} bytes");
        }
        for idx in 12..bytes.len() {
            let mut changed = bytes.clone();
            changed[idx] ^= 1;
            assert_eq!(SEAL.open(&changed).err(), Some(Broken::Damaged), "byte {idx}");
        }
    }
}
