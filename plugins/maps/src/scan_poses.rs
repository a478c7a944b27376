//! Where the robot was when a scan was taken.

use rumbo_core::frames::{Pose2, flatten};
use rumbo_core::messages::{Estimate, Seen};
use rumbo_core::odometry_track::OdometryTrack;
use rumbo_core::time::Time;

/// Carries estimates to the times of scans by the odometer.
#[derive(Debug)]
pub(crate) struct ScanPoses {
    track: OdometryTrack,
    max_age_s: f64,
}

impl ScanPoses {
    /// The odometer alone carries a pose no farther than this in time.
    pub fn new(max_age_s: f64) -> ScanPoses {
        ScanPoses { track: OdometryTrack::new(), max_age_s }
    }

    /// Follows the odometer.
    pub fn take(&mut self, seen: Seen<'_>) {
        for (observation, odometry) in seen.odometry().filter(|(observation, _)| observation.valid) {
            self.track.push(observation.stamp, odometry);
        }
    }

    /// The robot when the scan was taken: the estimate where it is of that time, else moved there by the odometer.
    pub fn at(&self, stamp: Time, estimate: &Estimate) -> Option<Pose2> {
        if estimate.stamp == stamp {
            return Some(estimate.pose2());
        }
        let is_near = (stamp - estimate.stamp).as_secs().abs() <= self.max_age_s;
        let has_odometry = self.track.stamp().is_some();
        (is_near && has_odometry).then(|| flatten(&estimate.map_from_odom) * self.track.at(stamp))
    }
}
