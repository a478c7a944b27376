//! Which key frames are tied to which, by registering their scans.

use super::atlas::{Atlas, KeyFrame, TURN_AS_WAY_M};
use super::contradiction::denied_share;
use super::registration::{Expected, LEAST_PAIRS, Registered, register};
use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_kit::pose_graph::{Constraint, RobustKernel};

/// Loops in which more than this share of what both scans see is denied are none. On the log of FR079 it was at most 0.17 in right
/// ones, and 0.29 to 0.34 in wrong ones.
const MOST_DENIED_IN_LOOP: f64 = 0.2;

/// The odometer binds a frame to the one before it; scans tie a frame to earlier ones.
fn is_by_odometer(link: &Constraint) -> bool {
    link.from.is_some_and(|from| from < link.to)
}

impl Atlas {
    /// Registers `other` on `frame` from where it is expected; ties them when that can be believed.
    pub fn tie(
        &mut self,
        frame: usize,
        other: usize,
        expected: &Pose2,
        first_gate_m: f64,
        is_loop: bool,
    ) -> bool {
        let pair = (frame.min(other), frame.max(other));
        if frame == other || !self.tried.insert(pair) {
            return false;
        }
        let Some(found) = self.registered(frame, other, expected, first_gate_m) else { return false };
        if is_loop && self.is_denied(frame, other, &found.reference_from_scan) {
            return false;
        }
        let (c, share) = (self.settings.kernel_c, self.settings.believed_share);
        let kernel = if is_loop { RobustKernel::Huber { c } } else { RobustKernel::Cauchy { c } };
        self.bind(frame, other, found.reference_from_scan, found.information * share, kernel);
        true
    }

    /// What one of them saw stands where the other saw nothing: it is another room that looks alike.
    fn is_denied(&self, frame: usize, other: usize, frame_from_other: &Pose2) -> bool {
        let views =
            self.frames.get(frame).map(KeyFrame::view).zip(self.frames.get(other).map(KeyFrame::view));
        views.is_some_and(|(one, other)| {
            !one.is_narrow() && denied_share(&one, &other, frame_from_other) > MOST_DENIED_IN_LOOP
        })
    }

    fn registered(
        &mut self,
        frame: usize,
        other: usize,
        expected: &Pose2,
        first_gate_m: f64,
    ) -> Option<Registered> {
        if self.table_of != Some(frame) {
            self.table.fill(self.frames.get(frame)?.surface.iter().copied());
            self.table_of = Some(frame);
        }
        let scan = &self.frames.get(other)?.surface;
        let expected = Expected {
            reference_from_scan: *expected,
            information: Matrix3::zeros(),
            half_at: 1.0,
            first_gate_m,
            shape: scan.shape.as_ref(),
            least_pairs: LEAST_PAIRS,
        };
        let found = register(&self.table, scan, &expected, &self.settings.registration)?;
        let off = expected.reference_from_scan.inverse() * found.reference_from_scan;
        let [most_m, most_rad] = self.settings.most_surprise;
        let is_believed = found.overlap >= self.settings.least_overlap
            && found.agreement >= self.settings.least_agreement
            && off.translation.vector.norm() <= most_m
            && off.rotation.angle().abs() <= most_rad;
        is_believed.then_some(found)
    }

    /// Ties a frame to those before it, and to the nearest ones of earlier visits whose place is known well enough.
    pub fn tie_neighbors(&mut self, frame: usize) {
        for before in (frame.saturating_sub(self.settings.n_before)..frame).rev() {
            let expected = self.pose(frame).inverse() * self.pose(before);
            self.tie(frame, before, &expected, self.settings.registration.gate_m * 2.0, false);
        }
        let near = self.neighbors(frame);
        let ways = self.ways_from(frame, self.settings.trusted_way_m);
        let known = near.into_iter().filter(|other| ways.get(*other).is_some_and(|way| way.is_finite()));
        for other in known.take(self.settings.n_neighbors).collect::<Vec<_>>() {
            let expected = self.pose(frame).inverse() * self.pose(other);
            self.tie(frame, other, &expected, self.settings.registration.gate_m * 2.0, false);
        }
    }

    /// Frames near this one that are not its predecessors or successors, nearest first.
    pub fn neighbors(&self, frame: usize) -> Vec<usize> {
        let (here, reach_m) = (self.pose(frame), self.settings.neighbor_reach_m);
        let mut near: Vec<(u64, usize)> = (0..self.frames.len())
            .filter(|other| other.abs_diff(frame) > self.settings.n_before)
            .filter_map(|other| {
                let off = here.inverse() * self.pose(other);
                let off_m = off.translation.vector.norm() + TURN_AS_WAY_M * off.rotation.angle().abs();
                (off_m < reach_m).then_some(((off_m * 1e6) as u64, other))
            })
            .collect();
        near.sort_unstable();
        near.into_iter().map(|(_, other)| other).collect()
    }

    /// Registers all neighbors once more from where they are now, and optimizes.
    pub fn refine(&mut self, n_rounds: usize) {
        for _ in 0..n_rounds {
            self.graph.retain(is_by_odometer);
            self.tried.clear();
            for frame in 0..self.frames.len() {
                let before = (frame.saturating_sub(self.settings.n_before)..frame).rev();
                let near = self.neighbors(frame).into_iter().take(self.settings.n_neighbors);
                for other in before.chain(near).collect::<Vec<_>>() {
                    let expected = self.pose(frame).inverse() * self.pose(other);
                    self.tie(frame, other, &expected, self.settings.registration.gate_m, false);
                }
            }
            self.optimize(10);
        }
    }
}
