//! Odometry by scans as a stage of the framework.

use super::params::{Prediction, ScanOdometryParams};
use super::tracker::{Tracker, TrackerSettings};
use crate::prior::{known_beginning, scans_last};
use rumbo_core::map::Map;
use rumbo_core::messages::{Estimate, ObservationKind, Prior, Seen};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};

/// See [`ScanOdometryParams`].
#[derive(Debug)]
pub struct ScanOdometry {
    settings: TrackerSettings,
    tracker: Option<Tracker>,
}

impl Localizer for ScanOdometry {
    fn start(&mut self, prior: &Prior, _map: &Map) -> Result<(), LocalizeError> {
        let ((map_from_base, covariance), odom_from_base) = known_beginning(prior)?;
        self.tracker = Some(Tracker::new(self.settings.clone(), map_from_base, covariance, odom_from_base));
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _map: &Map) -> Result<Estimate, LocalizeError> {
        let Some(tracker) = &mut self.tracker else { return Err(LocalizeError::NotStarted) };
        scans_last(seen, |observation| tracker.take(observation));
        if cx.trace.is_counting() {
            show(tracker, cx);
        }
        Ok(tracker.estimate(cx.now))
    }
}

fn show(tracker: &Tracker, cx: &Cx<'_>) {
    let counts = tracker.counts();
    cx.trace.count("scans_matched", counts.n_matched as f64);
    cx.trace.count("scans_degenerate", counts.n_degenerate as f64);
    cx.trace.count("scans_with_too_few_points", counts.n_too_few as f64);
    cx.trace.count("scans_that_do_not_fit", counts.n_misfits as f64);
    cx.trace.count("key_scans", counts.n_keys as f64);
    cx.trace.count("scans_late", counts.n_late as f64);
    cx.trace.count("scans_of_other_scanners", counts.n_other as f64);
    cx.trace.count("pictures_that_tell_the_pitch", counts.n_pitched as f64);
    cx.trace.count("readings_refused", counts.n_refused as f64);
    if let Some(step) = tracker.last_step() {
        cx.trace.count("overlap", step.matched.overlap);
        cx.trace.count("support", step.matched.support);
        cx.trace.count("rms_mm", 1000.0 * step.matched.rms_m);
    }
}

impl Plugin<dyn Localizer> for ScanOdometryParams {
    fn manifest(&self) -> Manifest {
        let mut consumes = vec![vec![ObservationKind::LaserScan]];
        let mut uses = Vec::new();
        match self.prediction {
            Prediction::Wheels => consumes.push(vec![ObservationKind::Odometry]),
            Prediction::Either => {
                consumes.push(vec![ObservationKind::Odometry]);
                uses.push(ObservationKind::Imu);
            }
            Prediction::Gyro => uses.push(ObservationKind::Imu),
            Prediction::ConstantVelocity | Prediction::None => {}
        }
        if self.vertical_slice {
            consumes.push(vec![ObservationKind::DepthImage]);
        }
        Manifest { consumes, uses, needs_start_pose: true, ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        Ok(Box::new(ScanOdometry { settings: self.settings(&context.robot), tracker: None }))
    }
}

rumbo_core::register_localizer!(
    ScanOdometryParams,
    "scan_odometry",
    "odometry by laser scans alone: each is registered to a key scan, point to line, with a gyro where there is one"
);
