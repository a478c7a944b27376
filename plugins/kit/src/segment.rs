//! The cells that a straight segment passes through.

/// Pieces of a segment shorter than this (in cells) only touch a corner.
const TOUCH: f64 = 1e-9;

/// Visits every cell whose interior the segment from `a` to `b` crosses, in order; corners that are only touched do not
/// count, and a piece along an edge counts for both cells beside it. Stops when `visit(col, row)` says false, and tells
/// whether it never did. Coordinates are in cells.
pub fn all_cells_crossed(a: [f64; 2], b: [f64; 2], mut visit: impl FnMut(i64, i64) -> bool) -> bool {
    let delta = [b[0] - a[0], b[1] - a[1]];
    let length = delta[0].hypot(delta[1]);
    if !length.is_finite() {
        return false;
    }
    let at = |distance: f64, axis: usize| {
        if length > 0.0 { a[axis] + delta[axis] * (distance / length) } else { a[axis] }
    };
    let mut edges = [Edges::new(a[0], delta[0], length), Edges::new(a[1], delta[1], length)];
    let mut begin = 0.0;
    while begin <= length {
        let end = edges[0].distance.min(edges[1].distance).min(length);
        if end - begin > TOUCH || length <= TOUCH {
            let middle = 0.5 * (begin + end);
            for row in cells_at(at(middle, 1)) {
                for col in cells_at(at(middle, 0)) {
                    if !visit(col, row) {
                        return false;
                    }
                }
            }
        }
        if end >= length {
            break;
        }
        begin = end;
        for edge in &mut edges {
            edge.pass(begin);
        }
    }
    true
}

/// The cell of a coordinate, or both cells when it lies on an edge.
fn cells_at(coordinate: f64) -> std::ops::RangeInclusive<i64> {
    (coordinate - TOUCH).floor() as i64..=(coordinate + TOUCH).floor() as i64
}

/// The next edge that the segment crosses along one axis.
struct Edges {
    origin: f64,
    per_length: f64,
    next: f64,
    step: f64,
    distance: f64,
}

impl Edges {
    fn new(origin: f64, delta: f64, length: f64) -> Self {
        let (next, step) =
            if delta > 0.0 { (origin.floor() + 1.0, 1.0) } else { (origin.ceil() - 1.0, -1.0) };
        let per_length = if delta == 0.0 { f64::INFINITY } else { length / delta };
        let mut edges = Self { origin, per_length, next, step, distance: f64::INFINITY };
        edges.measure();
        edges
    }

    fn measure(&mut self) {
        let is_crossed = self.per_length.is_finite();
        self.distance = if is_crossed { (self.next - self.origin) * self.per_length } else { f64::INFINITY };
    }

    fn pass(&mut self, distance: f64) {
        while self.distance <= distance {
            self.next += self.step;
            self.measure();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;
    use std::collections::BTreeSet;

    fn crossed(a: [f64; 2], b: [f64; 2]) -> Vec<(i64, i64)> {
        let mut cells = Vec::new();
        assert!(all_cells_crossed(a, b, |col, row| {
            cells.push((col, row));
            true
        }));
        cells
    }

    #[test]
    fn corners_are_not_crossed_and_edges_count_for_both_sides() {
        assert_eq!(crossed([0.5, 0.5], [2.5, 2.5]), [(0, 0), (1, 1), (2, 2)]);
        assert_eq!(crossed([2.5, 0.5], [0.5, 2.5]), [(2, 0), (1, 1), (0, 2)]);
        assert_eq!(crossed([0.5, 0.5], [2.5, 0.5]), [(0, 0), (1, 0), (2, 0)]);
        assert_eq!(crossed([0.5, 1.0], [1.5, 1.0]), [(0, 0), (0, 1), (1, 0), (1, 1)]);
        assert_eq!(crossed([0.5, 0.5], [0.5, 0.5]), [(0, 0)]);
        assert_eq!(crossed([0.5, 0.5], [2.5, 1.5]), [(0, 0), (1, 0), (1, 1), (2, 1)]);
    }

    #[test]
    fn random_segments_cross_the_cells_of_finely_spaced_points() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(41);
        for _ in 0..500 {
            let mut point = || [rng.random_range(-9.0..9.0_f64), rng.random_range(-9.0..9.0_f64)];
            let (a, b) = (point(), point());
            let found: BTreeSet<(i64, i64)> = crossed(a, b).into_iter().collect();
            let mut sampled = BTreeSet::new();
            for i in 0..=20_000 {
                let t = f64::from(i) / 20_000.0;
                let at = |k: usize| (a[k] + (b[k] - a[k]) * t).floor() as i64;
                sampled.insert((at(0), at(1)));
            }
            assert!(sampled.is_subset(&found), "{a:?} to {b:?}");
            // Samples miss only slivers at corners.
            assert!(found.len() <= sampled.len() + 1, "{a:?} to {b:?}");
        }
    }

    #[test]
    fn what_is_not_finite_is_never_clear() {
        assert!(!all_cells_crossed([f64::NAN, 0.0], [1.0, 1.0], |_, _| true));
        assert!(!all_cells_crossed([0.0, 0.0], [f64::INFINITY, 1.0], |_, _| true));
    }
}
