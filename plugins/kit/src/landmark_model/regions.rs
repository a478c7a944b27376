//! Which parts of a large map are worth a look: an index from pairs of landmarks that are seen side by side to the regions
//! from which they are seen.
//!
//! A single look is common, and the lists of cells that see one like it grow with the map. Two looks side by side are rare:
//! few regions have many of the pairs that a robot sees. Pairs are kept in coarse steps and hashed, so that a region may be
//! named too often, but never too seldom.

use super::filter::Similarity;
use super::look::{DISTANCE_STEP_M, EXTENT_STEP_M, Look};

/// Regions by what is seen side by side from them; empty for a small map.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct RegionIndex {
    /// Where the list of each hash ends.
    pub ends: Vec<u32>,
    /// The lists: regions, rising.
    pub regions: Vec<u32>,
}

/// Places of a region: a square of 16 by 16 cells.
pub(super) const REGION_PLACES: usize = 256;
/// Lists of an index that is not empty.
pub(super) const N_HASHES: usize = 1 << 20;
/// Distances and extents are kept in so many steps of a model at once: 0.32 and 0.64 m, four times the usual tolerance, so
/// that what is alike lies in one of them as often as in two.
const STEPS: u32 = 16;
/// An observed landmark may have so many others between itself and what is beside it on the map.
const MOST_BETWEEN: usize = 2;
/// A pair that may look in more ways than this is not looked up.
const MOST_WAYS: usize = 256;

/// A look in coarse steps.
#[derive(Debug, Clone, Copy)]
struct Coarse {
    kind: u64,
    distance: u32,
    extent: u32,
}

/// Hashes of the pairs of neighbors among looks all around, in the order in which they are seen.
pub(super) fn pairs(looks: &[Look]) -> impl Iterator<Item = u32> + '_ {
    let coarse = |look: &Look| {
        let [distance, extent] = look.steps().map(|steps| steps / STEPS);
        Coarse { kind: look.kind as u64, distance, extent }
    };
    let next = looks.iter().cycle().skip(1);
    let neighbors = looks.iter().zip(next).take(if looks.len() > 1 { looks.len() } else { 0 });
    neighbors.map(move |(one, other)| hash(coarse(one), coarse(other)))
}

fn hash(one: Coarse, other: Coarse) -> u32 {
    let part = |look: Coarse| look.kind << 22 | u64::from(look.distance) << 11 | u64::from(look.extent);
    let key = part(one) << 24 | part(other);
    // The finalizer of splitmix64 (Steele, Lea, Flood 2014) spreads keys that differ little.
    let mixed = (key ^ key >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((mixed ^ mixed >> 31) % N_HASHES as u64) as u32
}

/// A pair that is seen from a region, as one number.
pub(super) fn seen_from(pair: u32, region: usize) -> u64 {
    u64::from(pair) << 32 | region as u64
}

impl RegionIndex {
    /// Packs pairs with their regions, which are sorted here.
    pub fn of(mut seen: Vec<u64>) -> RegionIndex {
        if seen.is_empty() {
            return RegionIndex::default();
        }
        seen.sort_unstable();
        seen.dedup();
        let mut ends = Vec::with_capacity(N_HASHES);
        for (idx, entry) in seen.iter().enumerate() {
            ends.resize((entry >> 32) as usize, idx as u32);
        }
        ends.resize(N_HASHES, seen.len() as u32);
        RegionIndex { ends, regions: seen.into_iter().map(|entry| entry as u32).collect() }
    }

    /// It says nothing.
    pub fn is_empty(&self) -> bool {
        self.regions.is_empty()
    }

    /// Bytes that it takes.
    pub fn n_bytes(&self) -> usize {
        4 * (self.ends.len() + self.regions.len())
    }

    fn regions(&self, pair: u32) -> &[u32] {
        let idx = pair as usize;
        let first = idx.checked_sub(1).map_or(Some(0), |before| self.ends.get(before).copied());
        let range = first.zip(self.ends.get(idx)).map(|(first, end)| first as usize..*end as usize);
        range.and_then(|range| self.regions.get(range)).unwrap_or_default()
    }

    /// Everything in it fits together.
    pub fn is_sound(&self, n_places: usize) -> bool {
        let n_regions = n_places.div_ceil(REGION_PLACES) as u32;
        self.ends.len() == if self.is_empty() { 0 } else { N_HASHES }
            && self.ends.is_sorted()
            && self.ends.last().map_or(0, |end| *end as usize) == self.regions.len()
            && self.regions.iter().all(|region| *region < n_regions)
    }
}

/// Finds regions; keeps its memory.
#[derive(Debug, Default)]
pub(super) struct RegionSearch {
    hashes: Vec<u32>,
    /// Of each region how many of the observed pairs are seen from it, and the last of them.
    votes: Vec<[u16; 2]>,
}

/// With fewer pairs in the best region nothing can be said.
const LEAST_VOTES: u16 = 3;
/// Regions with a smaller share of the votes of the best are left out.
const LEAST_SHARE: f64 = 0.5;

impl RegionSearch {
    /// Counts for each region how many of the pairs of what was observed, in the order in which it was seen, may be seen
    /// from it.
    pub fn count(&mut self, index: &RegionIndex, n_places: usize, observed: &[Look], within: &Similarity) {
        self.votes.clear();
        if index.is_empty() {
            return;
        }
        self.votes.resize(n_places.div_ceil(REGION_PLACES), [0; 2]);
        let (n, mut pair) = (observed.len(), 0);
        for (idx, one) in observed.iter().enumerate() {
            for beside in 1..=(MOST_BETWEEN + 1).min(n.saturating_sub(1)) {
                let Some(other) = observed.get((idx + beside) % n) else { continue };
                pair += 1;
                self.count_pair(index, pair, one, other, within);
            }
        }
    }

    fn count_pair(&mut self, index: &RegionIndex, pair: u16, one: &Look, other: &Look, within: &Similarity) {
        self.hashes.clear();
        for one in ways(one, within) {
            self.hashes.extend(ways(other, within).take(MOST_WAYS + 1).map(|other| hash(one, other)));
            if self.hashes.len() > MOST_WAYS {
                return;
            }
        }
        for region in self.hashes.iter().flat_map(|hash| index.regions(*hash)) {
            let Some([votes, last]) = self.votes.get_mut(*region as usize) else { continue };
            if *last != pair {
                (*votes, *last) = (*votes + 1, pair);
            }
        }
    }

    /// Whether one of the regions among these places has many votes, or nothing can be said.
    pub fn is_worth_it(&self, most: u16, mut places: std::ops::Range<usize>) -> bool {
        places = places.start / REGION_PLACES..places.end.div_ceil(REGION_PLACES).min(self.votes.len());
        let least = (LEAST_SHARE * f64::from(most)).ceil() as u16;
        let is_good = |[votes, _]: &[u16; 2]| *votes >= least;
        most < LEAST_VOTES || self.votes.get(places).is_some_and(|votes| votes.iter().any(is_good))
    }

    /// The votes of the best.
    pub fn most(&self) -> u16 {
        self.votes.iter().map(|[votes, _]| *votes).max().unwrap_or(0)
    }
}

/// The coarse looks that a look may have within a tolerance.
fn ways(look: &Look, within: &Similarity) -> impl Iterator<Item = Coarse> + use<> {
    let steps = |middle_m: f64, within_m: f64, step_m: f64| {
        let most = f64::from(Look::MOST_STEPS);
        let coarse = |meters: f64| (meters / step_m).round().clamp(0.0, most) as u32 / STEPS;
        coarse(middle_m - within_m)..=coarse(middle_m + within_m)
    };
    let distances = steps(look.distance_m, within.distance_m, DISTANCE_STEP_M);
    let extents = steps(look.extent_m, within.extent_m, EXTENT_STEP_M);
    let kind = look.kind as u64;
    let is_number = look.distance_m.is_finite() && look.extent_m.is_finite();
    let of_distance = move |distance| extents.clone().map(move |extent| Coarse { kind, distance, extent });
    distances.filter(move |_| is_number).flat_map(of_distance)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmark_model::LookKind;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    const WITHIN: Similarity = Similarity { distance_m: 0.075, extent_m: 0.15 };

    fn look(rng: &mut Xoshiro256PlusPlus) -> Look {
        let kind = LookKind::ALL[rng.random_range(0..3)];
        Look { kind, distance_m: rng.random_range(0.1..8.0), extent_m: rng.random_range(0.2..6.0) }
    }

    /// What is seen from each of 200 regions.
    fn regions(rng: &mut Xoshiro256PlusPlus) -> (Vec<Vec<Look>>, RegionIndex) {
        let regions: Vec<Vec<Look>> = (0..200).map(|_| (0..12).map(|_| look(rng)).collect()).collect();
        let seen = regions.iter().enumerate();
        let seen = seen.flat_map(|(region, looks)| pairs(looks).map(move |pair| seen_from(pair, region)));
        let index = RegionIndex::of(seen.collect());
        (regions, index)
    }

    #[test]
    fn the_region_whose_pairs_are_seen_is_always_named_also_with_others_between_and_strange_ones_rarely() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let (regions, index) = regions(&mut rng);
        let n_places = regions.len() * REGION_PLACES;
        assert!(index.is_sound(n_places) && !index.is_sound(n_places - REGION_PLACES));
        let (mut search, mut n_strange) = (RegionSearch::default(), 0);
        for (region, seen) in regions.iter().enumerate() {
            // Each is seen a little differently, and after each second one stands what the map does not show.
            let mut observed = Vec::new();
            for (idx, known) in seen.iter().enumerate() {
                let (d, p) = (rng.random_range(-0.07..0.07), rng.random_range(-0.14..0.14));
                let (distance_m, extent_m) = (known.distance_m + d, known.extent_m + p);
                observed.push(Look { kind: known.kind, distance_m, extent_m });
                if idx % 2 == 0 {
                    observed.push(look(&mut rng));
                }
            }
            search.count(&index, n_places, &observed, &WITHIN);
            assert!(search.votes[region][0] >= 12 && search.most() == search.votes[region][0]);
            let is_worth_it = |region: usize| {
                search.is_worth_it(search.most(), region * REGION_PLACES..(region + 1) * REGION_PLACES)
            };
            assert!(is_worth_it(region));
            n_strange += (0..regions.len()).filter(|other| *other != region && is_worth_it(*other)).count();
        }
        assert!(n_strange < 20, "{n_strange} of 40,000");
    }

    #[test]
    fn where_nothing_can_be_said_every_region_is_worth_a_look() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
        let (regions, index) = regions(&mut rng);
        let wall = Look { kind: LookKind::Wall, distance_m: 1.0, extent_m: 2.0 };
        let wide = Similarity { distance_m: 50.0, extent_m: 50.0 };
        let odd = Look { distance_m: f64::NAN, ..wall };
        let mut search = RegionSearch::default();
        for (index, observed, within) in [
            (&index, vec![], WITHIN),
            (&index, vec![wall], WITHIN),
            (&index, vec![odd, wall, odd], WITHIN),
            (&index, regions[0].clone(), wide),
            (&RegionIndex::default(), regions[0].clone(), WITHIN),
        ] {
            search.count(index, regions.len() * REGION_PLACES, &observed, &within);
            assert!(
                (0..200).all(|region| search.is_worth_it(search.most(), region * 256..(region + 1) * 256))
            );
        }
        assert_eq!(pairs(&[wall]).count(), 0);
        assert_eq!(pairs(&[wall, wall]).count(), 2);
        assert!(RegionIndex::default().is_sound(0));
    }
}
