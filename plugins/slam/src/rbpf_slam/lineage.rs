//! The ways of all particles: a tree, since particles that were drawn from one share its past.

use rumbo_core::frames::Pose2;
use std::collections::VecDeque;

/// Where a particle was at one step, and which one of the step before it came from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Branch {
    /// Place among the branches of the step before.
    pub parent: u32,
    /// The pose.
    pub map_from_base: Pose2,
}

/// The tree: a trunk that all particles share, then a layer of branches a step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Lineage {
    pub(super) trunk: Vec<Pose2>,
    pub(super) layers: VecDeque<Vec<Branch>>,
    /// Which branch of the last layer is each particle's.
    pub(super) tips: Vec<u32>,
}

impl Lineage {
    /// Forgets everything: so many particles without a past.
    pub fn begin(&mut self, n_particles: usize) {
        *self = Lineage { tips: vec![0; n_particles], ..Lineage::default() };
    }

    /// Steps so far.
    pub fn len(&self) -> usize {
        self.trunk.len() + self.layers.len()
    }

    /// There is no step.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// One step of every particle, in their order.
    pub fn push(&mut self, poses: impl Iterator<Item = Pose2>) {
        let grow = |(tip, map_from_base): (&u32, Pose2)| Branch { parent: *tip, map_from_base };
        let layer: Vec<Branch> = self.tips.iter().zip(poses).map(grow).collect();
        self.tips = (0..layer.len() as u32).collect();
        self.layers.push_back(layer);
    }

    /// New particles are copies of these. What all of them share becomes trunk.
    pub fn resample(&mut self, ancestors: &[usize]) {
        let tip = |ancestor: &usize| self.tips.get(*ancestor).copied().unwrap_or(0);
        self.tips = ancestors.iter().map(tip).collect();
        let mut alive = self.tips.clone();
        for depth in (0..self.layers.len()).rev() {
            alive.sort_unstable();
            alive.dedup();
            let Some(layer) = self.layers.get(depth) else { break };
            if let [only] = alive[..] {
                self.settle(depth, only);
                return;
            }
            alive = alive.iter().filter_map(|idx| Some(layer.get(*idx as usize)?.parent)).collect();
        }
    }

    /// Layers up to this one become trunk: the way that ends in this branch.
    fn settle(&mut self, depth: usize, branch: u32) {
        let way = self.way_to(depth, branch);
        self.trunk.extend(way);
        self.layers.drain(..=depth);
        if let Some(first) = self.layers.front_mut() {
            first.iter_mut().for_each(|branch| branch.parent = 0);
        }
        if self.layers.is_empty() {
            self.tips.fill(0);
        }
    }

    /// Poses of the layers up to this one, oldest first.
    fn way_to(&self, depth: usize, branch: u32) -> Vec<Pose2> {
        let mut way = Vec::with_capacity(depth + 1);
        let mut at = branch;
        for layer in self.layers.iter().take(depth + 1).rev() {
            let Some(branch) = layer.get(at as usize) else { break };
            way.push(branch.map_from_base);
            at = branch.parent;
        }
        way.reverse();
        way
    }

    /// Where this particle was at each step.
    pub fn way_of(&self, particle: usize) -> Vec<Pose2> {
        let mut way = self.trunk.clone();
        if let (Some(last), Some(tip)) = (self.layers.len().checked_sub(1), self.tips.get(particle)) {
            way.extend(self.way_to(last, *tip));
        }
        way
    }
}
