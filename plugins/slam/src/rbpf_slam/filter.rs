//! The filter: every particle looks, then they are weighed, then drawn anew where few of them say anything.

use super::archive::Archive;
use super::lineage::Lineage;
use super::particle::{KeyScan, Looked, Particle};
use super::settings::FilterSettings;
use super::weights::{best, gain, normalized};
use rayon::prelude::*;
use rumbo_core::frames::Pose2;
use rumbo_core::rng::RngExt as _;
use rumbo_kit::resampling::{effective_number, low_variance};
use rumbo_kit::streams::Streams;
use rumbo_kit::tile_map::{TileMap, TilePainter};

/// The particles and their past.
#[derive(Debug)]
pub struct Filter {
    pub(super) settings: FilterSettings,
    pub(super) streams: Streams,
    pub(super) particles: Vec<Particle>,
    pub(super) lineage: Lineage,
    pub(super) steps: u64,
    pub(super) effective: f64,
    pub(super) painters: Vec<TilePainter>,
}

/// What a step came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// Particles that matched the scan with their map.
    pub n_matched: usize,
    /// The best particle's look.
    pub best: Option<Looked>,
    /// Particles were drawn anew.
    pub is_resampled: bool,
    /// No particle had any weight, so all have the same again.
    pub is_degenerate: bool,
}

/// Streams of one step: one for each particle, and the last for drawing particles.
const STREAMS_A_STEP: u64 = 1 << 20;

impl Filter {
    /// Without particles.
    pub fn new(settings: FilterSettings, streams: Streams) -> Filter {
        let painter = TilePainter::new(settings.limits, settings.free_space, settings.evidence);
        let painters = vec![painter; rayon::current_num_threads().max(1)];
        let (particles, lineage) = (Vec::new(), Lineage::default());
        Filter { settings, streams, particles, lineage, steps: 0, effective: 0.0, painters }
    }

    /// All particles at one place, without a map.
    pub fn begin(&mut self, map_from_base: &Pose2) {
        let map = TileMap::new(self.settings.resolution_m, self.settings.n_levels, &self.settings.evidence);
        let particle = Particle { map_from_base: *map_from_base, ln_weight: 0.0, ln_total: 0.0, map };
        self.particles = vec![particle; self.settings.n_particles];
        self.lineage.begin(self.settings.n_particles);
        (self.steps, self.effective) = (0, self.settings.n_particles as f64);
    }

    /// Numbers of the filter.
    pub fn settings(&self) -> &FilterSettings {
        &self.settings
    }

    /// All guesses.
    pub fn particles(&self) -> &[Particle] {
        &self.particles
    }

    /// The ways of all guesses.
    pub fn lineage(&self) -> &Lineage {
        &self.lineage
    }

    /// How many particles say something (N_eff), at the last step.
    pub fn effective(&self) -> f64 {
        self.effective
    }

    /// Scans that were taken in.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// The particle with the greatest weight since the beginning.
    pub fn best_index(&self) -> usize {
        best(self.particles.iter().map(|particle| particle.ln_total))
    }

    /// See [`best_index`](Self::best_index); none before the beginning.
    pub fn best(&self) -> Option<&Particle> {
        self.particles.get(self.best_index())
    }

    /// Puts the best particle here and every other to a place of its own around, each with the map that it has.
    pub fn place(&mut self, map_from_base: &Pose2, mut draw: impl FnMut(&mut rumbo_core::rng::Rng) -> Pose2) {
        let mut rng = self.streams.numbered(self.steps.wrapping_mul(STREAMS_A_STEP) + STREAMS_A_STEP - 2);
        self.particles.iter_mut().for_each(|particle| particle.map_from_base = draw(&mut rng));
        let best = self.best_index();
        self.particles.iter_mut().skip(best).take(1).for_each(|best| best.map_from_base = *map_from_base);
    }

    /// Weights of the particles that sum to 1.
    pub fn weights(&self) -> Vec<f64> {
        let ln: Vec<f64> = self.particles.iter().map(|particle| particle.ln_weight).collect();
        let n = self.particles.len();
        normalized(&ln, gain(self.settings.ogain, n)).unwrap_or_else(|| vec![1.0 / n.max(1) as f64; n])
    }

    /// Takes in a scan. The first one is drawn into the maps as it is.
    pub fn take(&mut self, key: &KeyScan<'_>) -> Outcome {
        self.steps += 1;
        let is_first = self.lineage.is_empty();
        let looks = self.look_all(key, is_first);
        self.lineage.push(self.particles.iter().map(|particle| particle.map_from_base));
        let n_matched = looks.iter().flatten().filter(|looked| looked.status.is_match()).count();
        let best = looks.get(self.best_index()).copied().flatten();
        let mut outcome = Outcome { n_matched, best, is_resampled: false, is_degenerate: false };
        if is_first || n_matched == 0 {
            return outcome;
        }
        outcome.is_degenerate = self.drop_unusable();
        let weights = self.weights();
        self.effective = effective_number(&weights);
        let is_uneven = self.effective < self.settings.resample_threshold * self.particles.len() as f64;
        outcome.is_resampled = is_uneven && self.resample(&weights);
        outcome
    }

    /// Every particle by itself, on as many threads as there are: each draws from a stream of its own.
    fn look_all(&mut self, key: &KeyScan<'_>, is_first: bool) -> Vec<Option<Looked>> {
        let Filter { settings, streams, particles, painters, steps, .. } = self;
        let (settings, streams, steps) = (&*settings, &*streams, *steps);
        let chunk = particles.len().div_ceil(painters.len()).max(1);
        let mut looks: Vec<Option<Looked>> = vec![None; particles.len()];
        let chunks = particles.par_chunks_mut(chunk).zip(looks.par_chunks_mut(chunk));
        chunks.zip(painters.par_iter_mut()).enumerate().for_each(|(part, ((particles, looks), painter))| {
            for (k, (particle, look)) in particles.iter_mut().zip(looks).enumerate() {
                let idx = (part * chunk + k) as u64;
                let number = steps.wrapping_mul(STREAMS_A_STEP).wrapping_add(idx);
                if !is_first {
                    *look = Some(particle.look(key, settings, &mut streams.numbered(number)));
                }
                if look.is_none_or(|look| look.is_drawn) {
                    let pose = particle.map_from_base;
                    painter.paint(&mut particle.map, key.scan, &pose, &key.base_from_sensor, number);
                }
            }
        });
        looks
    }

    /// All guesses have come this way, with a map that is drawn along it.
    pub fn settle(&mut self, way: Vec<Pose2>, archive: &Archive) {
        let (Some(last), Some(painter)) = (way.last().copied(), self.painters.first_mut()) else { return };
        let FilterSettings { resolution_m, n_levels, evidence, n_particles, .. } = &self.settings;
        let mut map = TileMap::new(*resolution_m, *n_levels, evidence);
        let number = self.steps.wrapping_mul(STREAMS_A_STEP) + STREAMS_A_STEP - 3;
        for (pose, taken) in way.iter().zip(&archive.taken).filter(|(_, taken)| taken.is_drawn) {
            painter.paint(&mut map, &taken.scan, pose, &taken.base_from_sensor, number);
        }
        let particle = Particle { map_from_base: last, ln_weight: 0.0, ln_total: 0.0, map };
        self.particles = vec![particle; *n_particles];
        self.lineage = Lineage { trunk: way, tips: vec![0; *n_particles], ..Lineage::default() };
    }

    /// A weight that is not a number is none. Where all are none, all become equal, and this is said.
    fn drop_unusable(&mut self) -> bool {
        let is_usable = |particle: &Particle| particle.ln_weight.is_finite() && particle.ln_total.is_finite();
        if self.particles.iter().any(is_usable) {
            return false;
        }
        self.particles.iter_mut().for_each(|particle| (particle.ln_weight, particle.ln_total) = (0.0, 0.0));
        true
    }

    fn resample(&mut self, weights: &[f64]) -> bool {
        let number = self.steps.wrapping_mul(STREAMS_A_STEP) + STREAMS_A_STEP - 1;
        let share = self.streams.numbered(number).random::<f64>();
        let Ok(ancestors) = low_variance(weights, self.particles.len(), share) else { return false };
        self.lineage.resample(&ancestors);
        let copy = |ancestor: &usize| {
            let ancestor = self.particles.get(*ancestor)?;
            Some(Particle { ln_weight: 0.0, ..ancestor.clone() })
        };
        self.particles = ancestors.iter().filter_map(copy).collect();
        true
    }
}
