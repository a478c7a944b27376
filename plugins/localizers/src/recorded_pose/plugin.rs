//! Recorded poses as a localizer.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};
use rumbo_core::frames::Pose2;
use rumbo_core::map::Map;
use rumbo_core::messages::{Check, Estimate, ObservationKind, Prior, Seen, Status};
use rumbo_core::registry::{Manifest, Params, Plugin};
use rumbo_core::stages::{BuildContext, BuildError, Cx, LocalizeError, Localizer};
use rumbo_core::time::{Span, Time};
use rumbo_kit::log_file::{BeamOverride, PoseTrack, Timeline, read_poses};
use rumbo_kit::tum_rgbd::{is_folder, read_camera_track, read_folder};

use super::follower::{Follower, Place};
use super::params::RecordedPoseParams;

rumbo_core::register_localizer!(
    RecordedPoseParams,
    "recorded_pose",
    "the pose that a file or the log itself has for each scan"
);

/// See [`RecordedPoseParams`].
#[derive(Debug)]
pub struct RecordedPose {
    follower: Follower,
    covariance: Matrix3<f64>,
    odom_from_base: Option<(Time, Pose2)>,
    last: Option<Estimate>,
}

impl RecordedPose {
    /// Follows these poses, with a standard deviation in meters and one in radians.
    pub fn new(follower: Follower, deviation_m: f64, deviation_rad: f64) -> RecordedPose {
        let deviation = Vector3::new(deviation_m, deviation_m, deviation_rad);
        let covariance = Matrix3::from_diagonal(&deviation.component_mul(&deviation));
        RecordedPose { follower, covariance, odom_from_base: None, last: None }
    }

    /// The odometer's pose at a scan: that of its own stamp where there is one, else the last before it.
    fn odometry_at(&mut self, stamp: Time, seen: Seen<'_>) -> Result<Pose2, LocalizeError> {
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            odometry.check()?;
            if observation.stamp <= stamp || self.odom_from_base.is_none() {
                self.odom_from_base = Some((observation.stamp, odometry.odom_from_base));
            }
        }
        Ok(self.odom_from_base.map_or_else(Pose2::identity, |(_, pose)| pose))
    }

    /// The estimate for scans that the record says nothing of: as it was, so that its stamp is no scan's.
    fn unplaced(&self, now: Time, status: Status) -> Estimate {
        let before = || Estimate::lost(now - Span(1));
        Estimate { status, ..self.last.clone().unwrap_or_else(before) }
    }
}

impl Localizer for RecordedPose {
    fn start(&mut self, prior: &Prior, _map: &Map) -> Result<(), LocalizeError> {
        prior.check()?;
        if let Prior::Saved(_) = prior {
            return Err(LocalizeError::Prior {
                prior: "a saved state",
                needs: "nothing: poses are recorded",
            });
        }
        (self.odom_from_base, self.last) = (None, None);
        Ok(())
    }

    fn update(&mut self, cx: &mut Cx<'_>, seen: Seen<'_>, _map: &Map) -> Result<Estimate, LocalizeError> {
        let mut newest = None;
        for (scan, _) in seen.laser_scans().rev().filter(|(scan, _)| scan.valid) {
            let place = self.follower.place(scan.stamp);
            newest = newest.or(Some(place));
            if let Place::At(map_from_base) = place {
                let odom_from_base = self.odometry_at(scan.stamp, seen)?;
                let estimate = Estimate::planar(scan.stamp, map_from_base, odom_from_base, self.covariance);
                self.last = Some(estimate.clone());
                return Ok(estimate);
            }
        }
        let status = match newest {
            Some(Place::Over) => Status::Lost,
            Some(Place::Unknown) => Status::Converging,
            _ => self.last.as_ref().map_or(Status::Converging, |last| last.status),
        };
        let estimate = self.unplaced(cx.now, status);
        if self.last.is_some() {
            self.last = Some(estimate.clone());
        }
        Ok(estimate)
    }
}

impl Plugin<dyn Localizer> for RecordedPoseParams {
    fn manifest(&self) -> Manifest {
        Manifest { consumes: vec![vec![ObservationKind::LaserScan]], ..Manifest::default() }
    }

    fn build(&self, context: &BuildContext) -> Result<Box<dyn Localizer>, BuildError> {
        if let Some(fault) = self.check().into_iter().next() {
            return Err(fault);
        }
        let recording = context.world_recording.as_deref();
        let own = self.file.as_ref().map(|file| context.resolve(file));
        let Some(path) = own.as_deref().or(recording) else {
            let message = "is missing, and the world plays no recording; expected a file of poses";
            return Err(
                BuildError::at("file", message).help("lines of `t x y theta`, or a log with poses inside")
            );
        };
        let origin = recording.map_or(Ok(Time::ZERO), begins)?;
        let track = self.poses(context, path, origin)?;
        let follower = Follower::new(&track, origin, self.only_exact, Span::from_secs(self.max_gap_s));
        Ok(Box::new(RecordedPose::new(follower, self.deviation_m, self.deviation_deg.to_radians())))
    }
}

/// The stamp at which the time of a run begins that plays this recording.
fn begins(recording: &Path) -> Result<Time, BuildError> {
    if is_folder(recording) {
        let read = read_folder(recording).map_err(|error| BuildError::at("file", error.to_string()))?;
        return Ok(read.origin());
    }
    let timeline = Timeline::open(recording, BeamOverride::default());
    Ok(timeline.map_err(|error| BuildError::at("file", error.to_string()))?.origin())
}

impl RecordedPoseParams {
    fn poses(&self, context: &BuildContext, path: &Path, origin: Time) -> Result<PoseTrack, BuildError> {
        let at_file = |message: String| BuildError::at("file", message);
        if is_folder(path) {
            let (track, _) = read_camera_track(path).map_err(|error| at_file(error.to_string()))?;
            return after(origin, path, self.camera.place().base_track(&track));
        }
        // A long log is not read to its end only to check a pipeline.
        if context.dry_run && Timeline::open(path, BeamOverride::default()).is_ok() {
            return Ok(PoseTrack::default());
        }
        let poses = read_poses(path).map_err(|error| at_file(error.to_string()))?;
        if let (Some(_), Some(damage)) = (&self.file, &poses.tally.damage) {
            return Err(
                BuildError::at("file", format!("{}: {damage}", path.display())).help("copy the file again")
            );
        }
        after(origin, path, poses.track)
    }
}

/// Poses, if one of them is not over before the log begins.
fn after(origin: Time, path: &Path, track: PoseTrack) -> Result<PoseTrack, BuildError> {
    let Some((last, _)) = track.last().filter(|(last, _)| *last < origin) else { return Ok(track) };
    let (last_s, origin_s) = (last.as_secs(), origin.as_secs());
    let message = format!(
        "{}: the last pose is of {last_s:.6} s, but the log begins at {origin_s:.6} s",
        path.display()
    );
    Err(BuildError::at("file", message).help("stamps of poses are absolute, as in the log"))
}
