//! Where to look from next: where places that look alike from here would look different, or where there is more to see.
//!
//! A move is a turn and one straight way through what is seen to be free. Of those after which the map expects the
//! candidates to look different, a short one is taken; where there is none, the first of several that do it together.

use super::expected_views::{ExpectedViews, Parting};
use super::matching::Knowledge;
use super::open_ways::{NextMove, open_moves};
use super::panorama::Panorama;
use rumbo_core::frames::{Point2, Pose2};
use std::collections::BTreeSet;
use std::f64::consts::TAU;

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

/// What is seen, and what is known of the place.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// The map.
    pub known: &'a Knowledge,
    /// All that is seen.
    pub panorama: &'a Panorama,
    /// Where the robot may be.
    pub candidates: &'a [Pose2],
    /// Where it looked from, in the frame of the base.
    pub looked_from: &'a [Point2],
}

/// Ends of ways of one length lie this near to each other, meters: first moves, and those after them.
const BETWEEN_ENDS_M: [f64; 2] = [0.1, 0.25];
/// Multiples of the way that are tried one after the other: a room may be small, and a door far.
const WAYS: [f64; 7] = [1.0, 0.5, 2.0, 3.0, 4.0, 5.0, 6.0];
/// Those of later moves.
const LATER_WAYS: [f64; 3] = [1.0, 2.0, 4.0];
/// More directions are never tried.
const MOST_DIRECTIONS: f64 = 720.0;
/// Farther ahead than so many moves nothing is looked for.
const MOST_MOVES: u32 = 3;
/// Of more candidates only the first are looked at several moves ahead.
const MOST_AHEAD: usize = 4;
/// A place that leaves no more than this share of the candidates is worth going to.
const WORTH_SHARE: f64 = 0.75;
/// Places nearer to each other than this show the same, meters.
const ELSEWHERE_M: f64 = 0.6;
/// Multiples of the way after which more may be seen; the last are for those who can hardly move.
const WAYS_TO_SEE_MORE: [&[f64]; 3] = [&[1.0, 2.0], &[0.5], &[0.25]];
/// Directions in which they are tried.
const N_DIRECTIONS: usize = 72;
/// What stands nearer than this hides much, meters.
const NEAR_M: f64 = 1.5;

/// The move after which the fewest candidates are left, or the first of as few of `most_moves` as leave fewer; where no
/// candidates differ anywhere, to where the least is hidden. None where everything is shut.
pub fn next_move(at: &Situation<'_>, limits: &MoveLimits, most_moves: u32) -> Option<NextMove> {
    let mut search = Search::new(at, limits);
    search.first_moves();
    for _ in 1..most_moves.min(MOST_MOVES) {
        if search.is_worth_it() {
            break;
        }
        search.one_more_move();
    }
    let differs = |(parting, _): &Rated| parting.difference > 0.0;
    search.best.filter(differs).map(|(_, next)| next).or_else(|| to_see_more(at, limits))
}

/// How candidates are parted at a place, and the first move on the way there.
type Rated = (Parting, NextMove);

/// Looks for places from which candidates differ.
struct Search<'a> {
    at: &'a Situation<'a>,
    limits: &'a MoveLimits,
    candidates: &'a [Pose2],
    views: ExpectedViews<'a>,
    /// Places that were reached with the last move, in the frame of the base, and the first move on the way to each.
    reached: Vec<(Pose2, NextMove)>,
    /// Squares in which such places lie.
    known: BTreeSet<[i64; 2]>,
    best: Option<Rated>,
}

impl<'a> Search<'a> {
    fn new(at: &'a Situation<'a>, limits: &'a MoveLimits) -> Search<'a> {
        Search {
            at,
            limits,
            candidates: at.candidates,
            views: ExpectedViews::new(at.known, limits.reach_m),
            reached: Vec::new(),
            known: BTreeSet::new(),
            best: None,
        }
    }

    fn is_worth_it(&self) -> bool {
        let most = WORTH_SHARE * self.candidates.len() as f64;
        self.candidates.len() < 2 || self.best.is_some_and(|(parting, _)| parting.n_left <= most)
    }

    /// The best of the shortest moves that tell all candidates apart, or the best of all.
    fn first_moves(&mut self) {
        if self.candidates.len() < 2 {
            return;
        }
        for ways in WAYS {
            for next in self.open(self.at.panorama, ways, BETWEEN_ENDS_M[0]) {
                let end = next.base_from_next();
                self.rate(&end, next);
                if self.known.insert(square(&end)) {
                    self.reached.push((end, next));
                }
            }
            if self.best.is_some_and(|(parting, _)| parting.is_complete()) {
                break;
            }
        }
    }

    /// Goes on from all places that were reached. What is open there is what the map says of the best candidate: up to there
    /// they all look alike.
    fn one_more_move(&mut self) {
        let Some(best_candidate) = self.candidates.first() else { return };
        self.candidates = self.candidates.get(..MOST_AHEAD).unwrap_or(self.candidates);
        for (place, first) in std::mem::take(&mut self.reached) {
            let there = Panorama::expected(self.at.known, &(best_candidate * place), self.limits.reach_m);
            for ways in LATER_WAYS {
                for next in self.open(&there, ways, BETWEEN_ENDS_M[1]) {
                    let end = place * next.base_from_next();
                    if self.known.insert(square(&end)) {
                        self.rate(&end, first);
                        self.reached.push((end, first));
                    }
                }
            }
        }
    }

    fn open(&self, panorama: &Panorama, ways: f64, between_ends_m: f64) -> Vec<NextMove> {
        let way_m = self.limits.way_m * ways;
        let n_directions = (TAU * way_m / between_ends_m).ceil().min(MOST_DIRECTIONS) as usize;
        open_moves(panorama, n_directions, way_m, self.limits.radius_m).collect()
    }

    fn rate(&mut self, base_from_place: &Pose2, first: NextMove) {
        let parting = self.views.parting(self.candidates, base_from_place);
        if self.best.is_none_or(|(so_far, _)| parting.is_better_than(&so_far)) {
            self.best = Some((parting, first));
        }
    }
}

/// Which square of a quarter of a meter a place lies in.
fn square(place: &Pose2) -> [i64; 2] {
    [place.translation.x, place.translation.y].map(|part| (part / BETWEEN_ENDS_M[1]).floor() as i64)
}

/// To where the least is hidden by things that are near: as far as is preferred, if any way is open so far, and where the robot
/// has not been yet, if there is such a place.
fn to_see_more(at: &Situation<'_>, limits: &MoveLimits) -> Option<NextMove> {
    let is_elsewhere = |next: &NextMove| {
        let end = Point2::from(next.base_from_next().translation.vector);
        at.looked_from.iter().all(|from| (from - end).norm() >= ELSEWHERE_M.min(0.9 * next.way_m))
    };
    let hidden = |next: &NextMove| {
        let end = Point2::from(next.base_from_next().translation.vector);
        at.panorama.hidden_share(end, NEAR_M)
    };
    // Of those that are alike the first is taken, with the smallest turn.
    let least_hidden = |moves: &mut dyn Iterator<Item = NextMove>| {
        moves.map(|next| (hidden(&next), next)).min_by(|(a, _), (b, _)| a.total_cmp(b)).map(|(_, next)| next)
    };
    let of_length = |ways: &f64| open_moves(at.panorama, N_DIRECTIONS, limits.way_m * ways, limits.radius_m);
    let open = |ways: &'static [f64]| ways.iter().flat_map(of_length);
    let elsewhere =
        WAYS_TO_SEE_MORE.into_iter().find_map(|ways| least_hidden(&mut open(ways).filter(is_elsewhere)));
    elsewhere.or_else(|| WAYS_TO_SEE_MORE.into_iter().find_map(|ways| least_hidden(&mut open(ways))))
}
