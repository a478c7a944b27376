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
        let MedianFilter { rows, window } = self.filter;
        let filtered = self.filtered;
        for (idx, pixels) in window.iter_mut().enumerate() {
            pixels.copy_from_slice(&rows[idx / 3][idx % 3..idx % 3 + filtered.len()]);
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
        filtered.copy_from_slice(&window[8]);
        // The lower middle one of those with a reading: place 4 where at most one has none (so that place 1 has one), 5
        // where at most three have none, and so on.
        for (seen, place) in [(7, 7), (5, 6), (3, 5), (1, 4)] {
            let pixels = window[seen].iter().zip(&window[place]);
            for (filtered, (seen, pixel)) in filtered.iter_mut().zip(pixels) {
                *filtered = if *seen > 0 { *pixel } else { *filtered };
            }
        }
        let middles = &rows[1][1..=filtered.len()];
        for (filtered, middle) in filtered.iter_mut().zip(middles) {
            *filtered = if *middle == 0 { 0 } else { *filtered };
        }
    }
}
