//! What a scan adds to the map: longer walls, new ones, and walls that become one.

use super::FilterSettings;
use super::association::Match;
use super::filter::{LineFilter, ScanReport};
use super::growth::NewWall;
use super::merging::merge_one;
use super::sighting::{Mount, Viewpoint};
use super::wall::{Axes, Wall};
use crate::lines::SensedLine;

impl LineFilter {
    /// Extends the walls that were seen, and adds new ones.
    pub(super) fn grow(
        &mut self,
        seen: &[SensedLine],
        mount: &Mount,
        matches: &[Match],
        report: &mut ScanReport,
    ) {
        let view = Viewpoint::new(&self.state.robot, mount);
        for (wall, line) in self.walls.iter_mut().zip(&self.state.walls) {
            wall.follow(&Axes::new(*line));
        }
        let in_map = |line: &SensedLine| line.ends_m.map(|end| view.in_map(end));
        for found in matches {
            let line = self.state.walls.get(found.wall).copied();
            if let (Some(wall), Some(line), Some(seen)) =
                (self.walls.get_mut(found.wall), line, seen.get(found.seen))
            {
                wall.extend(&Axes::new(line), &in_map(seen));
            }
        }
        let mut touched: Vec<usize> = matches.iter().map(|found| found.wall).collect();
        if self.is_test_due() {
            touched.extend(self.test(seen, mount, matches, report));
        }
        if self.settings.growth.merge {
            self.merge(touched, report);
        }
    }

    /// It is time to look at lines that are no walls (a hair of a second early is in time).
    fn is_test_due(&self) -> bool {
        const HAIR_S: f64 = 1e-6;
        self.n_scans == 0 || self.untested_s >= self.settings.growth.test_period_s - HAIR_S
    }

    /// Lines that are no walls yet become candidates, or walls. Returns the walls that they became or turned out to be.
    fn test(
        &mut self,
        seen: &[SensedLine],
        mount: &Mount,
        matches: &[Match],
        report: &mut ScanReport,
    ) -> Vec<usize> {
        let view = Viewpoint::new(&self.state.robot, mount);
        let mut touched = Vec::new();
        let is_matched = |idx: usize| matches.iter().any(|found| found.seen == idx);
        for (_, line) in seen.iter().enumerate().filter(|(idx, _)| !is_matched(*idx)) {
            let ends_m = line.ends_m.map(|end| view.in_map(end));
            touched.extend(self.consider(line, ends_m, mount, report));
        }
        self.tentative.age(self.n_scans, &self.settings.growth);
        self.n_scans += 1;
        self.untested_s = 0.0;
        touched
    }

    /// A line that is no wall of the map yet. Returns the wall that it became or turned out to be.
    fn consider(
        &mut self,
        seen: &SensedLine,
        ends_m: [[f64; 2]; 2],
        mount: &Mount,
        report: &mut ScanReport,
    ) -> Option<usize> {
        let Self { settings: FilterSettings { growth, gates, .. }, state, walls, tentative, .. } = self;
        let new = NewWall::new(state, mount, seen);
        if !new.line.iter().chain(ends_m.iter().flatten()).all(|v| v.is_finite()) {
            return None;
        }
        let [[x, y], [other_x, other_y]] = seen.ends_m;
        let is_long = (x - other_x).hypot(y - other_y) >= growth.bootstrap_length_m;
        let piece = if growth.bootstrap && self.n_scans == 0 && is_long {
            Wall { ends_m }
        } else {
            let piece = tentative.see(new.line, ends_m, self.n_scans, growth)?;
            if let Some(known) = new.known_as(state, walls, &piece, gates) {
                let axes = Axes::new(*state.walls.get(known)?);
                walls.get_mut(known)?.extend(&axes, &piece.ends_m);
                return Some(known);
            }
            piece
        };
        new.add(state, walls, piece);
        report.n_added += 1;
        Some(walls.len() - 1)
    }

    fn merge(&mut self, mut touched: Vec<usize>, report: &mut ScanReport) {
        let Self { settings, state, walls, .. } = self;
        while let Some(gone) = merge_one(state, walls, &touched, &settings.gates) {
            report.n_merged += 1;
            let moved = walls.len();
            touched.retain(|wall| *wall != gone);
            touched.iter_mut().filter(|wall| **wall == moved).for_each(|wall| *wall = gone);
        }
    }
}
