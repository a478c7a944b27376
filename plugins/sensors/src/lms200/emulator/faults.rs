//! What can go wrong.

use rand::RngExt as _;
use rumbo_core::rng::{self, Rng};
use rumbo_core::time::Span;

/// Faults of line and device, to be switched on and off at any time.
#[derive(Debug, Clone)]
pub struct Faults {
    /// Chance that a byte of the device loses one bit to its opposite.
    pub flip: f64,
    /// Chance that a byte of the device gets lost.
    pub drop: f64,
    /// Every telegram waits so long.
    pub delay: Span,
    /// Bits set in every status byte.
    pub status_bits: u8,
    /// So many next telegrams of the host are refused.
    pub n_naks: u32,
    /// Continuous output has stopped, unasked.
    pub is_mute: bool,
    /// Nothing passes the line in either direction.
    pub is_unplugged: bool,
    rng: Rng,
}

impl Faults {
    /// None yet; `seed` is for those that come by chance.
    pub fn none(seed: u64) -> Self {
        Self {
            flip: 0.0,
            drop: 0.0,
            delay: Span::ZERO,
            status_bits: 0,
            n_naks: 0,
            is_mute: false,
            is_unplugged: false,
            rng: rng::stream(seed, "lms200_faults"),
        }
    }

    /// What becomes of a byte on the line.
    pub(super) fn befall(&mut self, byte: u8) -> Option<u8> {
        if self.drop > 0.0 && self.rng.random::<f64>() < self.drop {
            return None;
        }
        if self.flip > 0.0 && self.rng.random::<f64>() < self.flip {
            return Some(byte ^ 1 << self.rng.random_range(0..8));
        }
        Some(byte)
    }
}
