//! The nearest point of a picture: Valverde Moreno (2015), section 4.1.1.2, with the distance that its results have.

use crate::simd::{Kernel, Vectors, widest};

/// The nearest point of a picture, and how much the picture held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Closest {
    /// The nearest point; none where no pixel counts.
    pub point: Option<ClosestPoint>,
    /// Pixels that had a point: a camera that is blind has none, and must not look like free space.
    pub n_valid: usize,
}

/// A point and where the picture has it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosestPoint {
    /// Column of the pixel, from 0 at the left.
    pub column: usize,
    /// Row of the pixel, from 0 at the top.
    pub row: usize,
    /// x ahead, y left, z up, meters.
    pub point_m: [f32; 3],
    /// Distance over the plane, `sqrt(x² + y²)`, meters.
    pub planar_m: f64,
    /// Direction, left of the axis positive, radians.
    pub bearing_rad: f64,
}

/// The point with the least distance over the plane of x and y; of several with the same the first, row by row from the
/// top. Points that are not numbers do not count. `single_row` looks at this row only, which makes the camera a planar
/// scanner.
pub fn closest(points_m: &[[f32; 3]], n_columns: usize, single_row: Option<usize>) -> Closest {
    let start = single_row.map_or(0, |row| row.saturating_mul(n_columns));
    let end = single_row.map_or(points_m.len(), |_| start.saturating_add(n_columns));
    let looked_at = points_m.get(start..end).unwrap_or_default();
    // The least square is found piece by piece, so that only one piece is searched for its point.
    let (mut least_m2, mut first, mut n_valid) = (f32::INFINITY, 0, 0);
    for (idx, piece) in looked_at.chunks(PIECE).enumerate() {
        let (piece_m2, n_piece) = widest(Nearest(piece));
        n_valid += n_piece;
        if piece_m2 < least_m2 {
            (least_m2, first) = (piece_m2, idx * PIECE);
        }
    }
    let is_least = |[x, y, _]: &[f32; 3]| x * x + y * y == least_m2;
    let found = looked_at.iter().enumerate().skip(first).find(|(_, point_m)| is_least(point_m));
    let point = found.filter(|_| n_valid > 0).map(|(idx, &point_m)| {
        let [x, y] = [point_m[0], point_m[1]].map(f64::from);
        let pixel = start + idx;
        ClosestPoint {
            column: pixel % n_columns,
            row: pixel / n_columns,
            point_m,
            planar_m: x.hypot(y),
            bearing_rad: y.atan2(x),
        }
    });
    Closest { point, n_valid }
}

/// The least square of the distance (not-a-number where there is no point) and the number of points.
struct Nearest<'a>(&'a [[f32; 3]]);

/// Points of a piece.
const PIECE: usize = 4096;
/// Points that are looked at together.
const LANES: usize = 32;

impl Kernel for Nearest<'_> {
    type Output = (f32, usize);

    #[inline(always)]
    fn run<V: Vectors>(self) -> (f32, usize) {
        let (chunks, rest) = self.0.as_chunks::<LANES>();
        let (mut least, mut n_valid) = ([f32::INFINITY; LANES], [0_u32; LANES]);
        for chunk in chunks {
            let mut squares_m2 = [0.0; LANES];
            for (square_m2, [x, y, _]) in squares_m2.iter_mut().zip(chunk) {
                *square_m2 = x * x + y * y;
            }
            for ((square_m2, least), n) in squares_m2.iter().zip(&mut least).zip(&mut n_valid) {
                // Not-a-number is not less than anything.
                *least = if square_m2 < least { *square_m2 } else { *least };
                *n += u32::from(*square_m2 < f32::INFINITY);
            }
        }
        for (lane, [x, y, _]) in rest.iter().enumerate() {
            let m2 = x * x + y * y;
            least[lane] = if m2 < least[lane] { m2 } else { least[lane] };
            n_valid[lane] += u32::from(m2 < f32::INFINITY);
        }
        let least = least.into_iter().fold(f32::INFINITY, f32::min);
        let n_valid = n_valid.into_iter().map(|n| n as usize).sum();
        (if n_valid > 0 { least } else { f32::NAN }, n_valid)
    }
}
