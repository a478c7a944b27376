//! What tells landmarks apart whatever the heading: kind, distance and extent.

use crate::landmarks::{Landmark, LandmarkKind, Side};

/// Kinds that are told apart; corners have no extent and are not used (section 7.1 of the source).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum LookKind {
    /// A discontinuity that hides its left.
    HidesLeft,
    /// A discontinuity that hides its right.
    HidesRight,
    /// A wall.
    Wall,
}

/// A landmark without its bearing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// What it is.
    pub kind: LookKind,
    /// Distance, meters (D in the source).
    pub distance_m: f64,
    /// Jump or length, meters (P).
    pub extent_m: f64,
}

/// Steps of distances, meters: finer than a cell, within which they change by more.
pub(super) const DISTANCE_STEP_M: f64 = 0.02;
/// Steps of extents, meters.
pub(super) const EXTENT_STEP_M: f64 = 0.04;
/// Bits of each of them.
const BITS: u32 = 13;
/// The largest that can be kept; what is larger counts as this: 163.82 m and 327.64 m.
const MOST: u32 = (1 << BITS) - 1;

impl Look {
    /// What a landmark looks like; none for a corner.
    pub fn of(landmark: &Landmark) -> Option<Look> {
        let (kind, extent_m) = match landmark.kind {
            LandmarkKind::Discontinuity { hidden: Side::Left, jump_m, .. } => (LookKind::HidesLeft, jump_m),
            LandmarkKind::Discontinuity { hidden: Side::Right, jump_m, .. } => (LookKind::HidesRight, jump_m),
            LandmarkKind::Wall { length_m, .. } => (LookKind::Wall, length_m),
            LandmarkKind::Corner { .. } => return None,
        };
        Some(Look { kind, distance_m: landmark.distance_m, extent_m })
    }

    /// What landmarks look like but for corners, counter-clockwise.
    pub fn around(landmarks: &[Landmark]) -> Vec<Look> {
        let looks = landmarks.iter().filter_map(|landmark| Some((landmark.bearing_rad, Look::of(landmark)?)));
        let mut looks: Vec<(f64, Look)> = looks.collect();
        looks.sort_by(|(a, _), (b, _)| a.total_cmp(b));
        looks.into_iter().map(|(_, look)| look).collect()
    }

    /// The same to the steps that a model keeps: 2 cm of distance, 4 cm of extent.
    pub fn rounded(self) -> Look {
        Look::of_code(self.code())
    }

    /// The most steps of distance or extent that are told apart.
    pub(super) const MOST_STEPS: u32 = MOST;

    /// Whole steps of distance and of extent.
    pub(super) fn steps(self) -> [u32; 2] {
        let steps = |meters: f64, step_m: f64| ((meters / step_m).round() as u32).min(MOST);
        [steps(self.distance_m, DISTANCE_STEP_M), steps(self.extent_m, EXTENT_STEP_M)]
    }

    /// As one number, sorted by kind, distance and extent.
    pub(super) fn code(self) -> u32 {
        let [distance, extent] = self.steps();
        code_of(self.kind, distance, extent)
    }

    fn of_code(code: u32) -> Look {
        let kind = match code >> (2 * BITS) {
            0 => LookKind::HidesLeft,
            1 => LookKind::HidesRight,
            _ => LookKind::Wall,
        };
        let (distance, extent) = (f64::from(code >> BITS & MOST), f64::from(code & MOST));
        Look { kind, distance_m: distance * DISTANCE_STEP_M, extent_m: extent * EXTENT_STEP_M }
    }
}

/// The number of a look in whole steps.
pub(super) fn code_of(kind: LookKind, distance: u32, extent: u32) -> u32 {
    (kind as u32) << (2 * BITS) | distance.min(MOST) << BITS | extent.min(MOST)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_the_nearest_step_and_the_order() {
        for kind in [LookKind::HidesLeft, LookKind::HidesRight, LookKind::Wall] {
            for (distance_m, extent_m) in [(0.0, 0.0), (7.994, 0.304), (40.0, 81.0), (3.005, 2.996)] {
                let look = Look { kind, distance_m, extent_m };
                let back = look.rounded();
                assert_eq!(back.kind, kind);
                assert!((back.distance_m - distance_m).abs() <= 0.5 * DISTANCE_STEP_M + 1e-9);
                assert!((back.extent_m - extent_m).abs() <= 0.5 * EXTENT_STEP_M + 1e-9);
            }
        }
        let codes = [(0, 5, 9), (0, 6, 0), (1, 0, 0), (1, 0, 1), (2, 0, 0)];
        let kinds = [LookKind::HidesLeft, LookKind::HidesRight, LookKind::Wall];
        let codes = codes.map(|(kind, distance, extent)| code_of(kinds[kind], distance, extent));
        assert!(codes.is_sorted());
        let far = Look { kind: LookKind::Wall, distance_m: 1e9, extent_m: f64::INFINITY }.rounded();
        assert!((far.distance_m - 163.82).abs() < 1e-9 && far.kind == LookKind::Wall);
    }
}
