//! A number that tells whether bytes are the same, eight at a time.

/// FNV-1a (Fowler, Noll, Vo) over words: it finds changes, not forgers.
#[derive(Debug, Clone, Copy)]
pub struct WordHash {
    hash: u64,
    n_bytes: u64,
}

impl Default for WordHash {
    fn default() -> WordHash {
        WordHash { hash: 0xcbf2_9ce4_8422_2325, n_bytes: 0 }
    }
}

fn mix(hash: u64, part: u64) -> u64 {
    (hash ^ part).wrapping_mul(0x0100_0000_01b3).rotate_left(23)
}

impl WordHash {
    /// Takes all whole words from the front; what is left comes first the next time.
    pub fn take<'a>(&mut self, bytes: &'a [u8]) -> &'a [u8] {
        let (words, rest) = bytes.as_chunks::<8>();
        self.hash = words.iter().fold(self.hash, |hash, word| mix(hash, u64::from_le_bytes(*word)));
        self.n_bytes += (bytes.len() - rest.len()) as u64;
        rest
    }

    /// The number, when these were the last bytes.
    pub fn end(mut self, bytes: &[u8]) -> u64 {
        let rest = self.take(bytes);
        let n_bytes = self.n_bytes + rest.len() as u64;
        rest.iter().fold(mix(self.hash, n_bytes), |hash, byte| mix(hash, u64::from(*byte)))
    }
}

/// The number of these bytes.
pub fn hash_of(bytes: &[u8]) -> u64 {
    WordHash::default().end(bytes)
}
