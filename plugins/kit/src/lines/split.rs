//! Recursive iterative end-point fit (Ramer 1972; Duda and Hart 1973), with a stack of its own in place of recursion.

use super::points::Points;
use std::ops::Range;

/// Parts a run where it bends: `found` gets the straight pieces in order. Neighbors keep the point at which they were
/// parted; pieces with fewer than `min_points` are dropped at any depth.
pub(super) fn split(
    points: &Points,
    run: Range<usize>,
    split_m: f64,
    min_points: usize,
    stack: &mut Vec<Range<usize>>,
    mut found: impl FnMut(Range<usize>),
) {
    stack.clear();
    stack.push(run);
    while let Some(piece) = stack.pop() {
        if piece.len() < min_points.max(2) {
            continue;
        }
        match bend(points, piece.clone(), split_m) {
            Some(at) => {
                stack.push(at..piece.end);
                stack.push(piece.start..at + 1);
            }
            None => found(piece),
        }
    }
}

/// The inner point that is farthest from the chord, if that is farther than `split_m`.
fn bend(points: &Points, piece: Range<usize>, split_m: f64) -> Option<usize> {
    let (x, y) = (points.x.get(piece.clone())?, points.y.get(piece.clone())?);
    let ([first_x, inner_x @ .., last_x], [first_y, inner_y @ .., last_y]) = (x, y) else { return None };
    let (chord_x, chord_y) = (last_x - first_x, last_y - first_y);
    let length_m2 = chord_x * chord_x + chord_y * chord_y;
    let (mut farthest, mut most) = (0, 0.0);
    // A closed piece has no chord: what counts is the distance from its ends.
    let is_closed = length_m2 < 1e-18;
    for (idx, (x, y)) in inner_x.iter().zip(inner_y).enumerate() {
        let (dx, dy) = (x - first_x, y - first_y);
        let off = if is_closed { dx * dx + dy * dy } else { (chord_x * dy - chord_y * dx).abs() };
        if off > most {
            (farthest, most) = (idx, off);
        }
    }
    let is_bent = if is_closed { most > split_m * split_m } else { most > split_m * length_m2.sqrt() };
    is_bent.then_some(piece.start + 1 + farthest)
}
