//! Where the robot was thought to be at each laser scan, as lines that `rumbo eval` reads.

use rumbo_core::engine::{Observer, State, StepView};
use rumbo_core::messages::Data;
use std::fmt::Write as _;

/// Lines of `t x y theta`, one for each moment at which a scan was taken and the robot was not lost; seconds from the world's
/// time zero, meters, radians.
#[derive(Default)]
pub struct Poses {
    lines: String,
}

impl Poses {
    /// What was written down.
    pub fn text(&self) -> &str {
        &self.lines
    }
}

impl Observer for Poses {
    fn on_step(&mut self, view: &StepView<'_>) {
        let has_scan = view
            .observations
            .iter()
            .any(|seen| seen.stamp == view.now && matches!(seen.data, Data::LaserScan(_)));
        if !has_scan || matches!(view.state, State::NoMap | State::Lost | State::Localizing) {
            return;
        }
        let (place, yaw) = (view.map_from_base.translation, view.map_from_base.rotation.angle());
        // Writing into a string cannot fail.
        let _ = writeln!(self.lines, "{:.6} {:.6} {:.6} {yaw:.6}", view.now.as_secs(), place.x, place.y);
    }
}
