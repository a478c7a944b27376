//! One line on the terminal while the robot drives.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use rumbo_core::engine::{Observer, StepView};
use rumbo_core::pipeline::Pipeline;
use std::time::{Duration, Instant};

/// Simulated time, speed, state and the distance that is left.
pub struct Progress {
    bar: ProgressBar,
    n_goals: usize,
    clock: Instant,
    shown: Option<Instant>,
}

impl Progress {
    /// Between two changes of the line.
    const PERIOD: Duration = Duration::from_millis(100);

    /// For a run that starts now.
    pub fn new(pipeline: &Pipeline) -> Progress {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if let Ok(style) = ProgressStyle::with_template("{spinner} {msg}") {
            bar.set_style(style);
        }
        Progress { bar, n_goals: pipeline.mission.waypoints.len(), clock: Instant::now(), shown: None }
    }

    /// Removes the line.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Progress {
    fn on_step(&mut self, view: &StepView<'_>) {
        if self.shown.is_some_and(|shown| shown.elapsed() < Self::PERIOD) {
            return;
        }
        self.shown = Some(Instant::now());
        let factor = view.now.as_secs() / self.clock.elapsed().as_secs_f64().max(1e-6);
        let mut line = format!("{} {:7.1} s  {factor:5.0}x", view.state, view.now.as_secs());
        if let Some(goal) = view.goal {
            let left_m = (goal.position.coords - view.map_from_base.translation.vector).norm();
            line +=
                &format!("  {left_m:.1} m to goal {}", (self.n_goals + 1).saturating_sub(view.n_goals_left));
            if self.n_goals > 1 {
                line += &format!(" of {}", self.n_goals);
            }
        }
        self.bar.set_message(line);
        self.bar.tick();
    }
}
