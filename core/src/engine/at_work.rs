//! Which stage a step is in: looked at from outside, when the step does not end.

use crate::pipeline::{Pipeline, StageSpec};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A place in a step where somebody else's code runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    /// Nobody's: the engine's own code, or between two steps.
    Nobody,
    /// The world.
    World,
    /// The odometer seat.
    Odometer,
    /// Localizer or SLAM.
    Finder,
    /// The relocalizer.
    Relocalizer,
    /// The planner.
    Planner,
    /// The second planner.
    Fallback,
    /// The avoider.
    Avoider,
    /// A sensor, by its place in the file.
    Sensor(usize),
    /// A map builder, by its place in the file.
    MapBuilder(usize),
}

/// Which stage a step is in.
#[derive(Debug)]
pub(super) struct AtWork {
    place: AtomicUsize,
    /// What each place is called: the fixed ones, sensors, map builders.
    names: Vec<String>,
    n_sensors: usize,
}

/// Places that every pipeline has.
const N_FIXED: usize = 8;

impl AtWork {
    /// Of the stages of this pipeline.
    pub fn of(pipeline: &Pipeline) -> AtWork {
        let fixed: [Option<&StageSpec>; N_FIXED] = [
            None,
            Some(&pipeline.world),
            pipeline.odometer.as_ref(),
            pipeline.slam.as_ref().or(pipeline.localizer.as_ref()),
            pipeline.relocalizer.as_ref(),
            pipeline.planner.as_ref(),
            pipeline.planner_fallback.as_ref(),
            pipeline.avoider.as_ref(),
        ];
        let sensors = pipeline.sensors.iter().map(|sensor| Some(&sensor.stage));
        let builders = pipeline.map_builders.iter().map(Some);
        let name = |spec: Option<&StageSpec>| spec.map(who).unwrap_or_default();
        let names = fixed.into_iter().chain(sensors).chain(builders).map(name).collect();
        AtWork::named(names, pipeline.sensors.len())
    }

    /// With these names: the fixed places, then the sensors, then the map builders.
    pub fn named(names: Vec<String>, n_sensors: usize) -> AtWork {
        AtWork { place: AtomicUsize::new(0), names, n_sensors }
    }

    /// From now on the step is here.
    pub fn enter(&self, place: Place) {
        self.place.store(self.index(place), Ordering::Relaxed);
    }

    /// The stage that is at work, with its plugin.
    pub fn who(&self) -> Option<&str> {
        let name = self.names.get(self.place.load(Ordering::Relaxed)).map(String::as_str);
        name.filter(|name| !name.is_empty())
    }

    /// What the stage in this place is called.
    pub fn name(&self, place: Place) -> &str {
        self.names.get(self.index(place)).map_or("", String::as_str)
    }

    fn index(&self, place: Place) -> usize {
        match place {
            Place::Nobody => 0,
            Place::World => 1,
            Place::Odometer => 2,
            Place::Finder => 3,
            Place::Relocalizer => 4,
            Place::Planner => 5,
            Place::Fallback => 6,
            Place::Avoider => 7,
            Place::Sensor(idx) => N_FIXED + idx,
            Place::MapBuilder(idx) => N_FIXED + self.n_sensors + idx,
        }
    }
}

/// A stage for people: its seat, its plugin, and where that comes from.
fn who(spec: &StageSpec) -> String {
    format!("{} `{}` of {}", spec.name, spec.entry.name, spec.entry.origin)
}
