//! The 3 x 3 median of a depth picture: Valverde Moreno (2015), section 5.2, after decoding.

use crate::simd::{Kernel, Vectors, widest};

use super::SizeMismatch;

/// A median over windows of 3 x 3 pixels, clipped at the picture's edge. Pixels without a reading (0) are not in the window
/// and stay without; of an even number the lower of the two middle ones.
#[derive(Debug, Clone, Default)]
pub struct MedianFilter {
    /// Three rows with a pixel of nothing on both sides.
    rows: [Vec<u16>; 3],
}

impl MedianFilter {
    /// Filters a picture of `n_columns` into another one.
    pub fn filter(
        &mut self,
        n_columns: usize,
        counts: &[u16],
        filtered: &mut [u16],
    ) -> Result<(), SizeMismatch> {
        SizeMismatch::check("a filtered picture", filtered.len(), counts.len())?;
        if n_columns == 0 {
            return SizeMismatch::check("a picture", counts.len(), 0);
        }
        let n_rows = counts.len() / n_columns;
        SizeMismatch::check("a picture", counts.len(), n_rows * n_columns)?;
        let mut rows = counts.chunks_exact(n_columns);
        for row in &mut self.rows {
            row.clear();
            row.resize(n_columns + 2, 0);
        }
        fill(&mut self.rows[2], rows.next());
        for filtered in filtered.chunks_exact_mut(n_columns) {
            self.rows.rotate_left(1);
            fill(&mut self.rows[2], rows.next());
            let [above, here, below] = &self.rows;
            widest(Row { above, here, below, filtered });
        }
        Ok(())
    }
}

/// Puts a row between its two pixels of nothing; nothing at all below the last.
fn fill(padded: &mut [u16], row: Option<&[u16]>) {
    let n_columns = padded.len() - 2;
    let inner = &mut padded[1..=n_columns];
    match row {
        Some(row) => inner.copy_from_slice(row),
        None => inner.fill(0),
    }
}

struct Row<'a> {
    above: &'a [u16],
    here: &'a [u16],
    below: &'a [u16],
    filtered: &'a mut [u16],
}

/// Pixels that are sorted together.
const LANES: usize = 32;

impl Kernel for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let Row { above, here, below, filtered } = self;
        let n_columns = filtered.len();
        for first in (0..n_columns).step_by(LANES) {
            // The last pixels are done together with some before them.
            let first = if first + LANES <= n_columns { first } else { n_columns.saturating_sub(LANES) };
            let n = LANES.min(n_columns);
            let mut window = [[0; LANES]; 9];
            for (idx, lanes) in window.iter_mut().enumerate() {
                let row = [above, here, below][idx / 3];
                lanes[..n].copy_from_slice(&row[first + idx % 3..first + idx % 3 + n]);
            }
            filtered[first..first + n].copy_from_slice(&medians(window)[..n]);
        }
    }
}

/// Compare and exchange, position by position.
#[inline(always)]
fn sort_two(window: &mut [[u16; LANES]; 9], low: usize, high: usize) {
    for lane in 0..LANES {
        let (a, b) = (window[low][lane], window[high][lane]);
        window[low][lane] = a.min(b);
        window[high][lane] = a.max(b);
    }
}

/// Medians of the windows; the middle pixel is `window[4]`.
#[inline(always)]
fn medians(mut window: [[u16; LANES]; 9]) -> [u16; LANES] {
    let middle = window[4];
    let mut n_without = [0_u16; LANES];
    for pixels in &window {
        for lane in 0..LANES {
            n_without[lane] += u16::from(pixels[lane] == 0);
        }
    }
    // Nine rounds of neighbors sort nine numbers; pixels without a reading come first.
    for round in 0..9 {
        for low in (round % 2..8).step_by(2) {
            sort_two(&mut window, low, low + 1);
        }
    }
    // The lower middle one of those with a reading: place n + (8 - n) / 2 where n have none.
    let mut median = window[4];
    for (place, pixels) in window.iter().enumerate().skip(5) {
        for lane in 0..LANES {
            let wanted = n_without[lane] + (8 - n_without[lane].min(8)) / 2;
            median[lane] = if wanted == place as u16 { pixels[lane] } else { median[lane] };
        }
    }
    for lane in 0..LANES {
        median[lane] = if middle[lane] == 0 { 0 } else { median[lane] };
    }
    median
}
