//! Room for bytes that are written one after the other, thousands of times over.
//!
//! A `Vec` looks after its length with every number that is appended. Here the bytes are there already, zeros or what was
//! written before, and only a mark moves on.

/// Bytes up to a mark, and room behind it.
#[derive(Debug, Default)]
pub struct Room {
    bytes: Vec<u8>,
    len: usize,
}

impl Room {
    /// Room is opened in steps, so that no page is touched that nobody needs.
    const MOST_AT_ONCE: usize = 1 << 16;
    const LEAST_AT_ONCE: usize = 1 << 8;

    /// Nothing yet; up to so many bytes never have to move.
    pub fn with_capacity(n_bytes: usize) -> Room {
        Room { bytes: Vec::with_capacity(n_bytes), len: 0 }
    }

    /// How many bytes were written.
    #[inline]
    pub fn len(&self) -> usize {
        self.len
    }

    /// What was written.
    #[inline]
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }

    /// Forgets what stands from here on.
    #[inline]
    pub fn cut(&mut self, len: usize) {
        self.len = self.len.min(len);
    }

    /// The next bytes, whatever is in them; they do not count yet.
    #[inline]
    pub fn ahead(&mut self, n_bytes: usize) -> &mut [u8] {
        let end = self.len + n_bytes;
        if end > self.bytes.len() {
            self.open(end);
        }
        self.bytes.get_mut(self.len..end).unwrap_or_default()
    }

    /// So many of the bytes ahead were written.
    #[inline]
    pub fn count(&mut self, n_bytes: usize) {
        self.len = (self.len + n_bytes).min(self.bytes.len());
    }

    /// The next bytes, to be written by whoever asked.
    #[inline]
    pub fn next(&mut self, n_bytes: usize) -> &mut [u8] {
        let start = self.len;
        if start + n_bytes > self.bytes.len() {
            self.open(start + n_bytes);
        }
        self.len = start + n_bytes;
        self.bytes.get_mut(start..start + n_bytes).unwrap_or_default()
    }

    #[cold]
    fn open(&mut self, end: usize) {
        let more = self.bytes.len().clamp(Self::LEAST_AT_ONCE, Self::MOST_AT_ONCE);
        self.bytes.resize(end.max(self.bytes.len() + more), 0);
    }

    /// A number.
    #[inline]
    pub fn put<const N: usize>(&mut self, bytes: [u8; N]) {
        if let Some(room) = self.next(N).first_chunk_mut() {
            *room = bytes;
        }
    }

    /// Any bytes.
    #[inline]
    pub fn extend(&mut self, bytes: &[u8]) {
        self.next(bytes.len()).copy_from_slice(bytes);
    }

    /// Fills in what was left open.
    #[inline]
    pub fn set(&mut self, at: usize, bytes: &[u8]) {
        if let Some(room) = self.bytes.get_mut(at..at + bytes.len()) {
            room.copy_from_slice(bytes);
        }
    }

    /// Takes bytes from the front; the rest moves there.
    pub fn take_front(&mut self, n_bytes: usize) {
        let n_bytes = n_bytes.min(self.len);
        self.bytes.copy_within(n_bytes..self.len, 0);
        self.len -= n_bytes;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_stand_one_behind_the_other_and_what_was_cut_off_is_gone() {
        let mut room = Room::with_capacity(3);
        room.put([1, 2]);
        room.extend(&[3; 300]);
        room.next(2).fill(4);
        room.set(1, &[9]);
        assert_eq!(
            (room.len(), &room.bytes()[..3], &room.bytes()[301..]),
            (304, &[1, 9, 3][..], &[3, 4, 4][..])
        );
        room.cut(2);
        room.cut(7);
        room.ahead(4)[0] = 5;
        room.count(1);
        assert_eq!(room.bytes(), [1, 9, 5]);
        room.take_front(1);
        assert_eq!(room.bytes(), [9, 5]);
    }

    #[test]
    fn room_that_was_made_at_first_is_enough() {
        let mut room = Room::with_capacity(1 << 20);
        room.put([1]);
        let first = room.bytes().as_ptr();
        (0..(1 << 20) - 1).for_each(|_| room.put([2]));
        assert_eq!((room.bytes().as_ptr(), room.len()), (first, 1 << 20));
    }
}
