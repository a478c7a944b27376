//! Corners by recursive end-point fit. Hernández Alamilla (2005), section 4.4.2; the method is that of Duda and Hart,
//! *Pattern Classification and Scene Analysis* (1973), section 9.2.

use super::readings::{Reading, cross, way};

/// Parts the segment from reading `first` to `last` at its corners and visits its straight pieces from the right to the
/// left. `pending` is scratch memory. All readings of a segment are valid.
pub(super) fn straight_pieces(
    readings: &[Reading],
    [first, last]: [usize; 2],
    corner_m: f64,
    pending: &mut Vec<[usize; 2]>,
    mut visit: impl FnMut(&[Reading], [usize; 2]),
) {
    pending.clear();
    pending.push([first, last]);
    while let Some([from, to]) = pending.pop() {
        let Some(piece) = readings.get(from..=to) else { continue };
        match corner_of(piece, corner_m) {
            // The piece to the right is on top of the pile: it comes next.
            Some(corner) => pending.extend([[from + corner, to], [from, from + corner]]),
            None => visit(piece, [from, to]),
        }
    }
}

/// The reading farthest from the chord, if it is farther than `corner_m`. Both ends are never corners.
fn corner_of(piece: &[Reading], corner_m: f64) -> Option<usize> {
    let [first, inner @ .., last] = piece else { return None };
    let chord = way(first, last);
    let length = chord[0].hypot(chord[1]);
    let mut farthest = (0, corner_m);
    for (idx, reading) in inner.iter().enumerate() {
        let from_first = way(first, reading);
        let distance = if length > 0.0 {
            cross(chord, from_first).abs() / length
        } else {
            from_first[0].hypot(from_first[1])
        };
        if distance > farthest.1 {
            farthest = (idx + 1, distance);
        }
    }
    (farthest.0 > 0).then_some(farthest.0)
}
