//! The model of a whole map.

use super::band::{Band, entry};
use super::order::CellOrder;
use super::regions::{REGION_PLACES, RegionIndex, pairs, seen_from};
use super::surroundings::{ModelSettings, Surroundings, Tracer};
use crate::GridSize;
use rayon::prelude::*;
use rumbo_core::stages::GiveUp;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What every free cell of a map sees.
#[derive(Debug, Clone, PartialEq)]
pub struct LandmarkModel {
    pub(super) size: GridSize,
    pub(super) order: CellOrder,
    /// How many landmarks the cell at each place sees, at most 255; none where a cell is not free.
    pub(super) n_landmarks: Vec<u8>,
    pub(super) bands: Vec<Band>,
    /// Which regions of a large map are worth a look.
    pub(super) regions: RegionIndex,
}

/// How many places follow each other in a band of a map of so many.
pub(super) fn band_places(n_places: usize) -> usize {
    if n_places < LARGE_MAP { SMALL_MAP_BAND } else { LARGE_MAP_BAND }
}

/// Places in a band of a small map, which is looked at as a whole: as many as can be sorted at once without much memory.
const SMALL_MAP_BAND: usize = 1 << 18;
/// Places in a band of a large map: some rooms, of which a filter looks at all or at none.
const LARGE_MAP_BAND: usize = 1 << 16;
/// A map of so many places is large.
const LARGE_MAP: usize = 1 << 19;
/// Places that are traced by one thread at a time.
const PIECE_PLACES: usize = 512;

/// How far the building of a model is; may be read from another thread.
#[derive(Debug, Default)]
pub struct Progress {
    n_done: AtomicUsize,
    n_places: AtomicUsize,
}

impl Progress {
    /// From 0 to 1.
    pub fn share(&self) -> f64 {
        let n_places = self.n_places.load(Ordering::Relaxed).max(1);
        self.n_done.load(Ordering::Relaxed) as f64 / n_places as f64
    }
}

impl LandmarkModel {
    /// Traces all free cells, on all processors; the result does not depend on their number. None when asked to give up.
    pub fn build(
        surroundings: &Surroundings,
        settings: &ModelSettings,
        progress: &Progress,
        give_up: &GiveUp,
    ) -> Option<LandmarkModel> {
        let mut builder = ModelBuilder::new(surroundings);
        builder.go_on(surroundings, settings, usize::MAX, progress, give_up);
        builder.finish()
    }

    /// Columns and rows.
    pub fn size(&self) -> GridSize {
        self.size
    }

    /// Places that are traced to make it: one for each cell, and some at the rim.
    pub fn n_places(&self) -> usize {
        self.n_landmarks.len()
    }

    /// Cells that see anything.
    pub fn n_cells(&self) -> usize {
        self.n_landmarks.iter().filter(|n| **n > 0).count()
    }

    /// Landmarks of all cells together.
    pub fn n_landmarks(&self) -> usize {
        self.n_landmarks.iter().map(|n| usize::from(*n)).sum()
    }

    /// How many landmarks a cell sees, at most 255.
    pub fn n_landmarks_of(&self, cell: usize) -> usize {
        self.n_landmarks.get(self.order.place_of(cell)).map_or(0, |n| usize::from(*n))
    }

    /// Bytes that it takes, with everything that finding cells needs.
    pub fn n_bytes(&self) -> usize {
        self.n_landmarks.len() + self.bands.iter().map(Band::n_bytes).sum::<usize>() + self.regions.n_bytes()
    }
}

/// Builds a model part by part, so that nobody has to wait for all of it.
#[derive(Debug)]
pub struct ModelBuilder {
    model: LandmarkModel,
    /// What the cells of the band that is not full yet see.
    entries: Vec<u64>,
    /// What they see side by side, with their regions, in a large map.
    pairs: Vec<u64>,
    next_place: usize,
}

impl ModelBuilder {
    /// Nothing is built yet.
    pub fn new(surroundings: &Surroundings) -> ModelBuilder {
        let size = surroundings.size();
        let order = CellOrder::new(size);
        let n_landmarks = vec![0; order.n_places()];
        let model =
            LandmarkModel { size, order, n_landmarks, bands: Vec::new(), regions: RegionIndex::default() };
        ModelBuilder { model, entries: Vec::new(), pairs: Vec::new(), next_place: 0 }
    }

    /// Traces so many more places, on all processors. What is traced after `give_up` was raised is not kept: building ends
    /// there. The settings must be the same each time.
    pub fn go_on(
        &mut self,
        surroundings: &Surroundings,
        settings: &ModelSettings,
        n_places: usize,
        progress: &Progress,
        give_up: &GiveUp,
    ) {
        let n_all = self.model.n_landmarks.len();
        progress.n_places.store(n_all, Ordering::Relaxed);
        let end = self.next_place.saturating_add(n_places).min(n_all);
        while self.next_place < end && !give_up.is_raised() {
            let first = self.next_place;
            let in_band = band_places(n_all);
            let band_end = (first / in_band + 1) * in_band;
            let last = end.min(band_end);
            let order = self.model.order;
            let Some(n_landmarks) = self.model.n_landmarks.get_mut(first..last) else { return };
            let pieces: Vec<Seen> = n_landmarks
                .par_chunks_mut(PIECE_PLACES)
                .enumerate()
                .map_init(
                    || Tracer::new(*settings),
                    |tracer, (piece, n_landmarks)| {
                        let piece = Piece { order, first: first + piece * PIECE_PLACES };
                        let seen = piece.trace(surroundings, tracer, n_landmarks, give_up);
                        progress.n_done.fetch_add(n_landmarks.len(), Ordering::Relaxed);
                        seen
                    },
                )
                .collect();
            if give_up.is_raised() {
                return;
            }
            for piece in pieces {
                self.entries.extend(piece.entries);
                self.pairs.extend(piece.pairs);
            }
            self.next_place = last;
            if last == band_end || last == n_all {
                self.model.bands.push(Band::of(std::mem::take(&mut self.entries)));
            }
        }
    }

    /// Everything is traced.
    pub fn is_done(&self) -> bool {
        self.next_place == self.model.n_landmarks.len()
    }

    /// The model, once everything is traced.
    pub fn finish(mut self) -> Option<LandmarkModel> {
        self.is_done().then(|| {
            self.model.regions = RegionIndex::of(self.pairs);
            self.model
        })
    }
}

/// Some places that follow each other.
struct Piece {
    order: CellOrder,
    first: usize,
}

/// What is seen from some places.
#[derive(Default)]
struct Seen {
    entries: Vec<u64>,
    /// Side by side.
    pairs: Vec<u64>,
}

impl Piece {
    fn trace(
        &self,
        surroundings: &Surroundings,
        tracer: &mut Tracer,
        n_landmarks: &mut [u8],
        give_up: &GiveUp,
    ) -> Seen {
        let mut seen = Seen::default();
        if give_up.is_raised() {
            return seen;
        }
        let n_places = self.order.n_places();
        let mut looks = Vec::new();
        for (place, n_landmarks) in (self.first..).zip(n_landmarks) {
            let cell = self.order.cell_at(place).filter(|cell| surroundings.is_free(*cell));
            let Some(cell) = cell else { continue };
            let in_band = (place % band_places(n_places)) as u32;
            looks.clear();
            looks.extend(tracer.looks_of(surroundings, cell));
            seen.entries.extend(looks.iter().map(|look| entry(*look, in_band)));
            if n_places >= LARGE_MAP {
                seen.pairs.extend(pairs(&looks).map(|pair| seen_from(pair, place / REGION_PLACES)));
            }
            *n_landmarks = looks.len().min(usize::from(u8::MAX)) as u8;
        }
        // Neighbors see the same.
        seen.pairs.sort_unstable();
        seen.pairs.dedup();
        seen
    }
}
