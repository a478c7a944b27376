//! What can be had from the plugin in `[slam]` at any time, and so at the end of a run.

use super::localization::Finder;
use super::step::Engine;
use crate::messages::{Check as _, StampedPose};
use crate::stages::SlamError;

/// The plugin in `[slam]` does not give what it was asked for.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AskError {
    /// Nobody builds the map and finds the robot at once.
    #[error("the pipeline has no [slam]")]
    NoSlam,
    /// It cannot, or its answer does not hold together.
    #[error("{section}: {error}")]
    Slam {
        /// Name of its section.
        section: String,
        /// What it says.
        error: SlamError,
    },
}

impl Engine {
    /// Where the robot was at all scans, as `[slam]` knows it now; oldest first. Empty where the plugin does not keep it.
    ///
    /// # Errors
    /// Without `[slam]`, and where it cannot, or gives poses that are not finite or not in order.
    pub fn trajectory(&self) -> Result<Vec<StampedPose>, AskError> {
        let seat = &self.localization.finder;
        let Finder::Slam { slam, .. } = &seat.stage else { return Err(AskError::NoSlam) };
        let poses = slam.trajectory().and_then(|poses| in_order(&poses).map(|()| poses));
        poses.map_err(|error| AskError::Slam { section: seat.name.clone(), error })
    }
}

fn in_order(poses: &[StampedPose]) -> Result<(), SlamError> {
    poses.iter().try_for_each(|pose| pose.check())?;
    let back = poses.iter().zip(poses.iter().skip(1)).find(|(before, after)| after.stamp <= before.stamp);
    match back {
        None => Ok(()),
        Some((before, after)) => Err(SlamError::Other(format!(
            "its trajectory has a pose at {} after one at {}, expected stamps that grow",
            after.stamp, before.stamp
        ))),
    }
}
