//! Writes messages in Common Data Representation ([`cdr`](super::cdr)).

use super::cdr::HEADER;
use super::word_hash::WordHash;

/// Writes one message, little endian.
#[derive(Debug, Default)]
pub struct CdrWriter {
    bytes: Vec<u8>,
    /// Where only the hash of the message is wanted: what of it was hashed already, and how many bytes that were.
    hashed: Option<(WordHash, usize)>,
}

macro_rules! write_numbers {
    ($($name:ident: $t:ty),*) => { $(
        /// A number.
        pub fn $name(&mut self, value: $t) {
            self.align(size_of::<$t>());
            self.bytes.extend_from_slice(&value.to_le_bytes());
        }
    )* };
}

impl CdrWriter {
    /// Begins a new message in the room of the one before.
    pub fn begin(&mut self) -> &mut CdrWriter {
        self.bytes.clear();
        self.bytes.extend_from_slice(&[0, 1, 0, 0]);
        self.hashed = None;
        self
    }

    /// The [hash](super::hash_of) of the message that `put` writes, without room for all of it.
    pub fn hash(&mut self, put: impl FnOnce(&mut CdrWriter)) -> u64 {
        self.begin().hashed = Some((WordHash::default(), 0));
        put(self);
        self.hashed.take().unwrap_or_default().0.end(&self.bytes)
    }

    /// The message.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    fn align(&mut self, size: usize) {
        let hashed = self.hashed.map_or(0, |(_, n_bytes)| n_bytes);
        let used = (hashed + self.bytes.len()).saturating_sub(HEADER);
        let missing = used.next_multiple_of(size) - used;
        self.bytes.resize(self.bytes.len() + missing, 0);
    }

    write_numbers!(u8: u8, u16: u16, u32: u32, i32: i32, u64: u64, i64: i64, f32: f32, f64: f64);

    /// Yes or no.
    pub fn bool(&mut self, value: bool) {
        self.u8(u8::from(value));
    }

    /// A text and its closing zero.
    pub fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.bytes.extend_from_slice(text.as_bytes());
        self.bytes.push(0);
    }

    /// The length of a sequence whose elements follow.
    pub fn length(&mut self, len: usize) {
        self.u32(u32::try_from(len).unwrap_or(u32::MAX));
    }

    /// An array of a fixed length.
    pub fn array(&mut self, values: &[f64]) {
        self.align(if values.is_empty() { 1 } else { 8 });
        self.fill(values, f64::to_le_bytes);
    }

    /// An array of a fixed length.
    pub fn array32(&mut self, values: &[f32]) {
        self.align(if values.is_empty() { 1 } else { 4 });
        self.fill(values, f32::to_le_bytes);
    }

    /// A sequence.
    pub fn f64s(&mut self, values: &[f64]) {
        self.length(values.len());
        self.array(values);
    }

    /// A sequence.
    pub fn f32s(&mut self, values: &[f32]) {
        self.length(values.len());
        self.array32(values);
    }

    /// A sequence.
    pub fn u16s(&mut self, values: &[u16]) {
        self.length(values.len());
        self.fill(values, u16::to_le_bytes);
    }

    /// A sequence.
    pub fn octets(&mut self, values: &[u8]) {
        self.length(values.len());
        self.bytes.extend_from_slice(values);
    }

    /// Octets that are made on the way.
    pub fn octets_of(&mut self, values: impl ExactSizeIterator<Item = u8>) {
        self.length(values.len());
        self.bytes.extend(values);
    }

    fn fill<T: Copy, const N: usize>(&mut self, values: &[T], bytes_of: impl Fn(T) -> [u8; N] + Copy) {
        /// Elements that are hashed at once: they stay in the first cache.
        const AT_ONCE: usize = 1024;
        if self.hashed.is_none() {
            return self.copy(values, bytes_of);
        }
        for values in values.chunks(AT_ONCE) {
            self.copy(values, bytes_of);
            if let Some((hash, n_bytes)) = &mut self.hashed {
                let n_words = self.bytes.len() - hash.take(&self.bytes).len();
                *n_bytes += n_words;
                self.bytes.drain(..n_words);
            }
        }
    }

    /// Elements that are aligned already, sixteen at a time: the compiler turns them into a copy.
    fn copy<T: Copy, const N: usize>(&mut self, values: &[T], bytes_of: impl Fn(T) -> [u8; N]) {
        self.bytes.reserve(values.len() * N);
        let (blocks, rest) = values.as_chunks::<16>();
        for block in blocks {
            self.bytes.extend_from_slice(block.map(&bytes_of).as_flattened());
        }
        for value in rest {
            self.bytes.extend_from_slice(&bytes_of(*value));
        }
    }
}
