//! Where the robot was at each laser scan, as lines that `rumbo eval` reads: as it was thought at the time, and as the
//! plugin in `[slam]` knows it at the end.

use crate::exit::Failure;
use rumbo_core::engine::{Engine, Observer, State, StepView};
use rumbo_core::frames::{Pose2, flatten};
use rumbo_core::messages::Data;
use rumbo_core::pipeline::Pipeline;
use rumbo_core::time::Time;
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
        write_line(&mut self.lines, view.now, &view.map_from_base);
    }
}

fn write_line(lines: &mut String, stamp: Time, pose: &Pose2) {
    let (place, yaw) = (pose.translation, pose.rotation.angle());
    // Writing into a string cannot fail.
    let _ = writeln!(lines, "{:.6} {:.6} {:.6} {yaw:.6}", stamp.as_secs(), place.x, place.y);
}

/// A pipeline without `[slam]` is refused before anything moves.
pub fn refuse_without_slam(pipeline: &Pipeline) -> Result<(), Failure> {
    if pipeline.slam.is_some() {
        return Ok(());
    }
    let help = "--poses writes where a localizer thought that the robot was";
    let message = "--trajectory writes what a [slam] knows at the end, and this pipeline has none";
    Err(Failure::Usage(format!("{message}; {help}")))
}

/// The trajectory of `[slam]` as lines of `t x y theta`.
pub fn trajectory_text(engine: &Engine) -> Result<String, Failure> {
    let poses = engine.trajectory();
    let poses = poses.map_err(|error| Failure::Internal(format!("no trajectory: {error}")))?;
    if poses.is_empty() {
        let message = "no trajectory: the plugin in [slam] keeps none, or it saw no scan";
        let help = "--poses writes where it thought that the robot was at the time";
        return Err(Failure::Usage(format!("{message}; {help}")));
    }
    let mut lines = String::new();
    poses.iter().for_each(|pose| write_line(&mut lines, pose.stamp, &flatten(&pose.map_from_base)));
    Ok(lines)
}
