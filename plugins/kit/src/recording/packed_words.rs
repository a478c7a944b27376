//! A message as the words in which it differs from the message of its kind before it.
//!
//! Words come in groups of eight: one byte says which of them changed, and those follow. Words that count or tell the
//! time are expected to go on as they went, all others to stay as they are.

use super::cdr::CdrError;
use super::room::Room;

/// Bytes of a word.
const WORD: usize = 8;
/// Words of a group.
const GROUP: usize = 8;
/// Bytes of a group of which everything changed.
const MOST: usize = 1 + GROUP * WORD;

/// The last message of a kind.
#[derive(Debug, Default)]
pub struct LastWords {
    groups: Vec<[u64; GROUP]>,
    /// What the clocks went on by.
    strides: [u64; 2],
    n_bytes: usize,
}

impl LastWords {
    /// Bytes of the last message.
    pub fn n_bytes(&self) -> usize {
        self.n_bytes
    }

    /// Begins anew with zeros where the next message is of another length.
    pub fn fit(&mut self, n_bytes: usize) {
        if self.n_bytes != n_bytes {
            self.groups.clear();
            self.groups.resize(n_bytes.div_ceil(WORD * GROUP), [0; GROUP]);
            self.strides = [0; 2];
            self.n_bytes = n_bytes;
        }
    }

    /// Puts what is expected of the clocks into their words, and says what they were.
    fn expect(&mut self, clocks: &[usize]) -> [u64; 2] {
        let mut before = [0; 2];
        for ((clock, stride), before) in clocks.iter().zip(self.strides).zip(&mut before) {
            if let Some(word) = self.groups.as_flattened_mut().get_mut(*clock) {
                *before = *word;
                *word = word.wrapping_add(stride);
            }
        }
        before
    }

    fn learn(&mut self, clocks: &[usize], before: [u64; 2]) {
        for ((clock, stride), before) in clocks.iter().zip(&mut self.strides).zip(before) {
            *stride = self.groups.as_flattened().get(*clock).map_or(0, |word| word.wrapping_sub(before));
        }
    }

    /// Writes a message of the length that was fitted.
    pub fn pack(&mut self, message: &[u8], clocks: &[usize], out: &mut Room) {
        let before = self.expect(clocks);
        let (whole, rest) = message.as_chunks::<{ GROUP * WORD }>();
        let (ahead, mut n_bytes) = (out.ahead(self.groups.len() * MOST), 0);
        for (group, last) in whole.iter().zip(&mut self.groups) {
            n_bytes += pack_group(group, last, ahead.get_mut(n_bytes..).unwrap_or_default());
        }
        if let Some(last) = self.groups.get_mut(whole.len()) {
            let mut padded = [0; GROUP * WORD];
            padded.iter_mut().zip(rest).for_each(|(padded, byte)| *padded = *byte);
            n_bytes += pack_group(&padded, last, ahead.get_mut(n_bytes..).unwrap_or_default());
        }
        out.count(n_bytes);
        self.learn(clocks, before);
    }

    /// Reads a message of the length that was fitted, and appends it; gives back what follows it.
    pub fn unpack<'a>(
        &mut self,
        mut packed: &'a [u8],
        clocks: &[usize],
        message: &mut Vec<u8>,
    ) -> Result<&'a [u8], CdrError> {
        let before = self.expect(clocks);
        for group in &mut self.groups {
            let [mask] = take(&mut packed)?;
            for (idx, word) in group.iter_mut().enumerate() {
                if mask >> idx & 1 == 1 {
                    *word = u64::from_le_bytes(take(&mut packed)?);
                }
            }
        }
        self.learn(clocks, before);
        let end = message.len() + self.n_bytes;
        self.groups.as_flattened().iter().for_each(|word| message.extend_from_slice(&word.to_le_bytes()));
        message.truncate(end);
        Ok(packed)
    }
}

/// Writes the words of a group that changed; how many bytes that are.
#[inline]
fn pack_group(group: &[u8; GROUP * WORD], last: &mut [u64; GROUP], ahead: &mut [u8]) -> usize {
    let Some([mask_room, words_room @ ..]) = ahead.first_chunk_mut::<MOST>() else { return 0 };
    let mut mask = 0;
    for ((idx, bytes), last) in (0..GROUP).zip(group.as_chunks::<WORD>().0).zip(&mut *last) {
        let word = u64::from_le_bytes(*bytes);
        mask |= u8::from(word != *last) << idx;
        *last = word;
    }
    *mask_room = mask;
    // A robot's messages change in the same words time after time: the processor guesses these branches well.
    let (mut left, mut n_changed) = (mask, 0);
    while left != 0 {
        let changed = last[left.trailing_zeros() as usize % GROUP];
        if let Some(room) = words_room.as_chunks_mut::<WORD>().0.get_mut(n_changed) {
            *room = changed.to_le_bytes();
        }
        n_changed += 1;
        left &= left - 1;
    }
    1 + n_changed * WORD
}

/// Takes bytes from the front.
pub fn take<const N: usize>(bytes: &mut &[u8]) -> Result<[u8; N], CdrError> {
    let short = CdrError::Short { len: bytes.len(), wanted: N };
    let (taken, rest) = bytes.split_first_chunk::<N>().ok_or(short)?;
    *bytes = rest;
    Ok(*taken)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    #[test]
    fn any_messages_come_back_whatever_their_lengths_and_what_changed() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let (mut packer, mut unpacker) = (LastWords::default(), LastWords::default());
        let mut message = vec![0u8; 100];
        for round in 0..2000 {
            if round % 50 == 0 {
                message.resize(rng.random_range(0..200), 0);
            }
            for _ in 0..rng.random_range(0..4) {
                if !message.is_empty() {
                    let at = rng.random_range(0..message.len());
                    message[at] = rng.random();
                }
            }
            let (mut packed, mut back) = (Room::default(), vec![7]);
            packer.fit(message.len());
            packer.pack(&message, &[0, 1], &mut packed);
            packed.put([9]);
            unpacker.fit(message.len());
            let left = unpacker.unpack(packed.bytes(), &[0, 1], &mut back);
            assert_eq!(left, Ok(&[9][..]), "round {round}");
            assert_eq!(back[1..], message, "round {round}");
        }
    }

    #[test]
    fn a_clock_that_goes_on_as_it_went_and_what_stays_cost_no_word() {
        let mut packer = LastWords::default();
        let lens = [0u64, 50, 100, 150, 151].map(|now| {
            let (mut message, mut packed) = (now.to_le_bytes().to_vec(), Room::default());
            message.extend([1; 12]);
            packer.fit(message.len());
            packer.pack(&message, &[0], &mut packed);
            packed.len()
        });
        assert_eq!(lens, [1 + 16, 1 + 8, 1, 1, 1 + 8]);
    }

    #[test]
    fn words_that_are_cut_are_a_fault() {
        let (mut packer, mut packed) = (LastWords::default(), Room::default());
        packer.fit(80);
        packer.pack(&[3; 80], &[], &mut packed);
        for len in 0..packed.len() {
            let mut unpacker = LastWords::default();
            unpacker.fit(80);
            assert!(unpacker.unpack(&packed.bytes()[..len], &[], &mut Vec::new()).is_err(), "cut at {len}");
        }
    }
}
