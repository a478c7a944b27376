//! Clusters: particles in bins that touch each other are one guess of where the robot is.

use super::particles::Particles;
use super::pose_bins::{Bin, BinSet, N_HEADINGS, bin_of};
use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::{Pose2, pose2, wrap_angle};

/// A guess of where the robot is.
#[derive(Debug, Clone, PartialEq)]
pub struct Cluster {
    /// Share of all weight.
    pub weight: f64,
    /// Weighted mean of x, y; yaw by the weighted sines and cosines.
    pub map_from_base: Pose2,
    /// Weighted covariance of x, y, yaw about the mean, m² and rad².
    pub covariance: Matrix3<f64>,
}

impl Cluster {
    /// The larger standard deviation of x and y, meters.
    pub fn deviation_m(&self) -> f64 {
        self.covariance[(0, 0)].max(self.covariance[(1, 1)]).sqrt()
    }

    /// Standard deviation of the yaw, radians.
    pub fn deviation_rad(&self) -> f64 {
        self.covariance[(2, 2)].sqrt()
    }
}

/// Finds clusters; keeps its memory.
#[derive(Debug, Clone, Default)]
pub struct Clustering {
    bins: BinSet,
    bin_of_particle: Vec<u32>,
    /// Another bin of the same cluster; a root names itself.
    parents: Vec<u32>,
    sums: Vec<Sums>,
}

/// Weighted sums over a cluster. Places are relative to its first particle, so that squares keep their digits.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    first: Option<[f64; 3]>,
    weight: f64,
    first_moments: [f64; 2],
    heading: [f64; 2],
    squares: Matrix3<f64>,
}

/// Variance that is added to each of x, y, yaw: a covariance that leaves the filter is positive definite.
const LEAST_VARIANCE: f64 = 1e-9;
/// A particle with less than this part of the mean weight belongs to no cluster.
const LEAST_SHARE: f64 = 1e-3;
/// In place of the number of a bin.
const LEFT_OUT: u32 = u32::MAX;

impl Clustering {
    /// All clusters, the heaviest first; equal ones in the order of their particles.
    pub fn find(&mut self, particles: &Particles) -> Vec<Cluster> {
        self.fill_bins(particles);
        self.join_neighbors();
        self.sums.clear();
        self.sums.resize(self.bins.len(), Sums::default());
        let roots: Vec<u32> = (0..self.bins.len() as u32).map(|bin| self.root(bin)).collect();
        let all = || particles.iter().zip(&particles.weights).zip(&self.bin_of_particle);
        let weighed = || all().filter(|(_, bin)| **bin != LEFT_OUT);
        for ((pose, weight), bin) in weighed() {
            self.sums[roots[*bin as usize] as usize].add(pose, *weight);
        }
        let mut means: Vec<[f64; 3]> = self.sums.iter().map(Sums::mean).collect();
        for ((pose, weight), bin) in weighed() {
            let root = roots[*bin as usize] as usize;
            let mean = &mut means[root];
            let off = Vector3::new(pose[0] - mean[0], pose[1] - mean[1], wrap_angle(pose[2] - mean[2]));
            self.sums[root].squares += off * off.transpose() * *weight;
        }
        let mut clusters: Vec<Cluster> =
            self.sums.iter().zip(means).filter(|(sums, _)| sums.weight > 0.0).map(Sums::cluster).collect();
        clusters.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        clusters
    }

    /// Only what has weight counts: particles with next to none would tie clusters together.
    fn fill_bins(&mut self, particles: &Particles) {
        self.bins.clear();
        self.bin_of_particle.clear();
        let (bins, least) = (&mut self.bins, LEAST_SHARE / particles.len().max(1) as f64);
        let number = |(pose, weight): ([f64; 3], &f64)| match *weight >= least {
            true => bins.insert(bin_of(pose)) as u32,
            false => LEFT_OUT,
        };
        self.bin_of_particle.extend(particles.iter().zip(&particles.weights).map(number));
    }

    fn join_neighbors(&mut self) {
        self.parents.clear();
        self.parents.extend(0..self.bins.len() as u32);
        for number in 0..self.bins.len() {
            let [x, y, heading] = self.bins.bins()[number];
            // Half of the 26 neighbors; the other half finds this bin.
            for (dx, dy, turn) in half_neighborhood() {
                let neighbor: Bin = [x + dx, y + dy, (heading + turn).rem_euclid(N_HEADINGS)];
                if let Some(other) = self.bins.find(&neighbor) {
                    let (a, b) = (self.root(number as u32), self.root(other as u32));
                    // The earlier one stays: the order of the particles decides, nothing else.
                    self.parents[a.max(b) as usize] = a.min(b);
                }
            }
        }
    }

    fn root(&mut self, mut bin: u32) -> u32 {
        while self.parents[bin as usize] != bin {
            // Halving the way keeps later searches short.
            let parent = self.parents[bin as usize];
            self.parents[bin as usize] = self.parents[parent as usize];
            bin = parent;
        }
        bin
    }
}

fn half_neighborhood() -> impl Iterator<Item = (i32, i32, i32)> {
    let all = (0..27).map(|k| (k / 9 - 1, k / 3 % 3 - 1, k % 3 - 1));
    all.skip(14)
}

impl Sums {
    #[inline]
    fn add(&mut self, pose: [f64; 3], weight: f64) {
        let [x, y, yaw] = *self.first.get_or_insert(pose);
        let (sin, cos) = (pose[2] - yaw).sin_cos();
        self.weight += weight;
        self.first_moments[0] += weight * (pose[0] - x);
        self.first_moments[1] += weight * (pose[1] - y);
        self.heading[0] += weight * cos;
        self.heading[1] += weight * sin;
    }

    fn mean(&self) -> [f64; 3] {
        let [x, y, yaw] = self.first.unwrap_or_default();
        let weight = if self.weight > 0.0 { self.weight } else { 1.0 };
        let [dx, dy] = self.first_moments.map(|v| v / weight);
        [x + dx, y + dy, yaw + self.heading[1].atan2(self.heading[0])]
    }

    fn cluster((sums, [x, y, yaw]): (&Sums, [f64; 3])) -> Cluster {
        let covariance = sums.squares / sums.weight + Matrix3::identity() * LEAST_VARIANCE;
        Cluster { weight: sums.weight, map_from_base: pose2(x, y, wrap_angle(yaw)), covariance }
    }
}
