//! A step of the engine as messages, in the order in which its data flows: what a recorder writes, and what a replay
//! compares with what was written.

use super::cdr::CdrWriter;
use super::layout::{COMMAND, ESTIMATE, EVENT, Layout, MAP, ORDER, PATH, STEP, observation_layout};
use super::map_code::put_map_hash;
use super::observation::{put_observation, put_observation_head};
use super::order_code::put_order;
use super::outputs::{StepMark, put_command, put_estimate, put_event, put_path, put_step};
use super::packed_step::ViewerCopy;
use rumbo_core::engine::StepView;
use rumbo_core::map::Map;
use rumbo_core::messages::{ObservationKind, SensorId};

/// What a message of a step says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Said {
    /// An order from outside.
    Order,
    /// What a sensor saw.
    Observation(SensorId, ObservationKind),
    /// Which map there is.
    Map,
    /// Where the robot is.
    Estimate,
    /// Which way to go.
    Path,
    /// What went to the wheels.
    Command,
    /// What happened.
    Event,
    /// The end of the step.
    Step,
}

impl Said {
    /// The layout of its message.
    pub fn layout(self) -> Layout {
        match self {
            Said::Order => ORDER,
            Said::Observation(_, kind) => observation_layout(kind).unwrap_or(STEP),
            Said::Map => MAP,
            Said::Estimate => ESTIMATE,
            Said::Path => PATH,
            Said::Command => COMMAND,
            Said::Event => EVENT,
            Said::Step => STEP,
        }
    }

    /// Its topic, where sensors have these names.
    pub fn topic(self, sensors: &[String]) -> String {
        match self {
            Said::Order => "/rumbo/order".to_owned(),
            Said::Observation(sensor, kind) => {
                format!("/rumbo/sensor/{}/{}", sensor_name(sensors, sensor), kind.name())
            }
            Said::Map => "/rumbo/map".to_owned(),
            Said::Estimate => "/rumbo/estimate".to_owned(),
            Said::Path => "/rumbo/path".to_owned(),
            Said::Command => "/rumbo/command".to_owned(),
            Said::Event => "/rumbo/event".to_owned(),
            Said::Step => "/rumbo/step".to_owned(),
        }
    }
}

/// Name of a sensor; the odometer seat speaks like one.
pub fn sensor_name(sensors: &[String], sensor: SensorId) -> &str {
    sensors.get(usize::from(sensor.0)).map_or("odometer", String::as_str)
}

/// Turns steps into messages.
#[derive(Debug, Default)]
pub struct StepEncoder {
    path_number: u64,
    last_step: Option<u64>,
    cdr: CdrWriter,
    /// The map's version, and the message that tells which it is.
    map: (Option<u64>, CdrWriter),
}

impl StepEncoder {
    /// Gives every message of a step to `say`.
    pub fn encode(&mut self, view: &StepView<'_>, say: &mut impl FnMut(Said, &[u8])) {
        self.encode_beside(&[], view, &mut |said, message, _| say(said, message));
    }

    /// As [`StepEncoder::encode`]; of observations that viewers have a copy of, what stands before the readings.
    pub fn encode_beside(
        &mut self,
        copies: &[Option<ViewerCopy>],
        view: &StepView<'_>,
        say: &mut impl FnMut(Said, &[u8], Option<ViewerCopy>),
    ) {
        let is_first = self.last_step.is_none();
        // What the world says at its end comes with the step that was told already.
        if self.last_step.replace(view.step) == Some(view.step) {
            return self.events(view, say);
        }
        for order in view.orders {
            put_order(&mut self.cdr, order);
            say(Said::Order, self.cdr.bytes(), None);
        }
        for (idx, observation) in view.observations.iter().enumerate() {
            let copy = copies.get(idx).copied().flatten();
            match copy {
                Some(_) => put_observation_head(&mut self.cdr, observation),
                None => put_observation(&mut self.cdr, observation),
            }
            say(Said::Observation(observation.sensor, observation.data.kind()), self.cdr.bytes(), copy);
        }
        if is_first {
            self.map(view.map, &mut |said, message| say(said, message, None));
        }
        if view.estimate_is_new {
            put_estimate(&mut self.cdr, view.estimate);
            say(Said::Estimate, self.cdr.bytes(), None);
        }
        if view.path_number != self.path_number {
            self.path_number = view.path_number;
            put_path(&mut self.cdr, view.path_number, view.path);
            say(Said::Path, self.cdr.bytes(), None);
        }
        if view.command.stamp == view.now {
            put_command(&mut self.cdr, view.command, !view.not_actuated);
            say(Said::Command, self.cdr.bytes(), None);
        }
        self.events(view, say);
        let mark = StepMark { step: view.step, now: view.now, truth: view.truth.copied() };
        put_step(&mut self.cdr, &mark, view.state);
        say(Said::Step, self.cdr.bytes(), None);
    }

    fn events(&mut self, view: &StepView<'_>, say: &mut impl FnMut(Said, &[u8], Option<ViewerCopy>)) {
        for event in view.events {
            put_event(&mut self.cdr, event);
            say(Said::Event, self.cdr.bytes(), None);
        }
    }

    /// Which map there is: in the first step, and again when the run is over. A map that changed has another version.
    pub fn map(&mut self, map: &Map, say: &mut impl FnMut(Said, &[u8])) {
        let (version, message) = &mut self.map;
        if version.replace(map.version) != Some(map.version) {
            put_map_hash(message, map);
        }
        say(Said::Map, message.bytes());
    }
}
