//! Wall time that stages use: for observers only, nothing in a run depends on it.

use std::time::{Duration, Instant};

/// The parts of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The world: simulation, or reading a recording.
    World,
    /// All sensors.
    Sensors,
    /// Odometer, localizer, relocalizer, SLAM.
    Localizer,
    /// All map builders.
    MapBuilders,
    /// Planner and second planner, where they run inside the step.
    Planner,
    /// The avoider.
    Avoider,
    /// The guard.
    Guard,
}

impl Part {
    /// All of them, in the order of a step.
    pub const ALL: [Part; 7] = [
        Part::World,
        Part::Sensors,
        Part::Localizer,
        Part::Planner,
        Part::Avoider,
        Part::Guard,
        Part::MapBuilders,
    ];

    /// The word used in reports.
    pub fn name(self) -> &'static str {
        match self {
            Part::World => "world",
            Part::Sensors => "sensors",
            Part::Localizer => "localizer",
            Part::MapBuilders => "map_builders",
            Part::Planner => "planner",
            Part::Avoider => "avoider",
            Part::Guard => "guard",
        }
    }
}

/// Time used by each part since the start of the run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StageTimes([Duration; 7]);

impl StageTimes {
    /// Time used by one part.
    pub fn of(&self, part: Part) -> Duration {
        self.0[part as usize]
    }

    /// Time used by all parts.
    pub fn total(&self) -> Duration {
        self.0.iter().sum()
    }

    pub(crate) fn add(&mut self, part: Part, since: Instant) {
        self.0[part as usize] += since.elapsed();
    }
}
