//! The navigation filter as a stage of the framework.

use rumbo_core::map::Map;
use rumbo_core::messages::{Estimate, ObservationKind, Prior, Seen};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};

use super::params::NavFilterParams;
use super::tracker::{Tracker, TrackerSettings};
use crate::prior::{known_beginning, scans_last};

/// See [`NavFilterParams`].
#[derive(Debug)]
pub struct NavFilterLocalizer {
    settings: TrackerSettings,
    tracker: Option<Tracker>,
}

impl Localizer for NavFilterLocalizer {
    fn start(&mut self, prior: &Prior, _map: &Map) -> Result<(), LocalizeError> {
        let (at, odom_from_base) = known_beginning(prior)?;
        let tracker = Tracker::new(self.settings.clone(), at, odom_from_base);
        self.tracker = Some(tracker.map_err(|fault| LocalizeError::Other(fault.to_string()))?);
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _map: &Map) -> Result<Estimate, LocalizeError> {
        let Some(tracker) = &mut self.tracker else { return Err(LocalizeError::NotStarted) };
        // Samples first: the filter then knows both sides of a scan's time.
        scans_last(seen, |observation| tracker.take(observation));
        if cx.trace.is_counting() {
            show(tracker, cx);
        }
        Ok(tracker.estimate(cx.now))
    }
}

fn show(tracker: &Tracker, cx: &Cx<'_>) {
    let (scans, filter) = tracker.counts();
    for (name, n) in [
        ("scans_matched", scans.n_matched),
        ("scans_degenerate", scans.n_degenerate),
        ("scans_unmatched", scans.n_unmatched),
        ("scans_without_samples", scans.n_alone),
        ("scans_not_seeing_the_way", scans.n_unseen),
        ("scans_late", scans.n_late),
        ("readings_refused", scans.n_refused),
        ("samples_used", filter.n_samples),
        ("samples_bad", filter.n_bad),
        ("samples_not_newer", filter.n_not_newer),
        ("sample_gaps", filter.n_gaps),
        ("updates_rejected", filter.n_rejected),
        ("updates_not_positive", filter.n_not_positive),
        ("measurements_untimely", filter.n_untimely),
    ] {
        cx.trace.count(name, n as f64);
    }
}

impl Plugin<dyn Localizer> for NavFilterParams {
    fn manifest(&self) -> Manifest {
        let mut consumes = vec![vec![ObservationKind::Imu]];
        if self.wheels {
            consumes.push(vec![ObservationKind::Odometry]);
        }
        let uses = vec![ObservationKind::LaserScan];
        Manifest { consumes, uses, needs_start_pose: true, ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        Ok(Box::new(NavFilterLocalizer { settings: self.settings(&context.robot), tracker: None }))
    }
}

rumbo_core::register_localizer!(
    NavFilterParams,
    "nav_filter",
    "where the base went in space: an inertial measurement unit, held over the floor by scans"
);
