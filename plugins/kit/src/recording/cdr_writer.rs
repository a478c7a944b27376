//! Writes messages in Common Data Representation ([`cdr`](super::cdr)).

use super::cdr::HEADER;
use super::room::Room;
use super::word_hash::WordHash;

/// Writes one message, little endian: alone, or behind what stands in the room already.
#[derive(Debug, Default)]
pub struct CdrWriter {
    room: Room,
    /// Where the message begins.
    start: usize,
    /// Where only the hash of the message is wanted.
    hash: Option<WordHash>,
    /// Bytes of the message that were hashed and are no longer in the room.
    n_hashed: usize,
}

macro_rules! write_numbers {
    ($($name:ident: $t:ty),*) => { $(
        /// A number.
        #[inline]
        pub fn $name(&mut self, value: $t) {
            self.align(size_of::<$t>());
            self.room.put(value.to_le_bytes());
        }
    )* };
}

impl CdrWriter {
    /// A writer whose messages stand in a piece of a file.
    pub(super) fn in_room(room: Room) -> CdrWriter {
        CdrWriter { room, ..CdrWriter::default() }
    }

    /// Where everything is written.
    #[inline]
    pub(super) fn room(&mut self) -> &mut Room {
        &mut self.room
    }

    /// What was written there, this message and those before it.
    #[inline]
    pub(super) fn written(&self) -> &Room {
        &self.room
    }

    /// The next message begins behind what there is.
    #[inline]
    pub(super) fn go_on(&mut self) {
        self.start = self.room.len();
    }

    /// Begins a new message in the room of the one before.
    #[inline]
    pub fn begin(&mut self) -> &mut CdrWriter {
        self.room.cut(self.start);
        self.room.put([0, 1, 0, 0]);
        (self.hash, self.n_hashed) = (None, 0);
        self
    }

    /// The [hash](super::hash_of) of the message that `put` writes, without room for all of it.
    pub fn hash(&mut self, put: impl FnOnce(&mut CdrWriter)) -> u64 {
        self.start = 0;
        self.begin().hash = Some(WordHash::default());
        put(self);
        self.n_hashed = 0;
        self.hash.take().unwrap_or_default().end(self.room.bytes())
    }

    /// The message.
    #[inline]
    pub fn bytes(&self) -> &[u8] {
        self.room.bytes().get(self.start..).unwrap_or_default()
    }

    #[inline]
    fn align(&mut self, size: usize) {
        const ZEROS: usize = 8;
        let used = (self.n_hashed + self.room.len()).wrapping_sub(self.start + HEADER);
        let missing = used.wrapping_neg() % size;
        if missing > 0 {
            // One store of eight bytes instead of a loop over some of them.
            if let Some(ahead) = self.room.ahead(ZEROS).first_chunk_mut::<ZEROS>() {
                *ahead = [0; ZEROS];
            }
            self.room.count(missing);
        }
    }

    write_numbers!(u8: u8, u16: u16, u32: u32, i32: i32, u64: u64, i64: i64, f32: f32, f64: f64);

    /// Yes or no.
    #[inline]
    pub fn bool(&mut self, value: bool) {
        self.u8(u8::from(value));
    }

    /// A text and its closing zero.
    pub fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.room.extend(text.as_bytes());
        self.room.put([0]);
    }

    /// The length of a sequence whose elements follow.
    #[inline]
    pub fn length(&mut self, len: usize) {
        self.u32(u32::try_from(len).unwrap_or(u32::MAX));
    }

    /// An array of a fixed length.
    #[inline]
    pub fn array(&mut self, values: &[f64]) {
        self.align(if values.is_empty() { 1 } else { 8 });
        self.fill(values, f64::to_le_bytes);
    }

    /// An array of a fixed length.
    #[inline]
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
        self.room.extend(values);
    }

    /// Octets that are made on the way.
    pub fn octets_of(&mut self, values: impl ExactSizeIterator<Item = u8>) {
        self.length(values.len());
        self.room.next(values.len()).iter_mut().zip(values).for_each(|(octet, value)| *octet = value);
    }

    #[inline]
    fn fill<T: Copy, const N: usize>(&mut self, values: &[T], bytes_of: impl Fn(T) -> [u8; N] + Copy) {
        if self.hash.is_some() { self.fill_hash(values, bytes_of) } else { self.copy(values, bytes_of) }
    }

    /// Elements that are hashed at once: they stay in the first cache.
    #[cold]
    fn fill_hash<T: Copy, const N: usize>(&mut self, values: &[T], bytes_of: impl Fn(T) -> [u8; N] + Copy) {
        const AT_ONCE: usize = 1024;
        for values in values.chunks(AT_ONCE) {
            self.copy(values, bytes_of);
            if let Some(hash) = &mut self.hash {
                let n_words = self.room.len() - hash.take(self.room.bytes()).len();
                self.n_hashed += n_words;
                self.room.take_front(n_words);
            }
        }
    }

    /// Elements that are aligned already: the compiler turns them into a copy.
    #[inline]
    fn copy<T: Copy, const N: usize>(&mut self, values: &[T], bytes_of: impl Fn(T) -> [u8; N]) {
        let (room, _) = self.room.next(values.len() * N).as_chunks_mut::<N>();
        room.iter_mut().zip(values).for_each(|(bytes, value)| *bytes = bytes_of(*value));
    }
}
