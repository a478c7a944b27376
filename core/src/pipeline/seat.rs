//! The sections of a pipeline that plugins sit in.

use crate::registry::Stage;

/// A place in a pipeline for a plugin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Seat {
    /// `[world]`
    World,
    /// `[[sensor]]`
    Sensor,
    /// `[odometer]`
    Odometer,
    /// `[map_builder]` or `[[map_builder]]`
    MapBuilder,
    /// `[localizer]`
    Localizer,
    /// `[relocalizer]`
    Relocalizer,
    /// `[slam]`
    Slam,
    /// `[planner]`
    Planner,
    /// `[planner_fallback]`
    PlannerFallback,
    /// `[avoider]`
    Avoider,
}

impl Seat {
    /// All of them, in the order of the data.
    pub const ALL: [Seat; 10] = [
        Seat::World,
        Seat::Sensor,
        Seat::Odometer,
        Seat::MapBuilder,
        Seat::Localizer,
        Seat::Relocalizer,
        Seat::Slam,
        Seat::Planner,
        Seat::PlannerFallback,
        Seat::Avoider,
    ];

    /// Its name in the file.
    pub fn section(self) -> &'static str {
        match self {
            Seat::World => "world",
            Seat::Sensor => "sensor",
            Seat::Odometer => "odometer",
            Seat::MapBuilder => "map_builder",
            Seat::Localizer => "localizer",
            Seat::Relocalizer => "relocalizer",
            Seat::Slam => "slam",
            Seat::Planner => "planner",
            Seat::PlannerFallback => "planner_fallback",
            Seat::Avoider => "avoider",
        }
    }

    /// The plugins that may sit here.
    pub fn stage(self) -> Stage {
        match self {
            Seat::World => Stage::World,
            Seat::Sensor => Stage::Sensor,
            Seat::MapBuilder => Stage::MapBuilder,
            Seat::Odometer | Seat::Localizer | Seat::Relocalizer => Stage::Localizer,
            Seat::Slam => Stage::Slam,
            Seat::Planner | Seat::PlannerFallback => Stage::Planner,
            Seat::Avoider => Stage::Avoider,
        }
    }

    /// The framework's keys that mean something here.
    pub fn reserved_keys(self) -> &'static [&'static str] {
        match self {
            Seat::World => &["plugin", "duration_s", "variants"],
            Seat::Sensor => {
                &["name", "plugin", "mount", "rate_hz", "every_s", "inputs", "latency_s", "variants"]
            }
            Seat::MapBuilder => &["name", "plugin", "rate_hz", "every_s", "latency_s", "variants"],
            Seat::Slam => &["plugin", "rate_hz", "every_s", "latency_s", "variants", "resume"],
            _ => &["plugin", "rate_hz", "every_s", "latency_s", "variants"],
        }
    }
}
