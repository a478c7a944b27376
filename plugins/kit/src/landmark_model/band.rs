//! A part of the model: which of its cells see what.
//!
//! For each look that occurs, the cells that see one like it, rising, each as its distance from the one before in 7 bits a
//! byte. Neighbors see the same walls, so that most distances fit into one byte.

use super::look::Look;

/// Cells that follow each other in the rows of a map.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Band {
    /// Looks that occur, rising.
    pub codes: Vec<u32>,
    /// Where the list of each ends.
    pub ends: Vec<u32>,
    /// The lists.
    pub lists: Vec<u8>,
}

/// What one cell sees, as one number that sorts by look and then by cell.
pub(super) fn entry(look: Look, cell_in_band: u32) -> u64 {
    u64::from(look.code()) << 32 | u64::from(cell_in_band)
}

impl Band {
    /// Packs entries, which are sorted here.
    pub fn of(mut entries: Vec<u64>) -> Band {
        entries.sort_unstable();
        let mut band = Band::default();
        let mut last_cell = 0;
        for entry in entries {
            let (code, cell) = ((entry >> 32) as u32, entry as u32);
            if band.codes.last() != Some(&code) {
                band.codes.push(code);
                band.ends.push(0);
                last_cell = 0;
            }
            push_number(&mut band.lists, cell - last_cell);
            last_cell = cell;
            if let Some(end) = band.ends.last_mut() {
                *end = band.lists.len() as u32;
            }
        }
        band.codes.shrink_to_fit();
        band.ends.shrink_to_fit();
        band.lists.shrink_to_fit();
        band
    }

    /// Bytes that it takes.
    pub fn n_bytes(&self) -> usize {
        4 * (self.codes.len() + self.ends.len()) + self.lists.len()
    }

    /// Visits every cell (counted within the band) that sees a look whose number is in `codes`, once for each such look.
    #[inline]
    pub fn for_each(&self, codes: std::ops::RangeInclusive<u32>, visit: impl FnMut(u32)) {
        let first = self.codes.partition_point(|code| code < codes.start());
        let end = self.codes.partition_point(|code| code <= codes.end());
        self.visit_lists(first..end.max(first), visit);
    }

    fn visit_lists(&self, lists: std::ops::Range<usize>, mut visit: impl FnMut(u32)) {
        for idx in lists {
            let Some(list) = self.list(idx) else { continue };
            let (mut cell, mut number, mut shift) = (0_u32, 0_u32, 0);
            for byte in list {
                if *byte < 0x80 && shift == 0 {
                    cell = cell.wrapping_add(u32::from(*byte));
                    visit(cell);
                    continue;
                }
                number |= u32::from(byte & 0x7f).checked_shl(shift).unwrap_or(0);
                shift += 7;
                if *byte < 0x80 {
                    cell = cell.wrapping_add(number);
                    (number, shift) = (0, 0);
                    visit(cell);
                }
            }
        }
    }

    fn list(&self, idx: usize) -> Option<&[u8]> {
        let first = idx.checked_sub(1).map_or(Some(0), |before| self.ends.get(before).copied())?;
        self.lists.get(first as usize..*self.ends.get(idx)? as usize)
    }

    /// Everything in it fits together, and with the number of landmarks that each cell has.
    pub fn is_sound(&self, n_landmarks: &[u8]) -> bool {
        let is_shaped = self.codes.len() == self.ends.len()
            && self.codes.is_sorted_by(|a, b| a < b)
            && self.ends.is_sorted_by(|a, b| a < b)
            && self.ends.last().map_or(0, |end| *end as usize) == self.lists.len();
        if !is_shaped || (0..self.ends.len()).any(|idx| !self.list(idx).is_some_and(is_whole)) {
            return false;
        }
        let mut counts = vec![0_u32; n_landmarks.len()];
        let mut is_inside = true;
        self.visit_lists(0..self.codes.len(), |cell| match counts.get_mut(cell as usize) {
            Some(count) => *count += 1,
            None => is_inside = false,
        });
        let fits = |(count, n): (&u32, &u8)| (*count).min(u32::from(u8::MAX)) == u32::from(*n);
        is_inside && counts.iter().zip(n_landmarks).all(fits)
    }
}

/// The last number of a list ends with it.
fn is_whole(list: &[u8]) -> bool {
    list.last().is_some_and(|byte| *byte < 0x80)
}

fn push_number(bytes: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        bytes.push(number as u8 | 0x80);
        number >>= 7;
    }
    bytes.push(number as u8);
}
