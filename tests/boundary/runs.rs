//! Short runs with one plugin of a library in them.

use crate::compiler;
use rumbo::load;
use rumbo_core::engine::{Engine, EventKind, Observer, RunEnd, StepView};
use rumbo_core::registry::Registry;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// A robot on the way through an open piece of the office, with our own plugins in every seat.
const FLOOR: &str = r#"
name = "boundary"
seed = 1

[robot]
drive = { kind = "differential", track_m = 0.36 }
radius_m = 0.20
height_m = 0.45
max_speed_m_s = 0.2
max_turn_deg_s = 30.0

[world]
plugin = "sim"
map = "worlds/office-20m.yaml"
start = { x_m = 3.0, y_m = 4.5, yaw_deg = 90.0 }

[[sensor]]
name = "front"
mount = { x_m = 0.0, z_m = 0.30 }
rate_hz = 5.0
plugin = "lms200" # sensor

[[sensor]]
name = "wheels"
plugin = "wheel_encoders"
rate_hz = 20.0

[map_builder]
plugin = "static_map" # map_builder

[localizer]
plugin = "odometry" # localizer

[planner]
plugin = "a_star" # planner

[avoider]
plugin = "stop_and_replan" # avoider

[mission]
waypoints = [{ x_m = 3.0, y_m = 6.0 }]
"#;

/// The floor with other plugins: pairs of a section and what its `plugin` line becomes.
pub fn floor(other: &[(&str, &str)]) -> String {
    let mut text = FLOOR.to_owned();
    for (section, line) in other {
        let mark = format!("# {section}\n");
        let end = text.find(&mark).unwrap_or_else(|| panic!("no section {section}"));
        let start = text[..end].rfind('\n').unwrap() + 1;
        text.replace_range(start..end + mark.len(), &format!("{line}\n"));
    }
    text
}

/// Everything that a test asks about a run.
#[derive(Debug, Default)]
pub struct Told {
    /// Every event as text.
    pub events: Vec<String>,
    /// Name and words of every stage failure.
    pub failures: Vec<(String, String)>,
    /// Fastest command, m/s and rad/s; not-a-number where one was.
    pub fastest: f64,
    /// The first cell of the grid at the end.
    pub first_cell: Option<f32>,
    /// Number of ranges of every scan.
    pub n_ranges: Vec<usize>,
}

impl Observer for Told {
    fn on_step(&mut self, view: &StepView<'_>) {
        for event in view.events {
            self.events.push(event.kind.to_string());
            if let EventKind::StageFailed { stage, error } = &event.kind {
                self.failures.push((stage.clone(), error.clone()));
            }
        }
        let twist = view.command.twist;
        let speed = [twist.forward_m_s, twist.left_m_s, twist.turn_rad_s].map(f64::abs);
        let speed = speed.into_iter().fold(0.0, |a, b| if b.is_nan() || b > a { b } else { a });
        self.fastest = if speed > self.fastest || speed.is_nan() { speed } else { self.fastest };
        self.first_cell = view.map.grid.as_ref().and_then(|grid| grid.cells.first().copied());
        for seen in view.observations {
            if let rumbo_core::messages::Data::LaserScan(scan) = &seen.data {
                self.n_ranges.push(scan.ranges_m.len());
            }
        }
    }
}

/// What we ship, and the plugins of these libraries.
pub fn registry(libraries: &[&Path]) -> Registry {
    let mut registry = rumbo::registry().unwrap();
    for library in libraries {
        registry.load(library, None).unwrap();
    }
    registry
}

/// Runs a pipeline from its text for at most so many seconds, as if it lay beside those that we ship; the error is that
/// of the building.
pub fn run(text: &str, registry: &Registry, limit_s: f64) -> Result<(Told, RunEnd), String> {
    let path = compiler::root().join("pipelines/boundary.toml");
    let mut ready =
        load::from_text(&path, text, &[], registry).map_err(|refused| refused.to_json().to_string())?;
    ready.limit(limit_s);
    let mut engine = Engine::build(&ready.pipeline).map_err(|error| error.to_string())?;
    let mut told = Told::default();
    let end = engine.run(&mut [&mut told], &AtomicBool::new(false));
    Ok((told, end))
}
