//! What would be seen from other places, and how well that would tell candidates apart.

use super::matching::Knowledge;
use rumbo_core::frames::Pose2;
use std::f64::consts::TAU;

/// How a look from somewhere would part candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parting {
    /// How many candidates would still look like the true one, itself included, when each is as likely as the others.
    pub n_left: f64,
    /// Share of rays by which two of them differ, on average.
    pub difference: f64,
}

/// Numbers that differ by less are the same.
const ROUNDING: f64 = 1e-9;

impl Parting {
    /// Nothing is learned.
    pub fn none(n_candidates: usize) -> Parting {
        Parting { n_left: n_candidates as f64, difference: 0.0 }
    }

    /// Fewer are left, or as many with larger differences.
    pub fn is_better_than(&self, other: &Parting) -> bool {
        let fewer = other.n_left - self.n_left;
        fewer > ROUNDING || fewer > -ROUNDING && self.difference > other.difference + ROUNDING
    }

    /// One is left, whichever is the true one.
    pub fn is_complete(&self) -> bool {
        self.n_left <= 1.0 + ROUNDING
    }
}

/// Rays of the views that are compared.
const N_RAYS: usize = 90;
/// Ranges in two views that differ by more than this are different, meters.
const DIFFERENT_M: f64 = 0.20;
/// Views are different when this share of their rays is.
const LEAST_DIFFERENT: f64 = 0.10;

/// Compares views; keeps its memory.
#[derive(Debug)]
pub struct ExpectedViews<'a> {
    known: &'a Knowledge,
    directions: Vec<[f64; 2]>,
    reach_m: f64,
    views: Vec<Vec<f64>>,
}

impl<'a> ExpectedViews<'a> {
    /// Views on a map, with a scanner of this reach.
    pub fn new(known: &'a Knowledge, reach_m: f64) -> ExpectedViews<'a> {
        let direction = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / N_RAYS as f64).sin_cos();
            [cos, sin]
        };
        let directions = (0..N_RAYS).map(direction).collect();
        ExpectedViews { known, directions, reach_m, views: Vec::new() }
    }

    /// How candidates would be parted by a look from a place that each of them has beside it.
    pub fn parting(&mut self, candidates: &[Pose2], base_from_there: &Pose2) -> Parting {
        let n = candidates.len();
        let mut views = std::mem::take(&mut self.views);
        views.resize(n.max(views.len()), Vec::new());
        for (candidate, view) in candidates.iter().zip(&mut views) {
            self.view(&(candidate * base_from_there), view);
        }
        let (mut n_alike, mut sum) = (n, 0.0);
        for (idx, one) in views.iter().take(n).enumerate() {
            for other in views.iter().take(n).skip(idx + 1) {
                let share = difference(one, other);
                sum += share;
                n_alike += if share < LEAST_DIFFERENT { 2 } else { 0 };
            }
        }
        self.views = views;
        let n_pairs = (n * n.saturating_sub(1) / 2).max(1);
        Parting { n_left: n_alike as f64 / n.max(1) as f64, difference: sum / n_pairs as f64 }
    }

    fn view(&self, map_from_base: &Pose2, ranges_m: &mut Vec<f64>) {
        self.known.scan(map_from_base, &self.directions, self.reach_m, ranges_m);
        // What nobody knows cannot be told from anything.
        ranges_m.iter_mut().filter(|range| range.is_nan()).for_each(|range| *range = f64::INFINITY);
    }
}

/// Share of rays by which two views differ.
fn difference(one: &[f64], other: &[f64]) -> f64 {
    let is_different = |(a, b): &(&f64, &f64)| !((*a - *b).abs() <= DIFFERENT_M || *a == *b);
    one.iter().zip(other).filter(is_different).count() as f64 / N_RAYS as f64
}
