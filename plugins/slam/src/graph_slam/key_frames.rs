//! When a scan becomes a key frame, and what follows from that: ties, loops, an optimization.

use super::atlas::KeyFrame;
use super::loops::{Look, Recognized};
use super::tracker::Tracker;
use crate::rbpf_slam::archive::turned_into;
use rumbo_core::frames::Pose2;

/// After a loop so many frames are tied to neighbors that they could not trust before.
const CATCH_UP: usize = 80;
/// So many of them at one scan: all, for the same reason as that for the places of a look.
const CATCH_UP_AT_ONCE: usize = CATCH_UP;

/// Where so many frames in a row have a tie that is off by more than these deviations, squared, those that come next are
/// registered from a wrong place, and along a corridor they would stay there: the graph is optimized at once. One such frame
/// alone may have a false tie, which others outvote.
const STRAINED_IN_A_ROW: usize = 12;
const MOST_STRAIN: f64 = 16.0;

/// A loop that moves two frames in a row so far against each other is a false one, meters.
const MOST_TORN_M: f64 = 0.5;

impl Tracker {
    pub(super) fn is_key_frame(&self) -> bool {
        let [way_m, turn_rad] = self.settings.key_frame_every;
        self.atlas.frames.is_empty()
            || self.frame_from_base.translation.vector.norm() >= way_m
            || self.frame_from_base.rotation.angle().abs() >= turn_rad
    }

    pub(super) fn add_key_frame(&mut self, frame: KeyFrame) {
        let reckoned = self.before.map(|before| before.reckoned);
        let since = self.frame_reckoned.zip(reckoned);
        let is_first = self.atlas.frames.is_empty();
        let by_odometer =
            since.and_then(|(then, now)| Some(then.odom_from_base?.inverse() * now.odom_from_base?));
        let before = (!is_first).then(|| (self.front.frame, by_odometer.unwrap_or(self.frame_from_base)));
        let map_from_base = if is_first { self.first_pose } else { self.map_from_base() };
        let Some(added) = self.atlas.add(frame, &map_from_base, before) else { return };
        if !is_first {
            self.covariance = turned_into(&self.frame_from_base, &self.covariance);
        }
        self.frame_from_base = Pose2::identity();
        self.frame_reckoned = reckoned;
        if let (Some((before, _)), Some((then, now))) = (before, since)
            && let Some(turn_rad) = now.turn_since(&then)
        {
            let off_rad =
                self.settings.tie.off_by_gyroscope_rad(turn_rad, (now.stamp - then.stamp).as_secs());
            self.atlas.bind_turn(before, added, turn_rad, off_rad);
        }
        let n_known = self.atlas.graph.constraints().len();
        self.atlas.tie_neighbors(added);
        self.since_optimized += 1;
        let is_strained = self.atlas.strain_since(n_known) > MOST_STRAIN;
        self.n_strained = if is_strained { self.n_strained + 1 } else { 0 };
        let looks = self.is_adrift || added % self.settings.look_for_loops_every == 0;
        if looks && self.look.is_none() {
            self.look = Some(Look::begin(&self.atlas, added, self.is_adrift, &self.settings.loops));
        }
        let due = self.settings.optimize_every.max((self.settings.optimize_share * added as f64) as usize);
        if self.since_optimized >= due || self.n_strained >= STRAINED_IN_A_ROW {
            self.optimize();
        }
        let recent: Vec<usize> = ((added + 1).saturating_sub(self.settings.n_recent)..added + 1).collect();
        self.front.look_from(&self.atlas, added, &recent);
    }

    /// Goes on with what takes longer than there is time at one scan: ties after a loop, and the search for another one.
    pub(super) fn go_on(&mut self) {
        let [first, end] = self.catch_up;
        if first < end {
            let from = end.saturating_sub(CATCH_UP_AT_ONCE).max(first);
            (from..end).rev().for_each(|frame| self.atlas.tie_neighbors(frame));
            self.catch_up = [first, from];
            if from == first {
                self.optimize();
            }
        }
        let Some(mut look) = self.look.take() else { return };
        // All at once: spread over several scans the maps of real logs came out a little worse.
        let n_places = look.places.len();
        self.search.go_on(&self.atlas, &mut look, &self.settings.loops, n_places);
        match look.best {
            _ if !look.places.is_empty() => self.look = Some(look),
            Some(found) => self.close_loop(look.frame, &found),
            None => {}
        }
    }

    fn optimize(&mut self) {
        self.atlas.optimize(8);
        (self.since_optimized, self.n_strained) = (0, 0);
        self.n_moves += 1;
    }

    /// Ties a frame to where the robot has come back to and moves all frames accordingly.
    fn close_loop(&mut self, frame: usize, found: &Recognized) {
        let place_from_map = self.atlas.pose(found.place).inverse();
        let mut near: Vec<(u64, usize)> = found
            .frames
            .iter()
            .map(|other| {
                let seen = found.place_from_frame.inverse() * place_from_map * self.atlas.pose(*other);
                ((seen.translation.vector.norm() * 1e6) as u64, *other)
            })
            .collect();
        near.sort_unstable();
        let as_it_was = self.atlas.graph.clone();
        let (mut n_ties, mut is_old) = (0, self.unsure_since.is_none());
        for (_, other) in near {
            let expected = found.place_from_frame.inverse() * place_from_map * self.atlas.pose(other);
            let is_tied = self.atlas.tie(frame, other, &expected, 0.4, true);
            n_ties += usize::from(is_tied);
            is_old |= is_tied && self.unsure_since.is_some_and(|since| other < since);
            if n_ties == 3 {
                break;
            }
        }
        if n_ties == 0 {
            return;
        }
        self.optimize();
        if self.atlas.is_torn_since(&as_it_was, MOST_TORN_M) {
            self.atlas.take_back(as_it_was);
            return;
        }
        self.n_loops += 1;
        if is_old {
            self.is_placed_again();
        }
        let end = self.atlas.frames.len();
        self.catch_up = [end.saturating_sub(CATCH_UP), end];
    }
}
