//! How far the sweep is, on the terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A bar with the time that is left.
#[derive(Debug)]
pub struct Progress {
    bar: Option<ProgressBar>,
}

impl Progress {
    /// Of `n_runs`, shown where somebody looks.
    pub fn new(n_runs: usize, is_shown: bool) -> Progress {
        let bar = is_shown.then(|| {
            let bar = ProgressBar::with_draw_target(Some(n_runs as u64), ProgressDrawTarget::stderr());
            let template = "{bar:30} {pos} of {len} runs, {elapsed} gone, {eta} left  {msg}";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            bar
        });
        Progress { bar }
    }

    /// A run ended.
    pub fn step(&self, last: &str) {
        if let Some(bar) = &self.bar {
            bar.set_message(last.to_owned());
            bar.inc(1);
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
