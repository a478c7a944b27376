//! From scans all around to a verdict: where the robot is, or where it may be.
//!
//! Landmarks name the places; in contrast to the source, the scans then refine each of the best and have the last word: a
//! place that they do not fit is not believed, and of places that they fit alike none is.

use super::fit::{Fit, FitLimits};
use super::matching::{Knowledge, MatchSettings, Matcher, Place, is_one};
use super::panorama::{Panorama, union_of_landmarks};
use super::refinement::{Refined, RefinementSettings, refine};
use super::sighting::Sighting;
use super::traced_beams::TracedBeams;
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, is_finite2};
use rumbo_core::rng::Rng;
use rumbo_kit::landmarks::{Extractor, Landmark, LandmarkNoise};

/// How places are found and judged.
#[derive(Debug, Clone, PartialEq)]
pub struct LocatorSettings {
    /// As in the source: landmarks of each scan by itself, no refinement, no judgment by the scans.
    pub is_thesis: bool,
    /// Model, filter and relaxation.
    pub matching: MatchSettings,
    /// Beyond the size of a cell.
    pub refinement: RefinementSettings,
    /// What a place must reach.
    pub limits: FitLimits,
    /// Noise on what is observed, for experiments.
    pub noise: Option<LandmarkNoise>,
}

/// A place with what speaks for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Hypothesis {
    /// The robot at the newest scan.
    pub map_from_base: Pose2,
    /// Covariance of x, y, heading in the map's axes.
    pub covariance: Matrix3<f64>,
    /// How much speaks for it, compared with others; not normalized.
    pub score: f64,
}

/// A place to be judged.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Proposal {
    map_from_base: Pose2,
    /// Enough landmarks name it.
    is_supported: bool,
}

/// A place that may be, and whether the scans speak for it: one that is not believed may still be where the robot is.
struct Judged {
    place: Hypothesis,
    is_believed: bool,
    is_sure: bool,
}

/// What scans say.
#[derive(Debug, Clone, PartialEq)]
pub enum Verdict {
    /// The robot is there.
    Found(Hypothesis),
    /// This is the only place that fits, but not well enough to be sure without another look.
    Doubtful(Hypothesis),
    /// Several places fit, best first.
    Ambiguous(Vec<Hypothesis>),
    /// No place fits.
    Nothing,
}

/// Numbers of the last search.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Report {
    /// Landmarks that were observed.
    pub n_landmarks: usize,
    /// Cells after the filter.
    pub n_cells: usize,
    /// Valid assignments of the best place.
    pub n_matches: usize,
    /// Their sum of squares, m².
    pub squared_error_m2: f64,
}

/// Finds places; keeps its memory.
#[derive(Debug)]
pub struct Locator {
    settings: LocatorSettings,
    matcher: Matcher,
    extractor: Extractor,
    rng: Rng,
    report: Report,
}

/// Beams all around that places are refined and judged by.
const N_BEAMS: usize = 360;
/// So many places are judged at most.
const MOST_PLACES: usize = 16;
/// Places with fewer matches than this share of the best are not judged.
const LEAST_MATCH_SHARE: f64 = 0.7;
/// Errors of two places differ by no more than this share when they are alike (section 10.5 of the method's description).
const SAME_ERROR_SHARE: f64 = 0.2;
/// A cell found without refinement: standard deviations of position (meters) and of the map's heading (radians).
const CELL_DEVIATION: [f64; 2] = [0.035, 0.017];

impl Locator {
    /// A locator with these settings; `rng` is for noise on landmarks only.
    pub fn new(settings: LocatorSettings, rng: Rng) -> Locator {
        let matcher = Matcher::new(settings.matching);
        let extractor = Extractor::new(settings.matching.model.landmarks);
        Locator { settings, matcher, extractor, rng, report: Report::default() }
    }

    /// Numbers of the last search.
    pub fn report(&self) -> Report {
        self.report
    }

    /// How places are found.
    pub fn settings(&self) -> &LocatorSettings {
        &self.settings
    }

    /// Joins scans with the model's resolution.
    pub fn panorama(&self, sightings: &[Sighting]) -> Panorama {
        Panorama::of(sightings, self.settings.matching.model.n_rays)
    }

    /// Searches the whole map. A place that was doubtful when the robot looked from elsewhere is sure when it fits again:
    /// that is where it `expected` to be now.
    pub fn locate(&mut self, known: &Knowledge, sightings: &[Sighting], expected: Option<Pose2>) -> Verdict {
        let observed = self.observe(sightings);
        let cells = self.matcher.cells(known, &observed);
        let places = self.matcher.places(known, &cells, &observed);
        self.report = Report {
            n_landmarks: observed.len(),
            n_cells: cells.len(),
            n_matches: places.first().map_or(0, |place| place.n_matches),
            squared_error_m2: places.first().map_or(0.0, |place| place.squared_error_m2),
        };
        if self.settings.is_thesis {
            return by_landmarks(&places);
        }
        let most = places.first().map_or(0, |place| place.n_matches) as f64;
        let is_good = |place: &&Place| place.n_matches as f64 >= LEAST_MATCH_SHARE * most;
        let proposal = |place: &Place| Proposal {
            map_from_base: place.map_from_base,
            is_supported: place.n_matches >= self.settings.limits.sure_matches,
        };
        let best = places.iter().take_while(is_good).take(MOST_PLACES).map(proposal);
        let expected_again = expected.map(|map_from_base| Proposal { map_from_base, is_supported: true });
        self.verdict(known, sightings, best.chain(expected_again), expected.as_slice())
    }

    /// Judges known candidates by new scans: the one that is left fits for the second time.
    pub fn judge(&self, known: &Knowledge, sightings: &[Sighting], poses: &[Pose2]) -> Verdict {
        let proposal = |pose: &Pose2| Proposal { map_from_base: *pose, is_supported: true };
        self.verdict(known, sightings, poses.iter().map(proposal), poses)
    }

    /// The proposals that fit best; those that are `expected` fitted before.
    fn verdict(
        &self,
        known: &Knowledge,
        sightings: &[Sighting],
        proposals: impl Iterator<Item = Proposal>,
        expected: &[Pose2],
    ) -> Verdict {
        let beams = TracedBeams::of(sightings, N_BEAMS);
        let mut fitting: Vec<Judged> =
            proposals.filter_map(|proposal| self.judged(known, &beams, &proposal)).collect();
        fitting.sort_by(|a, b| b.place.score.total_cmp(&a.place.score));
        let mut apart: Vec<Judged> = Vec::new();
        for judged in fitting {
            let is_same = |better: &Judged| is_one(&better.place.map_from_base, &judged.place.map_from_base);
            let least = apart.first().map_or(0.0, |best| best.place.score - self.settings.limits.alike);
            if judged.place.score >= least && !apart.iter().any(is_same) {
                apart.push(judged);
            }
        }
        if !apart.iter().any(|judged| judged.is_believed) {
            return Verdict::Nothing;
        }
        let is_sure = |judged: &Judged| {
            judged.is_sure || expected.iter().any(|pose| is_one(pose, &judged.place.map_from_base))
        };
        let all_sure = apart.iter().all(is_sure);
        match verdict(apart.into_iter().map(|judged| judged.place).collect()) {
            Verdict::Found(place) if !all_sure => Verdict::Doubtful(place),
            verdict => verdict,
        }
    }

    /// A pose refined and judged; none where the scans contradict it.
    fn judged(&self, known: &Knowledge, beams: &TracedBeams, proposal: &Proposal) -> Option<Judged> {
        let pose = &proposal.map_from_base;
        let limits = &self.settings.limits;
        let Refined { map_from_base, turns_rad, covariance } =
            refine(known, beams, pose, &self.settings.refinement);
        let fit = Fit::of(&beams.compare(known, &map_from_base, &turns_rad));
        let is_sane = is_finite2(&map_from_base) && covariance.iter().all(|part| part.is_finite());
        // A place that refinement leaves for another is not the place that was found.
        let stays = is_one(pose, &map_from_base);
        (is_sane && stays && !fit.is_contradicted(limits)).then(|| Judged {
            place: Hypothesis { map_from_base, covariance, score: fit.explained() },
            is_believed: fit.is_within(limits),
            is_sure: proposal.is_supported && fit.explained() >= limits.sure,
        })
    }

    fn observe(&mut self, sightings: &[Sighting]) -> Vec<Landmark> {
        let reach_m = self.settings.matching.model.range_m;
        let mut landmarks = if self.settings.is_thesis {
            union_of_landmarks(sightings, &mut self.extractor, self.settings.matching.model.step_rad())
        } else {
            self.panorama(sightings).landmarks(&mut self.extractor, reach_m)
        };
        if let Some(noise) = &self.settings.noise {
            noise.disturb(&mut landmarks, &mut self.rng);
        }
        landmarks
    }
}

/// The source's verdict: most matches, then the smallest error. Places that cannot be told apart by these are ambiguous.
pub fn by_landmarks(places: &[Place]) -> Verdict {
    let Some(best) = places.first() else { return Verdict::Nothing };
    let is_alike = |place: &&Place| {
        let most = best.squared_error_m2 * (1.0 + SAME_ERROR_SHARE) + f64::EPSILON;
        place.n_matches == best.n_matches && place.squared_error_m2 <= most
    };
    let hypothesis = |place: &Place| {
        let [place_m, map_rad] = CELL_DEVIATION;
        let scatter_rad = place.heading_scatter_rad / (place.n_matches.max(1) as f64).sqrt();
        let heading_rad = scatter_rad.hypot(map_rad);
        let deviations = Vector3::new(place_m, place_m, heading_rad);
        Hypothesis {
            map_from_base: place.map_from_base,
            covariance: Matrix3::from_diagonal(&deviations.component_mul(&deviations)),
            score: 1.0 / (place.squared_error_m2 + 1e-4),
        }
    };
    verdict(places.iter().take_while(is_alike).map(hypothesis).collect())
}

fn verdict(mut fitting: Vec<Hypothesis>) -> Verdict {
    match fitting.len() {
        0 => Verdict::Nothing,
        1 => fitting.pop().map_or(Verdict::Nothing, Verdict::Found),
        _ => Verdict::Ambiguous(fitting),
    }
}
