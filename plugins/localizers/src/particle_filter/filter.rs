//! The filter: move, weigh, guess, resample.
//!
//! Monte-Carlo localization: Dellaert, Fox, Burgard, Thrun (1999); Thrun, Burgard, Fox, *Probabilistic Robotics* (2005),
//! tables 8.2 and 8.3. Weights are kept as logarithms until they are normalized.

use super::beams::ScanBeams;
use super::clusters::{Cluster, Clustering};
use super::flattening::flattening;
use super::kld::KldBound;
use super::motion::MotionModel;
use super::particles::Particles;
use super::pose_bins::{BinSet, bin_of};
use super::recovery::Recovery;
use super::slip::Slipping;
use super::streams::{Purpose, Streams};
use super::terrain::Terrain;
use nalgebra::{Matrix3, Vector3};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::map::Grid;
use rumbo_core::rng::Rng;
use rumbo_kit::grid_poses::GridPoses;
use rumbo_kit::resampling::{IndependentDraws, low_variance};

/// Numbers of the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct FilterSettings {
    /// How many particles.
    pub bound: KldBound,
    /// The number follows the spread of the belief.
    pub is_adaptive: bool,
    /// Power of the likelihood: neighboring beams are not independent.
    pub likelihood_exponent: f64,
    /// One update leaves at least this effective share of the particles: else its likelihood is flattened further.
    pub least_effective_share: f64,
    /// Share of particles that move otherwise than the odometer says.
    pub slip_share: f64,
    /// Resample when the effective share of the particles is below this.
    pub resample_threshold: f64,
    /// At most every so many updates.
    pub resample_interval: u32,
}

/// What weighing did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Weighed {
    /// The weights follow the scans.
    Done,
    /// No beam said anything, or the map shows nothing to hit: the weights are as before.
    Nothing,
    /// No weight was left: all are equal now.
    Degenerate,
}

/// How well the best place fits what is seen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Fit {
    /// A followed place explains enough of the beams; what it does not explain is not on the map.
    Good,
    /// Nothing was seen, or no place is followed yet.
    #[default]
    Unknown,
    /// It cannot be the true one.
    Bad,
}

/// Particles and what moves, weighs and draws them.
pub struct ParticleFilter {
    settings: FilterSettings,
    motion: Box<dyn MotionModel>,
    streams: Streams,
    particles: Particles,
    recovery: Recovery,
    step: u64,
    updates_since_resampling: u32,
    is_degenerate: bool,
    fit: Fit,
    clustering: Clustering,
    memory: Memory,
}

/// Working memory that is kept from step to step.
#[derive(Debug, Default)]
struct Memory {
    poses: GridPoses,
    ln_p: Vec<f64>,
    penalties: Vec<f64>,
    drawn: Particles,
    bins: BinSet,
    draws: IndependentDraws,
}

impl ParticleFilter {
    /// Share of particles that are scattered after all weights were lost.
    const SCATTERED_AFTER_LOSS: f64 = 0.1;
    /// Share of particles that are scattered while the best place does not fit.
    const SCATTERED_TO_SEARCH: f64 = 0.6;

    /// Guesses of a robot that may be anywhere, for each particle that there may be.
    const GUESSES_PER_PARTICLE: usize = 4;
    /// From this share of scattered particles on, their bins count too, and many particles are drawn to search with: a
    /// smaller share is the noise of the fit along the way, which should cost no more than a few.
    const SEARCH_SHARE: f64 = 0.1;

    /// Without particles yet.
    pub fn new(
        settings: FilterSettings,
        motion: Box<dyn MotionModel>,
        recovery: Recovery,
        streams: Streams,
    ) -> ParticleFilter {
        ParticleFilter {
            settings,
            motion,
            streams,
            particles: Particles::default(),
            recovery,
            step: 0,
            updates_since_resampling: 0,
            is_degenerate: false,
            fit: Fit::Unknown,
            clustering: Clustering::default(),
            memory: Memory::default(),
        }
    }

    /// The particles as they are.
    pub fn particles(&self) -> &Particles {
        &self.particles
    }

    /// The long and short averages of the fit.
    pub fn recovery(&self) -> &Recovery {
        &self.recovery
    }

    fn begin(&mut self) -> Rng {
        // A new start forgets the old run: the same start and scans give the same bits.
        self.step = 0;
        self.recovery.reset();
        (self.updates_since_resampling, self.is_degenerate, self.fit) = (0, false, Fit::Unknown);
        self.particles.clear();
        self.streams.stream(self.step, Purpose::Start)
    }

    /// Begins around a pose, normally distributed; as many particles as the spread asks for.
    pub fn start_around(&mut self, map_from_base: &Pose2, covariance: &Matrix3<f64>) {
        let mut rng = self.begin();
        // Rounding, or the user, may have made it slightly indefinite.
        let eigen = ((covariance + covariance.transpose()) / 2.0).symmetric_eigen();
        let root = eigen.eigenvectors * Matrix3::from_diagonal(&eigen.eigenvalues.map(|v| v.max(0.0).sqrt()));
        let (place, yaw) = (map_from_base.translation.vector, map_from_base.rotation.angle());
        self.memory.bins.clear();
        while self.particles.len() < self.settings.bound.particles(self.memory.bins.len()) {
            let off = root * Vector3::from_fn(|_, _| StandardNormal.sample(&mut rng));
            let pose = [place.x + off.x, place.y + off.y, wrap_angle(yaw + off.z)];
            self.memory.bins.insert(bin_of(pose));
            self.particles.push(pose);
        }
        self.particles.equalize();
    }

    /// Begins anywhere. Guesses are cheap before the first scan has been weighed: there are several times as many as there
    /// may be particles, and the first resampling keeps the best.
    pub fn start_anywhere(&mut self, terrain: &Terrain, grid: &Grid) {
        let mut rng = self.begin();
        let n = self.settings.bound.max_particles * Self::GUESSES_PER_PARTICLE;
        terrain.free.spread(grid, n, &mut rng).into_iter().for_each(|pose| self.particles.push(pose));
        self.particles.equalize();
    }

    /// Moves the particles as the odometer moved.
    pub fn advance(&mut self, odom_from_before: &Pose2, odom_from_after: &Pose2) {
        self.step += 1;
        let mut rng = self.streams.stream(self.step, Purpose::Motion);
        let slipping = Slipping::draw(&self.particles, self.settings.slip_share, &mut rng);
        self.motion.move_all(odom_from_before, odom_from_after, &mut self.particles, &mut rng);
        slipping.put(&(odom_from_before.inverse() * odom_from_after), &mut self.particles);
    }

    /// Scatters the particles: the robot may have moved this far without anybody knowing (standard deviations).
    pub fn widen(&mut self, deviation_m: f64, deviation_rad: f64) {
        self.step += 1;
        let mut rng = self.streams.stream(self.step, Purpose::Motion);
        for [x, y, yaw] in self.particles.iter_mut() {
            let mut off = |deviation: f64| -> f64 {
                let normal: f64 = StandardNormal.sample(&mut rng);
                deviation * normal
            };
            *x += off(deviation_m);
            *y += off(deviation_m);
            *yaw = wrap_angle(*yaw + off(deviation_rad));
        }
    }

    /// Weighs the particles by scans, each already seen from the base as it is now.
    pub fn weigh(&mut self, scans: &[ScanBeams], terrain: &mut Terrain) -> Weighed {
        let Memory { poses, ln_p, penalties, .. } = &mut self.memory;
        poses.clear();
        penalties.clear();
        for pose in self.particles.iter() {
            let [x, y, heading] = terrain.in_grid(pose);
            poses.push(x, y, heading);
        }
        ln_p.clear();
        ln_p.resize(poses.len(), 0.0);
        if !terrain.has_obstacles {
            return Weighed::Nothing;
        }
        let n_beams: usize = scans.iter().map(|scan| terrain.likelihood.add_ln(scan, poses, ln_p)).sum();
        if n_beams == 0 {
            return Weighed::Nothing;
        }
        let per_beam = 1.0 / n_beams as f64;
        let mut fit = 0.0;
        let places = poses.x.iter().zip(&poses.y);
        for ((ln, weight), (x, y)) in ln_p.iter_mut().zip(&self.particles.weights).zip(places) {
            let fitting = (*ln * per_beam).exp();
            fit += if fitting.is_finite() { weight * fitting } else { 0.0 };
            *ln *= self.settings.likelihood_exponent;
            penalties.push(terrain.penalty(*x, *y));
        }
        let least = self.settings.least_effective_share * ln_p.len() as f64;
        let power = flattening(&self.particles.weights, ln_p, least);
        ln_p.iter_mut().zip(&*penalties).for_each(|(ln, penalty)| *ln = *ln * power - penalty);
        self.recovery.observe(fit);
        self.updates_since_resampling += 1;
        self.is_degenerate = !self.particles.reweigh(ln_p);
        if self.is_degenerate { Weighed::Degenerate } else { Weighed::Done }
    }

    /// Where the robot may be, the heaviest guess first.
    pub fn clusters(&mut self) -> Vec<Cluster> {
        self.clustering.find(&self.particles)
    }

    /// Says how well the best place fits: while it fits badly other places are searched as well, and while a followed one
    /// fits well none are. The averages alone cannot tell when the filter has never been anywhere better, nor a robot that
    /// was carried away from one in a crowd.
    pub fn set_fit(&mut self, fit: Fit) {
        self.fit = fit;
    }

    /// How well the best place fitted at the last update.
    pub fn fit(&self) -> Fit {
        self.fit
    }

    fn is_misplaced(&self) -> bool {
        self.fit == Fit::Bad
    }

    /// Whether weight is so unevenly spread that it is time to draw new particles.
    pub fn needs_resampling(&self) -> bool {
        let is_uneven = self.particles.effective_number()
            < self.settings.resample_threshold * self.particles.len() as f64;
        // With equal weights after a loss nothing is uneven, but the scattered ones have to come in.
        (is_uneven || self.is_degenerate || self.is_misplaced())
            && self.updates_since_resampling >= self.settings.resample_interval
    }

    /// Draws new particles by weight, some of them from the whole map when the fit has become worse.
    pub fn resample(&mut self, terrain: &Terrain, grid: &Grid) {
        self.step += 1;
        self.updates_since_resampling = 0;
        let mut rng = self.streams.stream(self.step, Purpose::Resampling);
        let least = match (self.is_misplaced(), self.is_degenerate) {
            (true, _) => Self::SCATTERED_TO_SEARCH,
            (false, true) => Self::SCATTERED_AFTER_LOSS,
            (false, false) => 0.0,
        };
        let lately_worse = match self.fit {
            Fit::Good => 0.0,
            Fit::Unknown | Fit::Bad => self.recovery.random_share(),
        };
        let random_share = lately_worse.max(least);
        self.is_degenerate = false;
        let is_drawn = match self.settings.is_adaptive {
            true => self.draw_adaptively(random_share, terrain, grid, &mut rng),
            false => self.draw_evenly(random_share, terrain, grid, &mut rng),
        };
        if is_drawn {
            std::mem::swap(&mut self.particles, &mut self.memory.drawn);
        }
        self.particles.equalize();
    }

    /// Independent draws until the bins that they fall into ask for no more. False when there is nothing to draw from.
    fn draw_adaptively(&mut self, random_share: f64, terrain: &Terrain, grid: &Grid, rng: &mut Rng) -> bool {
        let Memory { drawn, bins, draws, .. } = &mut self.memory;
        if draws.prepare(&self.particles.weights).is_err() {
            return false;
        }
        drawn.clear();
        bins.clear();
        let mut n_wanted = self.settings.bound.particles(0);
        let is_search = random_share >= Self::SEARCH_SHARE;
        while drawn.len() < n_wanted {
            let is_random = random_share > 0.0 && rng.random::<f64>() < random_share;
            let anywhere = if is_random { terrain.free.draw(grid, rng) } else { None };
            let pose = anywhere.unwrap_or_else(|| {
                let idx = draws.at(rng.random());
                [self.particles.x_m[idx], self.particles.y_m[idx], self.particles.yaw_rad[idx]]
            });
            drawn.push(pose);
            if anywhere.is_some() && !is_search {
                continue;
            }
            let n_bins = bins.len();
            bins.insert(bin_of(pose));
            if bins.len() > n_bins {
                n_wanted = self.settings.bound.particles(bins.len());
            }
        }
        true
    }

    /// As many as before at equal distances. False when there is nothing to draw from.
    fn draw_evenly(&mut self, random_share: f64, terrain: &Terrain, grid: &Grid, rng: &mut Rng) -> bool {
        let n = self.particles.len();
        let Ok(indexes) = low_variance(&self.particles.weights, n, rng.random()) else { return false };
        let drawn = &mut self.memory.drawn;
        drawn.clear();
        for idx in indexes {
            let is_random = random_share > 0.0 && rng.random::<f64>() < random_share;
            let anywhere = if is_random { terrain.free.draw(grid, rng) } else { None };
            let old = [self.particles.x_m[idx], self.particles.y_m[idx], self.particles.yaw_rad[idx]];
            drawn.push(anywhere.unwrap_or(old));
        }
        true
    }
}
