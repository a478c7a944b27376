//! Scan matching as a stage of the framework.

use super::params::ScanMatchSlamParams;
use super::saved;
use super::tracker::{ScanTracker, Tracked};
use crate::unseen::is_unsure;
use nalgebra::Matrix3;
use rumbo_core::frames::{Pose2, lift};
use rumbo_core::map::{GridFault, Layer, Map};
use rumbo_core::messages::{Check, Estimate, ObservationKind, Prior, Seen, StampedPose, Status};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, Slam, SlamError};
use rumbo_core::time::Time;
use rumbo_core::trace::Trace;
use rumbo_kit::scan_match::MatchStatus;

/// See [`ScanMatchSlamParams`].
#[derive(Debug)]
pub struct ScanMatchSlam {
    tracker: ScanTracker,
    keeps_trajectory: bool,
}

fn grid_error(fault: GridFault) -> SlamError {
    SlamError::Other(fault.to_string())
}

/// The map's frame is where the robot begins.
fn origin() -> (Pose2, Matrix3<f64>) {
    (Pose2::identity(), Matrix3::identity() * 1e-6)
}

/// A covariance that can be worked with; the default of a start where it cannot.
fn usable(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let symmetric = (covariance + covariance.transpose()) * 0.5;
    if symmetric.cholesky().is_some() { symmetric } else { Matrix3::identity() * 1e-2 }
}

impl ScanMatchSlam {
    fn estimate(&self, now: Time) -> Result<Estimate, SlamError> {
        let Some(state) = self.tracker.state else {
            let (map_from_base, covariance) = self.tracker.pending.unwrap_or_else(origin);
            let odom_from_base = self.tracker.motion.odom_from_base(now);
            return Ok(Estimate::planar(now, map_from_base, odom_from_base, covariance));
        };
        let Tracked { stamp, map_from_base, covariance } = self.tracker.reckoned(&state, now);
        let odom_from_base = self.tracker.motion.odom_from_base(stamp);
        let mut estimate = Estimate::planar(stamp.min(now), map_from_base, odom_from_base, covariance);
        let is_blind = stamp > state.stamp;
        estimate.status = if self.tracker.is_lost() {
            Status::Lost
        } else if self.tracker.n_without_match > 0 || is_blind || is_unsure(&covariance) {
            Status::Converging
        } else {
            Status::Tracking
        };
        estimate.check()?;
        Ok(estimate)
    }

    fn show(&self, trace: &Trace) {
        let counters = &self.tracker.counters;
        for (name, value) in [
            ("scans received", counters.received),
            ("scans matched", counters.matched),
            ("scans inserted", counters.inserted),
            ("scans dropped: not newer than the last", counters.not_newer),
            ("scans not matched: too few points", counters.too_few_points),
            ("scans not matched: low overlap", counters.low_overlap),
            ("scans not matched: diverged", counters.diverged),
            ("scans that do not see all directions", counters.degenerate),
            ("places found near the guess", counters.found_near),
            ("places found on the whole map", counters.found_anywhere),
        ] {
            trace.count(name, value as f64);
        }
        let is_degenerate = self.tracker.status == MatchStatus::Degenerate;
        trace.count("degenerate", f64::from(u8::from(is_degenerate)));
    }
}

impl Slam for ScanMatchSlam {
    fn start(&mut self, prior: &Prior, map: &mut Map) -> Result<(), SlamError> {
        prior.check()?;
        match prior {
            Prior::Pose { map_from_base, covariance, .. } => {
                self.tracker.begin(*map_from_base, usable(covariance), map).map_err(grid_error)
            }
            Prior::Unknown => {
                let (map_from_base, covariance) = origin();
                self.tracker.begin(map_from_base, covariance, map).map_err(grid_error)
            }
            Prior::Saved(bytes) => saved::restore(&mut self.tracker, bytes, map).map_err(|broken| {
                SlamError::Other(format!("these bytes are no saved state of this plugin: {broken:?}"))
            }),
        }
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, map: &mut Map) -> Result<Estimate, SlamError> {
        self.tracker.follow(seen);
        for (observation, scan) in seen.laser_scans().filter(|(observation, _)| observation.valid) {
            self.tracker.take(observation, scan, map).map_err(grid_error)?;
        }
        self.tracker.keep(map);
        if !self.keeps_trajectory {
            self.tracker.trajectory.clear();
        }
        if cx.trace.is_counting() {
            self.show(cx.trace);
        }
        self.estimate(cx.now)
    }

    fn relocate(&mut self, prior: &Prior, _: &mut Map) -> Result<(), SlamError> {
        prior.check()?;
        match prior {
            Prior::Pose { map_from_base, covariance, .. } => {
                self.tracker.relocate(Some((*map_from_base, usable(covariance))));
            }
            Prior::Unknown => self.tracker.relocate(None),
            Prior::Saved(_) => {
                return Err(SlamError::Prior { prior: "a saved state", needs: "a pose, or none" });
            }
        }
        Ok(())
    }

    fn trajectory(&self) -> Result<Vec<StampedPose>, SlamError> {
        let pose = |(stamp, map_from_base): &(Time, Pose2)| StampedPose {
            stamp: *stamp,
            map_from_base: lift(map_from_base),
        };
        Ok(self.tracker.trajectory.iter().map(pose).collect())
    }

    fn keep_no_trajectory(&mut self) {
        self.keeps_trajectory = false;
    }

    fn save(&self) -> Result<Vec<u8>, SlamError> {
        saved::save(&self.tracker).ok_or(SlamError::Other("no scan was seen yet: nothing to save".into()))
    }
}

impl Plugin<dyn Slam> for ScanMatchSlamParams {
    fn manifest(&self) -> Manifest {
        Manifest {
            gives_layers: vec![Layer::Grid],
            consumes: vec![vec![ObservationKind::LaserScan]],
            uses: vec![ObservationKind::Odometry, ObservationKind::Imu],
            ..Manifest::default()
        }
    }

    fn build(&self, _: &BuildContext) -> Result<Box<dyn Slam>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let evidence = self.evidence().map_err(|_| BuildError::at("", "impossible evidence"))?;
        let tracker = ScanTracker::new(self.tracker(evidence));
        Ok(Box::new(ScanMatchSlam { tracker, keeps_trajectory: true }))
    }
}

rumbo_core::register_slam!(
    ScanMatchSlamParams,
    "scan_match_slam",
    "each laser scan is matched against the grid of those before it; no odometer is needed"
);
