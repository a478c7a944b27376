//! Where to look from next: where places that look alike from here would look different, or where there is more to see.

use super::matching::Knowledge;
use super::panorama::Panorama;
use rumbo_core::frames::{Pose2, pose2, wrap_angle};
use std::f64::consts::TAU;

/// A turn and then a way ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NextMove {
    /// First turn by this much, radians.
    pub turn_rad: f64,
    /// Then go so far, meters.
    pub way_m: f64,
}

/// The robot and how far it may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MoveLimits {
    /// Radius of the robot with some air around it, meters.
    pub radius_m: f64,
    /// A move of this length is tried first, meters.
    pub way_m: f64,
    /// Reach of the scanner, meters.
    pub reach_m: f64,
}

/// Directions that are tried.
const N_DIRECTIONS: usize = 24;
/// Rays of the views that are compared.
const N_RAYS: usize = 90;
/// Ranges in two views that differ by more than this are different, meters.
const DIFFERENT_M: f64 = 0.20;
/// Views are different when this share of their rays is.
const LEAST_DIFFERENT: f64 = 0.10;
/// Shares of the way that are tried: a room may be small, and a door far.
const WAY_SHARES: [f64; 3] = [1.0, 2.0, 0.5];

/// The move after which the candidates differ most; without candidates that differ anywhere, the longest that is open.
/// None where everything is shut.
pub fn next_move(
    known: &Knowledge,
    panorama: &Panorama,
    candidates: &[Pose2],
    limits: &MoveLimits,
) -> Option<NextMove> {
    let mut views = Views::new(known, limits.reach_m);
    let mut most_different: Option<(f64, NextMove)> = None;
    for share in WAY_SHARES {
        for next in open_moves(panorama, limits.way_m * share, limits.radius_m) {
            let difference = views.least_difference(candidates, &next);
            if most_different.is_none_or(|(most, _)| difference > most + 1e-9) {
                most_different = Some((difference, next));
            }
        }
        if most_different.is_some_and(|(difference, _)| difference >= LEAST_DIFFERENT) {
            break;
        }
    }
    let longest = [2.0, 1.0, 0.5]
        .into_iter()
        .find_map(|share| open_moves(panorama, limits.way_m * share, limits.radius_m).next());
    most_different.filter(|(difference, _)| *difference >= LEAST_DIFFERENT).map(|(_, next)| next).or(longest)
}

/// Moves of this length that nothing bars, those with small turns first.
fn open_moves(panorama: &Panorama, way_m: f64, radius_m: f64) -> impl Iterator<Item = NextMove> + '_ {
    let turn = |k: usize| {
        let step = TAU / N_DIRECTIONS as f64;
        let turn = step * k.div_ceil(2) as f64;
        wrap_angle(if k % 2 == 1 { turn } else { -turn })
    };
    let turns = (0..N_DIRECTIONS).map(turn);
    let open = turns.filter(move |turn_rad| panorama.is_open(*turn_rad, way_m, radius_m));
    open.map(move |turn_rad| NextMove { turn_rad, way_m })
}

/// What would be seen from other places.
struct Views<'a> {
    known: &'a Knowledge,
    directions: Vec<[f64; 2]>,
    reach_m: f64,
    first: Vec<f64>,
    other: Vec<f64>,
}

impl<'a> Views<'a> {
    fn new(known: &'a Knowledge, reach_m: f64) -> Views<'a> {
        let direction = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / N_RAYS as f64).sin_cos();
            [cos, sin]
        };
        let directions = (0..N_RAYS).map(direction).collect();
        Views { known, directions, reach_m, first: Vec::new(), other: Vec::new() }
    }

    /// Share of rays by which the view of the best candidate differs from that of the other most like it; zero with fewer
    /// than two.
    fn least_difference(&mut self, candidates: &[Pose2], next: &NextMove) -> f64 {
        let Some((best, others)) = candidates.split_first() else { return 0.0 };
        let base_from_next = pose2(0.0, 0.0, next.turn_rad) * pose2(next.way_m, 0.0, 0.0);
        let (mut first, mut other) = (std::mem::take(&mut self.first), std::mem::take(&mut self.other));
        self.view(&(best * base_from_next), &mut first);
        let mut least: f64 = 1.0;
        for candidate in others {
            self.view(&(candidate * base_from_next), &mut other);
            let is_different = |(a, b): &(&f64, &f64)| !((*a - *b).abs() <= DIFFERENT_M || *a == *b);
            let n = first.iter().zip(&other).filter(is_different).count();
            least = least.min(n as f64 / N_RAYS as f64);
        }
        (self.first, self.other) = (first, other);
        if others.is_empty() { 0.0 } else { least }
    }

    fn view(&self, map_from_base: &Pose2, ranges_m: &mut Vec<f64>) {
        self.known.scan(map_from_base, &self.directions, self.reach_m, ranges_m);
        // What nobody knows cannot be told from anything.
        ranges_m.iter_mut().filter(|range| range.is_nan()).for_each(|range| *range = f64::INFINITY);
    }
}
