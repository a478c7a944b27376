//! What a step leaves behind: room in the ring, and a view for observers.

use super::observer::StepView;
use super::order::State;
use super::step::Engine;
use crate::frames::{Pose2, flatten};
use crate::stages::World;
use crate::trace::Trace;

impl Engine {
    /// Observations that every stage has read make room.
    pub(super) fn forget(&mut self) {
        let newest = self.ring.cursor();
        // A seat that is not asked at present starts from the present when it is asked again.
        let state = self.navigator.state;
        let localizing = state == State::Localizing && self.localization.relocalizer.is_some();
        if let Some(seat) = self.localization.relocalizer.as_mut().filter(|_| !localizing) {
            seat.cursor = newest;
        }
        let is_mapping = self.localization.finder.stage.is_mapping();
        if localizing || (!is_mapping && matches!(state, State::NoMap | State::Lost)) {
            self.localization.finder.cursor = newest;
        }
        if matches!(state, State::NoMap | State::Lost | State::Localizing) {
            self.builders.iter_mut().for_each(|seat| seat.cursor = newest);
        }
        let steering = state == State::Navigating || (state == State::Waiting && self.wanders);
        if let Some(seat) = self.avoider.as_mut().filter(|_| !steering) {
            seat.cursor = newest;
        }
        let cursors = [Some(self.localization.finder.cursor)]
            .into_iter()
            .chain([self.localization.relocalizer.as_ref().map(|seat| seat.cursor)])
            .chain([
                self.odometer.as_ref().map(|seat| seat.cursor),
                self.avoider.as_ref().map(|seat| seat.cursor),
            ])
            .chain(self.builders.iter().map(|seat| Some(seat.cursor)))
            .chain(self.sensors.iter().filter(|s| !s.inputs.is_empty()).map(|s| Some(s.seat.cursor)));
        let slowest = cursors.flatten().min().unwrap_or(newest);
        // The observations of this step stay for observers.
        self.ring.forget_before(slowest.min(self.ring.before_newest(self.n_new)), &mut self.out);
    }

    /// The robot in the map, now: the last estimate moved on by the odometer, so that a slow localizer never leaves the
    /// avoider on an old pose.
    pub fn map_from_base(&self) -> Pose2 {
        flatten(&self.localization.estimate.map_from_odom) * self.track.now_at(self.now)
    }

    /// The world, for those who watch.
    pub fn world(&self) -> &dyn World {
        self.world.as_ref()
    }

    /// From now on stages keep debug drawings and counters for observers.
    pub fn watch(&mut self) {
        self.trace = Trace::watched();
    }

    /// From now on planners keep debug drawings and counters for observers; the other stages are left as they are.
    pub fn watch_plans(&mut self) {
        self.planning.is_drawn = true;
    }

    /// From now on stages keep counters for observers.
    pub fn count(&mut self) {
        if !self.trace.is_counting() {
            self.trace = Trace::counting();
        }
    }

    /// The step as observers see it.
    pub fn view(&mut self) -> StepView<'_> {
        let map_from_base = self.map_from_base();
        StepView {
            now: self.now,
            started: self.started,
            step: self.step.saturating_sub(1),
            state: self.navigator.state,
            observations: self.ring.newest(self.n_new),
            estimate: &self.localization.estimate,
            estimate_is_new: self.estimate_is_new,
            map_from_base,
            odom_from_base: self.track.now_at(self.now),
            footprint_from_base: self.footprint_from_base,
            derived: &self.derived,
            truth: self.world.truth(),
            command: &self.command,
            not_actuated: self.not_actuated,
            orders: &self.obeyed,
            path: self.navigator.path.as_ref(),
            path_number: self.navigator.path_number,
            goal: self.navigator.goals.front(),
            n_goals_left: self.navigator.goals.len(),
            obstacles: self.navigator.memory.obstacles(),
            map: &self.map,
            drawings: &self.planning.drawings,
            stage_drawings: &self.stage_drawings,
            counters: &self.counters,
            events: &self.events,
            times: &self.times,
        }
    }
}
