//! The end of a visit: which cells differ from the map, and which have done so often enough.

use super::evidence::Verdict;
use super::memory::Memory;
use super::raster::Raster;
use super::visit::Visit;
use rumbo_core::map::CellClass;
use std::collections::BTreeSet;

/// What is removed from the map when it is seen through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Removal {
    /// Things that a laser met at an earlier visit: never a pane of glass, which it has seen through ever since.
    SeenBefore,
    /// Whatever a laser sees through.
    All,
    /// Nothing.
    Nothing,
}

/// When the map changes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rules {
    /// Visits in a row after which a cell changes.
    pub confirm_visits: u8,
    /// What is removed.
    pub removal: Removal,
}

/// What a visit comes to.
#[derive(Debug, Clone, PartialEq)]
pub struct Conclusion {
    /// What the next visit must know.
    pub memory: Memory,
    /// Cells that differed from the map in this visit.
    pub n_different: usize,
    /// Cells that change the map now.
    pub n_confirmed: usize,
}

/// A cell with less than a third of the hits of one beside it is where the scatter of that one's readings ends.
const LEAST_OF_NEIGHBOR: u32 = 3;
/// So many scans may end where nothing stands.
const STRAY_HITS: u16 = 1;
/// A thing that is gone was met before when one in so many of its cells was: of a solid one a laser meets the rim.
const CELLS_A_MET_ONE: usize = 20;

/// Ends a visit to a map of these classes, of which that is remembered. Looks only: the same again gives the same.
pub fn conclude(raster: &Raster, before: &Memory, visit: &Visit, rules: &Rules) -> Conclusion {
    let look = Look { raster, before, visit };
    let gone = look.gone(rules.removal);
    let mut memory = Memory { n_visits: before.n_visits.saturating_add(1), ..before.clone() };
    let (mut n_different, mut n_confirmed) = (0, 0);
    for index in visit.cells() {
        let Some(said) = look.say(index, &gone) else { continue };
        if said == Said::AsTheMap(true)
            && let Some(was_met) = memory.was_met.get_mut(index)
        {
            *was_met = true;
        }
        let mut cell = memory.cell(index);
        (cell.occupied_visits, cell.free_visits) = match said {
            Said::AsTheMap(_) => (0, 0),
            Said::Differs(Verdict::Occupied) => (cell.occupied_visits.saturating_add(1), 0),
            Said::Differs(Verdict::Free) => (0, cell.free_visits.saturating_add(1)),
        };
        if let Said::Differs(verdict) = said {
            n_different += 1;
            if cell.occupied_visits.max(cell.free_visits) >= rules.confirm_visits {
                n_confirmed += 1;
                (cell.learned, cell.occupied_visits, cell.free_visits) = (Some(verdict), 0, 0);
            }
        }
        match cell == Default::default() {
            true => memory.cells.remove(&index),
            false => memory.cells.insert(index, cell),
        };
    }
    Conclusion { memory, n_different, n_confirmed }
}

/// What a visit says of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Said {
    /// It is as the map has it; whether a laser met something there.
    AsTheMap(bool),
    Differs(Verdict),
}

struct Look<'a> {
    raster: &'a Raster,
    before: &'a Memory,
    visit: &'a Visit,
}

impl Look<'_> {
    fn say(&self, index: usize, gone: &BTreeSet<usize>) -> Option<Said> {
        let verdict = self.visit.evidence(index).verdict(self.visit.rules());
        match (self.raster.class(index), verdict?) {
            (CellClass::Occupied, Verdict::Occupied) => Some(Said::AsTheMap(true)),
            (CellClass::Occupied, Verdict::Free) => {
                gone.contains(&index).then_some(Said::Differs(Verdict::Free))
            }
            (CellClass::Free, Verdict::Free) => Some(Said::AsTheMap(false)),
            (CellClass::Unknown, Verdict::Free) => {
                self.is_seen_through(index).then_some(Said::Differs(Verdict::Free))
            }
            (CellClass::Free | CellClass::Unknown, Verdict::Occupied) => {
                let is_new = self.is_front(index) && !self.is_explained(index);
                is_new.then_some(Said::Differs(Verdict::Occupied))
            }
        }
    }

    /// Readings scatter around it, not from a cell beside it.
    fn is_front(&self, index: usize) -> bool {
        let n_hits = |index: usize| u32::from(self.visit.evidence(index).n_hits());
        let most_beside = self.raster.around(index).map(n_hits).max().unwrap_or(0);
        n_hits(index) * LEAST_OF_NEIGHBOR >= most_beside
    }

    /// A cell beside it stands on the map as it was made and was not seen through: maps are off by one cell.
    fn is_explained(&self, index: usize) -> bool {
        self.raster.around(index).any(|beside| {
            let is_mapped = self.raster.class(beside) == CellClass::Occupied;
            let is_learned = self.before.cell(beside).learned == Some(Verdict::Occupied);
            is_mapped && !is_learned && !self.is_seen_through(beside)
        })
    }

    /// Beams go through it, and none ends in it or beside it but for a stray one. A wall that most beams graze, and a thin
    /// thing that most of them miss, are met by others.
    fn is_seen_through(&self, index: usize) -> bool {
        let is_clear = |index: usize| self.visit.evidence(index).n_hits() <= STRAY_HITS;
        let here = self.visit.evidence(index).verdict(self.visit.rules());
        here == Some(Verdict::Free) && is_clear(index) && self.raster.around(index).all(is_clear)
    }

    /// Cells that the map has and that are gone.
    fn gone(&self, removal: Removal) -> BTreeSet<usize> {
        if removal == Removal::Nothing {
            return BTreeSet::new();
        }
        let is_mapped = |index: &usize| self.raster.class(*index) == CellClass::Occupied;
        let mut left: BTreeSet<usize> =
            self.visit.cells().filter(is_mapped).filter(|index| self.is_seen_through(*index)).collect();
        if removal == Removal::All {
            return left;
        }
        let mut gone = BTreeSet::new();
        while let Some(first) = left.pop_first() {
            let thing = self.thing(first, &mut left);
            let n_met = thing.iter().filter(|index| self.was_met(**index)).count();
            if n_met * CELLS_A_MET_ONE >= thing.len() {
                gone.extend(thing);
            }
        }
        gone
    }

    /// Takes out the cells that hang together with one.
    fn thing(&self, first: usize, left: &mut BTreeSet<usize>) -> Vec<usize> {
        let mut thing = vec![first];
        let mut next = 0;
        while let Some(&index) = thing.get(next) {
            next += 1;
            thing.extend(self.raster.around(index).filter(|beside| left.remove(beside)));
        }
        thing
    }

    fn was_met(&self, index: usize) -> bool {
        let is_learned = self.before.cell(index).learned == Some(Verdict::Occupied);
        is_learned || self.before.was_met.get(index).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests;
