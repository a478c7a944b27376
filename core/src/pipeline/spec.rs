//! The parts of a pipeline.

use super::{Mission, PipelineTest};
use crate::frames::Pose3;
use crate::map::Layer;
use crate::messages::{ObservationKind, SensorId};
use crate::registry::{Configured, Entry, Manifest};
use crate::robot::Robot;
use crate::time::{Span, Time};
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// How often something runs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Rate {
    /// So many times a second (`rate_hz`).
    Hz(f64),
    /// Once in so many seconds (`every_s`).
    Every(f64),
}

impl Rate {
    /// When run `k` is due, exactly: rounding never adds up.
    pub fn due(self, k: u64) -> Time {
        let ns = match self {
            Rate::Hz(hz) => (k as f64) * 1e9 / hz,
            Rate::Every(seconds) => (k as f64) * seconds * 1e9,
        };
        Time(ns.floor() as i64)
    }

    /// How often, times a second.
    pub fn hz(self) -> f64 {
        match self {
            Rate::Hz(hz) => hz,
            Rate::Every(seconds) => 1.0 / seconds,
        }
    }

    /// Time from one run to the next.
    pub fn period(self) -> Span {
        match self {
            Rate::Hz(hz) => Span::from_secs(1.0 / hz),
            Rate::Every(seconds) => Span::from_secs(seconds),
        }
    }
}

/// A stage of the pipeline with its plugin and parameters.
#[derive(Clone)]
pub struct StageSpec {
    /// Name of this instance: the sensor's name, else the section's.
    pub name: String,
    /// The plugin.
    pub entry: Arc<Entry>,
    /// The plugin with its parameters.
    pub configured: Arc<dyn Configured>,
    /// How often it runs; absent where it runs whenever there is something new.
    pub rate: Option<Rate>,
    /// Virtual time that a background job of this stage takes.
    pub latency: Span,
}

impl StageSpec {
    /// What the plugin needs and gives with these parameters.
    pub fn manifest(&self) -> Manifest {
        self.configured.manifest()
    }
}

impl fmt::Debug for StageSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {:?} at {:?}", self.name, self.entry, self.rate)
    }
}

/// A sensor of the pipeline.
#[derive(Debug, Clone)]
pub struct SensorSpec {
    /// Plugin and parameters.
    pub stage: StageSpec,
    /// Where it sits.
    pub base_from_sensor: Pose3,
    /// Sensors that a virtual one derives its observations from, as positions in [`Pipeline::sensors`].
    pub inputs: Vec<usize>,
}

/// A whole pipeline.
#[derive(Debug, Clone)]
pub struct Pipeline {
    /// What it is.
    pub name: String,
    /// Seed of every random stream.
    pub seed: u64,
    /// Folder that relative paths start from.
    pub folder: PathBuf,
    /// The robot.
    pub robot: Arc<Robot>,
    /// Where the robot is.
    pub world: StageSpec,
    /// End of a run without a mission, seconds of the world's time.
    pub duration_s: Option<f64>,
    /// In the order of the file; virtual ones after their inputs.
    pub sensors: Vec<SensorSpec>,
    /// The only publisher of odom → base, if there is one.
    pub odometer: Option<StageSpec>,
    /// In the order of the file.
    pub map_builders: Vec<StageSpec>,
    /// Finds the robot; excludes `slam`.
    pub localizer: Option<StageSpec>,
    /// Finds a lost robot.
    pub relocalizer: Option<StageSpec>,
    /// Map and place at once; excludes `localizer`.
    pub slam: Option<StageSpec>,
    /// Finds the way.
    pub planner: Option<StageSpec>,
    /// Asked when the planner has no answer.
    pub planner_fallback: Option<StageSpec>,
    /// Steers.
    pub avoider: Option<StageSpec>,
    /// What to do.
    pub mission: Mission,
    /// What to expect.
    pub tests: Vec<PipelineTest>,
}

impl Pipeline {
    /// What virtual sensors say instead of their inputs: a virtual sensor that makes the kind of observation that an input
    /// makes, makes it better, and everybody else gets the better one only.
    pub fn replaced(&self) -> Vec<(SensorId, ObservationKind)> {
        let mut replaced = Vec::new();
        for sensor in &self.sensors {
            let made = sensor.stage.manifest().produces;
            for input in &sensor.inputs {
                let Some(spec) = self.sensors.get(*input) else { continue };
                let given = spec.stage.manifest().produces;
                let same = given.into_iter().filter(|kind| made.contains(kind));
                replaced.extend(same.map(|kind| (SensorId(*input as u16), kind)));
            }
        }
        replaced
    }

    /// Every stage but the world, in the order of the data.
    pub fn stages(&self) -> impl Iterator<Item = &StageSpec> {
        let sensors = self.sensors.iter().map(|sensor| &sensor.stage);
        let middle = self.odometer.iter().chain(&self.localizer).chain(&self.relocalizer).chain(&self.slam);
        let last = self.planner.iter().chain(&self.planner_fallback).chain(&self.avoider);
        sensors.chain(middle).chain(&self.map_builders).chain(last)
    }

    /// Layers that some stage needs.
    pub fn wanted_layers(&self) -> Vec<Layer> {
        let mut layers: Vec<Layer> = self.stages().flat_map(|stage| stage.manifest().needs_layers).collect();
        layers.sort_unstable();
        layers.dedup();
        layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn due_times_never_drift() {
        assert_eq!(Rate::Hz(3.0).due(1), Time(333_333_333));
        assert_eq!(Rate::Hz(3.0).due(3_000_000), Time(1_000_000_000_000_000));
        assert_eq!(Rate::Hz(37.5).due(75), Time(2_000_000_000));
        assert_eq!(Rate::Every(4.0).due(3), Time(12_000_000_000));
        assert_eq!(Rate::Hz(10.0).period(), Span(100_000_000));
    }
}
