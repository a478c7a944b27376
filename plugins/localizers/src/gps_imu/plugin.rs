//! The localizer as a stage of the framework.

use rumbo_core::map::Map;
use rumbo_core::messages::{Check, Data, Estimate, ObservationKind, Prior, Seen};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};

use super::params::{Fusion, GpsImuParams, HeadingSource};
use super::tracker::{Tracker, TrackerSettings};
use crate::prior::beginning;

/// See [`GpsImuParams`].
#[derive(Debug)]
pub struct GpsImu {
    settings: TrackerSettings,
    tracker: Option<Tracker>,
}

impl GpsImu {
    /// A yaw that nobody measures must be named at the start, unless fixes can tell it.
    fn needs_start_pose(params: (Fusion, HeadingSource)) -> bool {
        matches!(params, (Fusion::Odometry | Fusion::Mean3, HeadingSource::Odometry))
    }
}

impl Localizer for GpsImu {
    fn start(&mut self, prior: &Prior, _map: &Map) -> Result<(), LocalizeError> {
        let (at, odom_from_base) = beginning(prior, "a pose, or a fix")?;
        if at.is_none() && Self::needs_start_pose((self.settings.fusion, self.settings.heading)) {
            return Err(LocalizeError::Prior {
                prior: "an unknown pose",
                needs: "a pose, or a measured yaw",
            });
        }
        self.tracker = Some(Tracker::new(self.settings.clone(), at, odom_from_base));
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _map: &Map) -> Result<Estimate, LocalizeError> {
        let Some(tracker) = &mut self.tracker else { return Err(LocalizeError::NotStarted) };
        let valid = seen.iter().filter(|observation| observation.valid);
        // Everything or nothing: after an error the same readings come again, and no fix may count twice.
        for observation in valid.clone() {
            match &observation.data {
                Data::Odometry(odometry) => odometry.check()?,
                Data::Imu(imu) => imu.check()?,
                Data::PositionFix(fix) => fix.check()?,
                _ => {}
            }
        }
        // The wheels first: of readings of one moment, they say what the others are seen from.
        let mut odometry = seen.odometry().filter(|(observation, _)| observation.valid).peekable();
        for observation in valid {
            while let Some((of, reading)) = odometry.next_if(|(of, _)| of.stamp <= observation.stamp) {
                tracker.take_odometry(of.stamp, reading);
            }
            match &observation.data {
                Data::Imu(imu) => tracker.take_imu(observation.stamp, &observation.base_from_sensor, imu),
                Data::PositionFix(fix) => {
                    tracker.take_fix(observation.stamp, &observation.base_from_sensor, fix);
                }
                _ => {}
            }
        }
        let counts = tracker.take_counts();
        cx.trace.count("fixes_used", counts.n_used.into());
        cx.trace.count("readings_refused", counts.n_refused.into());
        cx.trace.count("restarts", counts.n_placed.into());
        cx.trace.count("readings_untimely", counts.n_untimely.into());
        if let Some(bias_rad) = tracker.yaw_bias_rad() {
            cx.trace.count("yaw_bias_deg", bias_rad.to_degrees());
        }
        let (stamp, odom_from_base) = tracker.newest();
        let Some((pose, covariance)) = tracker.pose(cx.now) else { return Ok(Estimate::lost(cx.now)) };
        let mut estimate = Estimate::planar(stamp.unwrap_or(cx.now), pose, odom_from_base, covariance);
        estimate.status = tracker.status(&covariance);
        Ok(estimate)
    }
}

impl Plugin<dyn Localizer> for GpsImuParams {
    fn manifest(&self) -> Manifest {
        let mut consumes = vec![vec![ObservationKind::PositionFix]];
        if self.heading == HeadingSource::Imu {
            consumes.push(vec![ObservationKind::Imu]);
        }
        if self.fusion != Fusion::Mean3 || self.heading == HeadingSource::Odometry {
            consumes.push(vec![ObservationKind::Odometry]);
        }
        Manifest {
            consumes,
            needs_start_pose: GpsImu::needs_start_pose((self.fusion, self.heading)),
            ..Manifest::default()
        }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        Ok(Box::new(GpsImu { settings: self.settings(&context.robot), tracker: None }))
    }
}

rumbo_core::register_localizer!(
    GpsImuParams,
    "gps_imu",
    "satellite fixes with a measured yaw, fused with wheels; or the mean of three fixes"
);
