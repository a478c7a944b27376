//! Which cells may be where the robot is: the initial filter. S. Hernández Alamilla (2005), section 7.2.1.
//!
//! The score of a cell is the share of its landmarks that look like one that was observed. A cell stays when its score is
//! strictly above half of the best. Only cells that see something like the observed are ever looked at.
//!
//! Beyond the source, parts of a large map from which few of the observed pairs of landmarks are seen are left out, see
//! `regions`: the work of the filter would grow with the map.

use super::band::Band;
use super::build::{LandmarkModel, band_places};
use super::look::{DISTANCE_STEP_M, EXTENT_STEP_M, Look, LookKind, code_of};
use super::regions::RegionSearch;

/// When two landmarks look alike: same kind, and no farther apart than this.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Similarity {
    /// In distance, meters.
    pub distance_m: f64,
    /// In extent, meters.
    pub extent_m: f64,
}

/// Rounding of sums of meters must not decide.
const ROUNDING_M: f64 = 1e-9;

impl Similarity {
    /// Two landmarks look alike.
    pub fn holds(&self, a: &Look, b: &Look) -> bool {
        a.kind == b.kind
            && (a.distance_m - b.distance_m).abs() <= self.distance_m + ROUNDING_M
            && (a.extent_m - b.extent_m).abs() <= self.extent_m + ROUNDING_M
    }
}

/// A cell that passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellScore {
    /// Its index in the grid.
    pub cell: usize,
    /// Landmarks of the cell that look like an observed one.
    pub n_alike: u16,
    /// Landmarks of the cell.
    pub n_landmarks: u16,
}

impl CellScore {
    /// Whether its score is strictly more than half of the other's.
    fn is_above_half_of(&self, best: &CellScore) -> bool {
        2 * u32::from(self.n_alike) * u32::from(best.n_landmarks)
            > u32::from(best.n_alike) * u32::from(self.n_landmarks)
    }

    fn is_better_than(&self, other: &CellScore) -> bool {
        u32::from(self.n_alike) * u32::from(other.n_landmarks)
            > u32::from(other.n_alike) * u32::from(self.n_landmarks)
    }
}

/// Finds the cells that stay; keeps its memory.
#[derive(Debug, Default)]
pub struct Filter {
    n_alike: Vec<u8>,
    touched: Vec<u32>,
    ranges: Vec<[u32; 2]>,
    passed: Vec<CellScore>,
    regions: RegionSearch,
    n_parts: [usize; 2],
}

impl Filter {
    /// Cells with fewer landmarks are left out: anything looks like them.
    pub const LEAST_LANDMARKS: u8 = 2;

    /// How many parts of the map the last search looked at, and of how many.
    pub fn n_parts(&self) -> [usize; 2] {
        self.n_parts
    }

    /// The cells whose score is strictly above half of the best, in the order of the grid. `observed` is in the order in
    /// which it was seen around the robot.
    pub fn pass(&mut self, model: &LandmarkModel, observed: &[Look], within: &Similarity) -> &[CellScore] {
        self.set_ranges(observed, within);
        self.passed.clear();
        let in_band = band_places(model.n_places());
        self.n_alike.resize(in_band.min(model.n_places()), 0);
        self.regions.count(&model.regions, model.n_places(), observed, within);
        let most = self.regions.most();
        self.n_parts = [0, model.bands.len()];
        let mut best: Option<CellScore> = None;
        for (idx, (band, n_landmarks)) in
            model.bands.iter().zip(model.n_landmarks.chunks(in_band)).enumerate()
        {
            let first = idx * in_band;
            if self.regions.is_worth_it(most, first..first + in_band) {
                self.n_parts[0] += 1;
                self.count(band);
                self.score(model, first, n_landmarks, &mut best);
            }
        }
        if let Some(best) = best {
            self.passed.retain(|score| score.is_above_half_of(&best));
        }
        self.passed.sort_unstable_by_key(|score| score.cell);
        &self.passed
    }

    /// Numbers of all looks that are like an observed one, as ranges that do not overlap: no landmark counts twice.
    fn set_ranges(&mut self, observed: &[Look], within: &Similarity) {
        self.ranges.clear();
        for look in observed.iter().filter(|look| look.distance_m.is_finite() && look.extent_m.is_finite()) {
            let [near, far] = steps_around(look.distance_m, within.distance_m, DISTANCE_STEP_M);
            let [short, long] = steps_around(look.extent_m, within.extent_m, EXTENT_STEP_M);
            let of_kind = |distance: u32, extent: u32| code_of(look.kind, distance, extent);
            if short > long {
                continue;
            }
            self.ranges.extend((near..=far).map(|d| [of_kind(d, short), of_kind(d, long)]));
        }
        self.ranges.sort_unstable();
        self.ranges.dedup_by(|next, range| {
            let is_joined = next[0] <= range[1];
            if is_joined {
                range[1] = range[1].max(next[1]);
            }
            is_joined
        });
    }

    fn count(&mut self, band: &Band) {
        let Self { n_alike, touched, ranges, .. } = self;
        for [first, last] in ranges.iter() {
            band.for_each(*first..=*last, |place| {
                if let Some(n) = n_alike.get_mut(place as usize) {
                    if *n == 0 {
                        touched.push(place);
                    }
                    *n = n.saturating_add(1);
                }
            });
        }
    }

    /// Keeps those above half of the best so far, and leaves the counts at zero.
    fn score(
        &mut self,
        model: &LandmarkModel,
        first: usize,
        n_landmarks: &[u8],
        best: &mut Option<CellScore>,
    ) {
        for place in self.touched.drain(..) {
            let at = place as usize;
            let (Some(n_alike), Some(n)) = (self.n_alike.get_mut(at), n_landmarks.get(at)) else { continue };
            let (n_alike, n_landmarks) = (u16::from(std::mem::take(n_alike)), u16::from(*n));
            let cell = model.order.cell_at(first + at).filter(|_| *n >= Self::LEAST_LANDMARKS);
            let Some(cell) = cell else { continue };
            let score = CellScore { cell, n_alike, n_landmarks };
            if best.is_none_or(|best| score.is_above_half_of(&best)) {
                self.passed.push(score);
            }
            if best.is_none_or(|best| score.is_better_than(&best)) {
                *best = Some(score);
            }
        }
    }
}

/// Whole steps within a tolerance, the first and the last.
fn steps_around(middle_m: f64, within_m: f64, step_m: f64) -> [u32; 2] {
    let low = ((middle_m - within_m - ROUNDING_M) / step_m).ceil().max(0.0);
    let high = ((middle_m + within_m + ROUNDING_M) / step_m).floor().max(0.0);
    [low as u32, high as u32]
}

/// All kinds, for tests that go through them.
impl LookKind {
    /// Every kind.
    pub const ALL: [LookKind; 3] = [LookKind::HidesLeft, LookKind::HidesRight, LookKind::Wall];
}
