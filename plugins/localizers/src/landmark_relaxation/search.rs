//! The course of a search: look all around, judge, move where that helps, and look again; never without end.

use super::locator::{Hypothesis, Locator, Report, Verdict};
use super::matching::{Knowledge, is_one};
use super::motion::Motion;
use super::next_move::{MoveLimits, Situation, next_move};
use super::open_ways::NextMove;
use super::sighting::Sighting;
use rumbo_core::frames::{Point2, Pose2, wrap_angle};
use rumbo_core::messages::Wish;
use rumbo_core::time::Time;
use std::f64::consts::{PI, TAU};

/// What a search may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SearchSettings {
    /// It may ask for motion.
    pub moves: bool,
    /// It looks again from another place so often.
    pub most_moves: u32,
    /// The robot, and how far it goes.
    pub limits: MoveLimits,
}

/// Where a search is.
#[derive(Debug)]
enum Phase {
    /// Gathering scans, turning between them.
    Looking(Option<Motion>),
    /// On the way to another place: this first, and then so far ahead.
    Moving(Motion, Option<f64>),
    /// The robot was found.
    Found(Hypothesis, Sighting),
    /// Nothing more is asked for; looks again when the robot is brought elsewhere.
    Ended(Pose2),
}

/// What a search says.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// Looking, and this motion helps.
    Looking(Wish),
    /// The robot is there, at the odometer's pose given.
    Found(Hypothesis, Sighting),
    /// It may be at one of these places, as seen from where it is now; motion may help.
    Ambiguous(Vec<Hypothesis>, Option<Wish>),
    /// No place fits; motion may help.
    Lost(Option<Wish>),
}

/// The only place that fits, but not well enough.
#[derive(Debug, Clone, Copy)]
struct Doubtful {
    map_from_base: Pose2,
    /// The odometer there.
    odom_from_base: Pose2,
    /// The odometer where it was first found to fit.
    first_from: Pose2,
}

/// A search.
#[derive(Debug)]
pub struct Search {
    settings: SearchSettings,
    locator: Locator,
    phase: Phase,
    sightings: Vec<Sighting>,
    odom_from_base: Option<Pose2>,
    /// Places that fit, and the odometer's pose there.
    candidates: Option<(Vec<Hypothesis>, Pose2)>,
    doubtful: Option<Doubtful>,
    has_failed: bool,
    n_moves: u32,
    /// Where the odometer was at each verdict.
    looked_from: Vec<Pose2>,
}

/// A view that covers a turn but for this much covers it, radians.
const NEARLY_RAD: f64 = 0.1;
/// The odometer moves by less than this between two readings, meters, unless it was started anew.
const JUMP_M: f64 = 1.0;
/// A look from nearer than this says the same again, meters.
const LEAST_WAY_M: f64 = 0.75;
/// A robot that was brought this far since looks again: meters, and radians.
const ELSEWHERE: [f64; 2] = [0.5, 0.5];

impl Search {
    /// A search that has seen nothing yet.
    pub fn new(settings: SearchSettings, locator: Locator) -> Search {
        Search {
            settings,
            locator,
            phase: Phase::Looking(None),
            sightings: Vec::new(),
            odom_from_base: None,
            candidates: None,
            doubtful: None,
            has_failed: false,
            n_moves: 0,
            looked_from: Vec::new(),
        }
    }

    /// Numbers of the last verdict.
    pub fn report(&self) -> Report {
        self.locator.report()
    }

    /// How often it went to look from elsewhere.
    pub fn n_moves(&self) -> u32 {
        self.n_moves
    }

    /// Takes in where the odometer is.
    pub fn follow(&mut self, odom_from_base: Pose2, now: Time) {
        let last = self.odom_from_base.replace(odom_from_base);
        let way_m = last.map_or(0.0, |last| apart(&last, &odom_from_base)[0]);
        if way_m.is_nan() || way_m > JUMP_M {
            // What was seen before cannot be joined to what comes.
            self.look_anew();
            (self.candidates, self.doubtful) = (None, None);
            self.looked_from.clear();
        }
        match &mut self.phase {
            Phase::Looking(Some(motion)) => {
                motion.follow(odom_from_base, now);
                if motion.is_over(now) {
                    self.phase = Phase::Looking(None);
                }
            }
            Phase::Moving(motion, ahead) => {
                motion.follow(odom_from_base, now);
                if motion.is_over(now) {
                    match ahead.take() {
                        Some(way_m) => *motion = Motion::new(Wish::MoveBy(way_m), odom_from_base, now),
                        None => self.look_anew(),
                    }
                }
            }
            Phase::Ended(at) => {
                let [way_m, turn_rad] = apart(at, &odom_from_base);
                if way_m >= ELSEWHERE[0] || turn_rad >= ELSEWHERE[1] {
                    self.look_anew();
                    self.looked_from.clear();
                }
            }
            Phase::Looking(None) | Phase::Found(..) => {}
        }
    }

    fn look_anew(&mut self) {
        self.sightings.clear();
        self.phase = Phase::Looking(None);
    }

    /// Takes in a scan.
    pub fn look(&mut self, known: &Knowledge, sighting: Sighting, now: Time) {
        let Phase::Looking(None) = self.phase else { return };
        let odom_from_base = sighting.odom_from_base;
        let (n_views, turn_rad) = views(sighting.view_rad());
        self.sightings.push(sighting);
        if self.settings.moves && self.sightings.len() < n_views {
            let motion = Motion::new(Wish::TurnBy(turn_rad), odom_from_base, now);
            self.phase = Phase::Looking(Some(motion));
            return;
        }
        match self.verdict(known) {
            Verdict::Found(place) => {
                let Some(sighting) = self.sightings.pop() else { return };
                self.candidates = None;
                self.phase = Phase::Found(place, sighting);
            }
            Verdict::Ambiguous(places) => {
                (self.candidates, self.doubtful) = (Some((places, odom_from_base)), None);
                self.move_on(known, odom_from_base, now);
            }
            Verdict::Doubtful(place) => {
                let map_from_base = place.map_from_base;
                let again =
                    self.doubtful.filter(|old| is_one(&old.carried_to(&odom_from_base), &map_from_base));
                let first_from = again.map_or(odom_from_base, |old| old.first_from);
                let doubtful = Doubtful { map_from_base, odom_from_base, first_from };
                (self.candidates, self.doubtful) = (None, Some(doubtful));
                self.has_failed = false;
                self.move_on(known, odom_from_base, now);
            }
            Verdict::Nothing => {
                (self.candidates, self.doubtful) = (None, None);
                self.has_failed = true;
                self.move_on(known, odom_from_base, now);
            }
        }
    }

    /// Known candidates are judged by what is seen now; where none of them fits any more, the whole map is searched.
    fn verdict(&mut self, known: &Knowledge) -> Verdict {
        let newest = self.sightings.last().map_or(Pose2::identity(), |sighting| sighting.odom_from_base);
        if let Some((candidates, odom_from_base)) = &self.candidates
            && !self.locator.settings().is_thesis
        {
            let moved = odom_from_base.inverse() * newest;
            let poses: Vec<Pose2> =
                candidates.iter().map(|candidate| candidate.map_from_base * moved).collect();
            let verdict = self.locator.judge(known, &self.sightings, &poses);
            if verdict != Verdict::Nothing {
                return verdict;
            }
        }
        let is_elsewhere = |doubtful: &Doubtful| apart(&doubtful.first_from, &newest)[0] >= LEAST_WAY_M;
        let expected = self.doubtful.filter(is_elsewhere).map(|doubtful| doubtful.carried_to(&newest));
        self.locator.locate(known, &self.sightings, expected)
    }

    fn move_on(&mut self, known: &Knowledge, odom_from_base: Pose2, now: Time) {
        let may_move = self.settings.moves && self.n_moves < self.settings.most_moves;
        let poses: Vec<Pose2> =
            self.candidates.iter().flat_map(|(places, _)| places).map(|place| place.map_from_base).collect();
        self.looked_from.push(odom_from_base);
        let base_from_odom = odom_from_base.inverse();
        let looked_from: Vec<Point2> =
            self.looked_from.iter().map(|pose| (base_from_odom * pose).translation.vector.into()).collect();
        let panorama = &self.locator.panorama(&self.sightings);
        let at = Situation { known, panorama, candidates: &poses, looked_from: &looked_from };
        let n_left = self.settings.most_moves.saturating_sub(self.n_moves);
        let next = may_move.then(|| next_move(&at, &self.settings.limits, n_left)).flatten();
        self.phase = match next {
            Some(NextMove { turn_rad, way_m }) => {
                self.n_moves += 1;
                Phase::Moving(Motion::new(Wish::TurnBy(turn_rad), odom_from_base, now), Some(way_m))
            }
            None => Phase::Ended(odom_from_base),
        };
    }

    /// What is to be said now.
    pub fn progress(&self) -> Progress {
        let wish = match &self.phase {
            Phase::Found(place, sighting) => return Progress::Found(place.clone(), sighting.clone()),
            Phase::Looking(None) => Some(Wish::HoldStill),
            Phase::Looking(Some(motion)) | Phase::Moving(motion, _) => Some(motion.wish()),
            Phase::Ended(_) => None,
        };
        let wish = wish.filter(|_| self.settings.moves);
        if let Some((candidates, odom_from_base)) = &self.candidates {
            let moved = self.odom_from_base.map_or(Pose2::identity(), |now| odom_from_base.inverse() * now);
            let carried = |place: &Hypothesis| Hypothesis {
                map_from_base: place.map_from_base * moved,
                ..place.clone()
            };
            return Progress::Ambiguous(candidates.iter().map(carried).collect(), wish);
        }
        match self.phase {
            Phase::Looking(_) | Phase::Moving(..) if !self.has_failed => {
                Progress::Looking(wish.unwrap_or(Wish::HoldStill))
            }
            _ => Progress::Lost(wish),
        }
    }
}

impl Doubtful {
    fn carried_to(&self, odom_from_base: &Pose2) -> Pose2 {
        self.map_from_base * (self.odom_from_base.inverse() * odom_from_base)
    }
}

/// How many views of this width are needed to see all around, and the turn between them.
fn views(view_rad: f64) -> (usize, f64) {
    if view_rad >= TAU - NEARLY_RAD {
        return (1, 0.0);
    }
    if view_rad >= PI - NEARLY_RAD {
        return (2, PI);
    }
    // Less than a tenth of a turn is no view that anybody could turn around with.
    let n_views = (TAU / view_rad.max(TAU / 10.0)).ceil();
    (n_views as usize, TAU / n_views)
}

/// How far two poses are apart: meters, and radians.
fn apart(one: &Pose2, other: &Pose2) -> [f64; 2] {
    let way_m = (one.translation.vector - other.translation.vector).norm();
    [way_m, wrap_angle(one.rotation.angle() - other.rotation.angle()).abs()]
}
