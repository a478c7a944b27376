//! Bins of 0.5 m x 0.5 m x 10 degrees that poses fall into: what KLD-sampling counts and clusters are made of.

use std::f64::consts::TAU;

/// A bin: along x, along y, heading.
pub type Bin = [i32; 3];

/// Bins over a full turn.
pub const N_HEADINGS: i32 = 36;
const SIDE_M: f64 = 0.5;
const EMPTY: u32 = u32::MAX;
const FEWEST_SLOTS: usize = 64;

/// The bin of a pose.
#[inline]
pub fn bin_of([x_m, y_m, yaw_rad]: [f64; 3]) -> Bin {
    let turns = yaw_rad / TAU;
    let heading = ((turns - turns.floor()) * f64::from(N_HEADINGS)) as i32;
    [(x_m / SIDE_M).floor() as i32, (y_m / SIDE_M).floor() as i32, heading.min(N_HEADINGS - 1)]
}

/// A set of bins, numbered in the order in which they came; open addressing, so that its order depends on nothing else.
#[derive(Debug, Clone, Default)]
pub struct BinSet {
    /// Number of the bin in each slot.
    slots: Vec<u32>,
    /// Slot of each bin.
    used: Vec<u32>,
    bins: Vec<Bin>,
}

impl BinSet {
    /// All bins in the order in which they came.
    pub fn bins(&self) -> &[Bin] {
        &self.bins
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.bins.len()
    }

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.bins.is_empty()
    }

    /// Takes all bins out; costs time in proportion to how many there were.
    pub fn clear(&mut self) {
        for slot in self.used.drain(..) {
            self.slots[slot as usize] = EMPTY;
        }
        self.bins.clear();
    }

    /// Number of a bin, which is added if it is new.
    #[inline]
    pub fn insert(&mut self, bin: Bin) -> usize {
        if (self.bins.len() + 1) * 2 > self.slots.len() {
            self.grow();
        }
        let slot = self.slot_of(&bin);
        if self.slots[slot] == EMPTY {
            self.slots[slot] = self.bins.len() as u32;
            self.used.push(slot as u32);
            self.bins.push(bin);
        }
        self.slots[slot] as usize
    }

    /// Number of a bin that is there.
    #[inline]
    pub fn find(&self, bin: &Bin) -> Option<usize> {
        if self.slots.is_empty() {
            return None;
        }
        let number = self.slots[self.slot_of(bin)];
        (number != EMPTY).then_some(number as usize)
    }

    /// Where the bin is, or would be.
    #[inline]
    fn slot_of(&self, bin: &Bin) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = scramble(bin) as usize & mask;
        loop {
            let number = self.slots[slot];
            if number == EMPTY || self.bins[number as usize] == *bin {
                return slot;
            }
            slot = (slot + 1) & mask;
        }
    }

    fn grow(&mut self) {
        let n_slots = (self.slots.len() * 2).max(FEWEST_SLOTS);
        self.slots.clear();
        self.slots.resize(n_slots, EMPTY);
        for idx in 0..self.bins.len() {
            let slot = self.slot_of(&self.bins[idx]);
            self.slots[slot] = idx as u32;
            self.used[idx] = slot as u32;
        }
    }
}

/// The finalizer of splitmix64 (Steele, Lea, Flood 2014) over the three numbers.
#[inline]
fn scramble([x, y, heading]: &Bin) -> u64 {
    let packed = (*x as u32 as u64) ^ ((*y as u32 as u64) << 26) ^ ((*heading as u64) << 52);
    let z = (packed ^ (packed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::f64::consts::PI;

    #[test]
    fn headings_fill_a_full_turn_with_36_bins_on_both_sides() {
        assert_eq!(bin_of([0.2, -0.2, 0.0]), [0, -1, 0]);
        assert_eq!(bin_of([-0.5, 0.5, -0.01]), [-1, 1, 35]);
        assert_eq!(bin_of([0.0, 0.0, PI])[2], bin_of([0.0, 0.0, -PI])[2]);
        assert_eq!(bin_of([0.0, 0.0, -1e-18])[2], 35);
        assert_eq!(bin_of([0.0, 0.0, 100.0 * TAU + 0.2])[2], 1);
    }

    #[test]
    fn a_set_of_bins_is_a_set_also_after_it_was_emptied() {
        let mut set = BinSet::default();
        assert_eq!(set.find(&[0, 0, 0]), None);
        for round in 0..3 {
            let bins: Vec<Bin> =
                (0..2000).map(|k| [k * 7919 % 40 - 20, k * 104_729 % 40 - 20 + round, k % 36]).collect();
            let numbers: Vec<usize> = bins.iter().map(|bin| set.insert(*bin)).collect();
            let distinct: BTreeSet<Bin> = bins.iter().copied().collect();
            assert_eq!(set.len(), distinct.len());
            for (bin, number) in bins.iter().zip(numbers) {
                assert_eq!((set.find(bin), set.bins()[number]), (Some(number), *bin));
            }
            assert_eq!(set.find(&[99, 0, 0]), None);
            set.clear();
            assert!(set.is_empty() && set.find(&bins[0]).is_none());
        }
    }
}
