//! The 3 x 3 median of a depth picture: Valverde Moreno (2015), section 5.2, after decoding.

use crate::simd::{Kernel, Vectors, widest};

use super::SizeMismatch;

/// A median over windows of 3 x 3 pixels, clipped at the picture's edge. Pixels without a reading (0) are not in the window
/// and stay without; of an even number the lower of the two middle ones.
#[derive(Debug, Clone, Default)]
pub struct MedianFilter {
    /// Three rows with a pixel of nothing on both sides.
    rows: [Vec<u16>; 3],
    /// The nine pixels around each pixel of a row.
    window: [Vec<u16>; 9],
    /// How many of them have no reading.
    n_without: Vec<u16>,
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
        self.window.iter_mut().for_each(|pixels| pixels.resize(n_columns, 0));
        self.n_without.resize(n_columns, 0);
        fill(&mut self.rows[2], rows.next());
        for filtered in filtered.chunks_exact_mut(n_columns) {
            self.rows.rotate_left(1);
            fill(&mut self.rows[2], rows.next());
            widest(Row { filter: self, filtered });
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

/// Medians of all pixels of a row together: each step below goes over the whole row, which vectors do well.
struct Row<'a> {
    filter: &'a mut MedianFilter,
    filtered: &'a mut [u16],
}

impl Kernel for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run<V: Vectors>(self) {
        let MedianFilter { rows, window, n_without } = self.filter;
        let filtered = self.filtered;
        n_without.fill(0);
        for (idx, pixels) in window.iter_mut().enumerate() {
            let from = &rows[idx / 3][idx % 3..idx % 3 + filtered.len()];
            pixels.copy_from_slice(from);
            for (n, pixel) in n_without.iter_mut().zip(from) {
                *n += u16::from(*pixel == 0);
            }
        }
        // Nine rounds of neighbors sort nine numbers; pixels without a reading come first.
        for round in 0..9 {
            for pair in window[round % 2..].chunks_exact_mut(2) {
                let [low, high] = pair else { continue };
                for (low, high) in low.iter_mut().zip(high) {
                    (*low, *high) = ((*low).min(*high), (*low).max(*high));
                }
            }
        }
        let middles = &rows[1][1..=filtered.len()];
        filtered.copy_from_slice(&window[4]);
        for (place, pixels) in window.iter().enumerate().skip(5) {
            for ((filtered, pixel), n) in filtered.iter_mut().zip(pixels).zip(n_without.iter()) {
                // The lower middle one of those with a reading: place n + (8 - n) / 2 where n have none.
                let wanted = (8 + *n) / 2;
                *filtered = if wanted == place as u16 { *pixel } else { *filtered };
            }
        }
        for (filtered, middle) in filtered.iter_mut().zip(middles) {
            *filtered = if *middle == 0 { 0 } else { *filtered };
        }
    }
}
