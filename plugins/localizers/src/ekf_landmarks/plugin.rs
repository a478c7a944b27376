//! The filter as a localizer.

use rumbo_core::map::{Layer, Map};
use rumbo_core::messages::{Check, Data, Estimate, ObservationKind, Prior, Seen};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};

use super::known_marks::KnownMarks;
use super::params::EkfLandmarksParams;
use super::tracker::{Tracker, TrackerSettings};
use crate::prior::beginning;

/// See [`EkfLandmarksParams`].
#[derive(Debug)]
pub struct EkfLandmarks {
    settings: TrackerSettings,
    tracker: Option<Tracker>,
    /// The marks of the map, and the version that they are of.
    known: Option<(u64, KnownMarks)>,
}

impl EkfLandmarks {
    /// Takes the marks of the map as it is now.
    fn look_at_map(&mut self, map: &Map) -> Result<(), LocalizeError> {
        let Some(layer) = &map.landmarks else {
            return Err(LocalizeError::MissingLayer { layer: "landmarks" });
        };
        if self.known.as_ref().is_none_or(|(version, _)| *version != map.version) {
            self.known = Some((map.version, KnownMarks::of(layer).map_err(LocalizeError::Other)?));
        }
        Ok(())
    }
}

impl Localizer for EkfLandmarks {
    fn start(&mut self, prior: &Prior, map: &Map) -> Result<(), LocalizeError> {
        prior.check()?;
        self.known = None;
        self.look_at_map(map)?;
        let (at, odom_from_base) = beginning(prior, "a pose, or three marks")?;
        self.tracker = Some(Tracker::new(self.settings.clone(), at, odom_from_base));
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &Map) -> Result<Estimate, LocalizeError> {
        self.look_at_map(map)?;
        let (Some(tracker), Some((_, known))) = (&mut self.tracker, &self.known) else {
            return Err(LocalizeError::NotStarted);
        };
        let valid = seen.iter().filter(|observation| observation.valid);
        // Everything or nothing: after an error the same readings come again, and no mark may count twice.
        for observation in valid.clone() {
            match &observation.data {
                Data::Odometry(odometry) => odometry.check()?,
                Data::Marks(marks) => marks.check()?,
                _ => {}
            }
        }
        for observation in valid {
            match &observation.data {
                Data::Odometry(odometry) => tracker.take_odometry(observation.stamp, odometry),
                Data::Marks(marks) => {
                    tracker.take_marks(observation.stamp, &observation.base_from_sensor, marks, known);
                }
                _ => {}
            }
        }
        let counts = tracker.take_counts();
        cx.trace.count("marks_used", counts.n_used.into());
        cx.trace.count("marks_refused", counts.n_refused.into());
        cx.trace.count("marks_unknown", counts.n_unknown.into());
        cx.trace.count("marks_untimely", counts.n_untimely.into());
        let Some(belief) = tracker.belief() else { return Ok(Estimate::lost(cx.now)) };
        let (stamp, odom_from_base) = tracker.newest();
        cx.trace.count("distance_scale", 1.0 + belief.mean[3]);
        cx.trace.count("turn_scale", 1.0 + belief.mean[4]);
        let (stamp, covariance) = (stamp.unwrap_or(cx.now), belief.pose_covariance());
        let mut estimate = Estimate::planar(stamp, belief.pose(), odom_from_base, covariance);
        estimate.status = tracker.status();
        Ok(estimate)
    }
}

impl Plugin<dyn Localizer> for EkfLandmarksParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            needs_layers: vec![Layer::Landmarks],
            consumes: vec![vec![ObservationKind::Marks], vec![ObservationKind::Odometry]],
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let settings = self.settings(&context.robot);
        Ok(Box::new(EkfLandmarks { settings, tracker: None, known: None }))
    }
}

rumbo_core::register_localizer!(
    EkfLandmarksParams,
    "ekf_landmarks",
    "follows a robot by ranges and bearings to known marks; finds it by three"
);
