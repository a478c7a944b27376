//! Watches a map grow.

use indicatif::{ProgressBar, ProgressDrawTarget};
use rumbo_core::engine::{Observer, StepView};
use rumbo_core::messages::Data;

/// Counts scans, and shows them where somebody looks.
pub struct MapWatch {
    /// Laser scans that came.
    pub n_scans: u64,
    /// Changes of the map after its builders were started.
    pub n_inserted: u64,
    version: Option<u64>,
    bar: Option<ProgressBar>,
}

impl MapWatch {
    /// Scans between two changes of the line.
    const SHOWN_EVERY: u64 = 64;

    /// For a run that starts now.
    pub fn new(is_shown: bool) -> MapWatch {
        let bar = is_shown.then(|| ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()));
        MapWatch { n_scans: 0, n_inserted: 0, version: None, bar }
    }

    /// Removes the line.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for MapWatch {
    fn on_step(&mut self, view: &StepView<'_>) {
        let scans = view.observations.iter().filter(|o| matches!(o.data, Data::LaserScan(_)));
        self.n_scans += scans.count() as u64;
        if self.version.replace(view.map.version).is_some_and(|version| version != view.map.version) {
            self.n_inserted += 1;
        }
        let is_time = self.n_scans.is_multiple_of(Self::SHOWN_EVERY);
        let Some(bar) = self.bar.as_ref().filter(|_| is_time) else { return };
        let (seconds, n_scans) = ((view.now - view.started).as_secs(), self.n_scans);
        bar.set_message(format!("{seconds:8.1} s of the recording, {n_scans} scans"));
        bar.tick();
    }
}
