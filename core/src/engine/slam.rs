//! What can be had from the plugin in `[slam]` at any time, and so at the end of a run; and how it goes on from that.

use super::build::EngineError;
use super::localization::Finder;
use super::order::State;
use super::step::Engine;
use crate::boundary::Buffer;
use crate::frames::Pose2;
use crate::map::Map;
use crate::messages::{Check as _, Prior, StampedPose};
use crate::pipeline::Pipeline;
use crate::saved_state::SavedState;
use crate::stages::{BuildError, SlamError};
use nalgebra::Matrix3;

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

    /// Nobody will ask for the trajectory of this run, nor save its state: `[slam]` keeps no list of scans for that alone, and
    /// a long run needs no more memory than a short one. To be said before the first step.
    pub fn keep_no_trajectory(&mut self) {
        if let Finder::Slam { slam, .. } = &mut self.localization.finder.stage {
            slam.keep_no_trajectory();
        }
    }
}

impl Engine {
    /// The whole state of `[slam]`, with where the robot is at present.
    ///
    /// # Errors
    /// Without `[slam]`, and where it cannot.
    pub fn save_state(&self) -> Result<SavedState, AskError> {
        let seat = &self.localization.finder;
        let Finder::Slam { slam, plugin: [plugin, version], .. } = &seat.stage else {
            return Err(AskError::NoSlam);
        };
        let bytes = slam.save().map_err(|error| AskError::Slam { section: seat.name.clone(), error })?;
        Ok(SavedState {
            plugin: plugin.clone(),
            version: version.clone(),
            map_from_base: self.map_from_base(),
            covariance: self.localization.estimate.covariance2(),
            is_lost: matches!(self.navigator.state, State::NoMap | State::Lost | State::Localizing),
            bytes,
        })
    }
}

/// Where a resumed SLAM left the robot.
pub(super) enum LeftAt {
    /// Here.
    Pose(Pose2, Matrix3<f64>),
    /// Nobody knew.
    Lost,
}

/// `[slam] resume`: the map begins as it was saved. Clock and odometer of this run are others, so the plugin is told
/// where the robot is, too.
pub(super) fn resume(
    pipeline: &Pipeline,
    finder: &mut Finder,
    map: &mut Map,
) -> Result<Option<LeftAt>, EngineError> {
    let (Some(file), Finder::Slam { slam, has_begun, plugin: [plugin, _] }) = (&pipeline.resume, finder)
    else {
        return Ok(None);
    };
    let section = pipeline.slam.as_ref().map_or_else(String::new, |spec| spec.name.clone());
    let refused =
        |text: String| EngineError { section: section.clone(), error: BuildError::at("resume", text) };
    let path = pipeline.folder.join(file);
    let state = SavedState::read(&path, plugin).map_err(|fault| refused(fault.to_string()))?;
    let unusable = |error: SlamError| {
        let saved_by = format!("saved by version {} of `{plugin}`", state.version);
        refused(format!("cannot go on from {} ({saved_by}): {error}", path.display()))
    };
    slam.start(&Prior::Saved(Buffer::from(state.bytes.clone())), map).map_err(unusable)?;
    let (map_from_base, covariance) = (state.map_from_base, state.covariance);
    let odom_from_base = Pose2::identity();
    let there = Prior::Pose { map_from_base, odom_from_base, covariance };
    slam.relocate(&there, map).map_err(unusable)?;
    *has_begun = true;
    Ok(Some(if state.is_lost { LeftAt::Lost } else { LeftAt::Pose(map_from_base, covariance) }))
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
