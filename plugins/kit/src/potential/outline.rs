//! Which sides of an outline are one obstacle.
//!
//! The repulsion (6) has one nearest point for each obstacle. Where an obstacle bends outwards, as at the corner of a rack,
//! the nearest point moves steadily with the robot; in a corner of a room it would jump from wall to wall, and the force
//! with it. So outlines are parted where they bend inwards: a rack is one obstacle, and the walls of a room are four. A
//! part does not bend outwards by more than three quarters of a turn, unless it is a whole outline, so that none comes
//! round to face itself.

use std::f64::consts::{FRAC_PI_6, PI};
use std::ops::Range;

/// An outline that has bent inwards by more than this is parted, radians.
const LARGEST_INWARD_RAD: f64 = FRAC_PI_6;
/// A part that would bend outwards by more than this is parted, radians.
const LARGEST_OUTWARD_RAD: f64 = 1.25 * PI;

/// Parts of a closed outline, as ranges of its sides: side i leads from corner i to corner i + 1, and sides beyond the
/// last count on from the first. `turns_rad[i]` is how far the outline turns at corner i, left (inwards: free space is
/// on the left) above zero.
pub(super) fn parts(turns_rad: &[f64]) -> Vec<Range<usize>> {
    let n = turns_rad.len();
    let is_inward = |turn_rad: &f64| *turn_rad > LARGEST_INWARD_RAD;
    let Some(first) = turns_rad.iter().position(is_inward).or_else(|| bends_inward_slowly(turns_rad)) else {
        return std::iter::once(0..n).filter(|whole| !whole.is_empty()).collect();
    };
    let mut parts = Vec::new();
    let (mut begin, mut bent_rad, mut least_rad) = (first, 0.0_f64, 0.0_f64);
    for corner in first + 1..first + n {
        bent_rad += turns_rad[corner % n];
        least_rad = bent_rad.min(least_rad);
        if bent_rad - least_rad > LARGEST_INWARD_RAD || bent_rad < -LARGEST_OUTWARD_RAD {
            parts.push(begin..corner);
            (begin, bent_rad, least_rad) = (corner, 0.0, 0.0);
        }
    }
    parts.push(begin..first + n);
    parts
}

/// A corner where an outline without sharp inward corners has bent inwards too far all the same: a round room.
fn bends_inward_slowly(turns_rad: &[f64]) -> Option<usize> {
    let (mut bent_rad, mut least_rad) = (0.0_f64, 0.0_f64);
    turns_rad.iter().position(|turn_rad| {
        bent_rad += turn_rad;
        least_rad = least_rad.min(bent_rad);
        bent_rad - least_rad > LARGEST_INWARD_RAD
    })
}

/// How far a way turns from one leg to the next, radians, left above zero.
pub(super) fn turn_rad(before: [f64; 2], after: [f64; 2]) -> f64 {
    let cross = before[0] * after[1] - before[1] * after[0];
    let dot = before[0] * after[0] + before[1] * after[1];
    cross.atan2(dot)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const LEFT: f64 = FRAC_PI_2;
    const RIGHT: f64 = -FRAC_PI_2;

    #[test]
    fn a_rack_is_whole_and_a_room_is_four_walls() {
        assert_eq!(parts(&[RIGHT; 4]), std::slice::from_ref(&(0..4)));
        assert_eq!(parts(&[LEFT; 4]), [0..1, 1..2, 2..3, 3..4]);
        assert!(parts(&[]).is_empty());
    }

    #[test]
    fn a_room_with_a_spur_has_the_spur_for_itself() {
        // The spur's three sides stand in the last wall.
        let turns = [LEFT, LEFT, LEFT, LEFT, LEFT, RIGHT, RIGHT, LEFT];
        assert_eq!(parts(&turns), [0..1, 1..2, 2..3, 3..4, 4..7, 7..8]);
    }

    #[test]
    fn a_round_room_is_parted_and_a_round_pillar_is_not() {
        let many = [PI / 18.0; 36];
        let found = parts(&many);
        assert!((9..=12).contains(&found.len()), "{found:?}");
        assert_eq!(found.iter().map(ExactSizeIterator::len).sum::<usize>(), 36);
        assert_eq!(parts(&many.map(|turn| -turn)).len(), 1);
    }

    #[test]
    fn an_angle_does_not_face_itself() {
        // An L: one inward corner, five outward ones.
        let found = parts(&[RIGHT, RIGHT, RIGHT, LEFT, RIGHT, RIGHT]);
        assert_eq!(found, [3..6, 6..9]);
    }

    #[test]
    fn turns_have_their_sign() {
        assert!((turn_rad([1.0, 0.0], [0.0, 2.0]) - LEFT).abs() < 1e-12);
        assert!((turn_rad([1.0, 0.0], [0.0, -2.0]) - RIGHT).abs() < 1e-12);
    }
}
