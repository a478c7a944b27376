//! What a localizer is told at the start, for those that begin at a pose or anywhere.

use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Check, Data, MessageFault, Observation, Prior, Seen};
use rumbo_core::stages::LocalizeError;

/// The pose in the map with its covariance, none where the robot may be anywhere; and the odometer's pose.
pub type Beginning = (Option<(Pose2, Matrix3<f64>)>, Pose2);

/// A prior's beginning.
///
/// # Errors
/// Numbers that cannot be, and a saved state: `needs` says what is needed instead.
pub fn beginning(prior: &Prior, needs: &'static str) -> Result<Beginning, LocalizeError> {
    prior.check()?;
    match prior {
        Prior::Saved(_) => Err(LocalizeError::Prior { prior: "a saved state", needs }),
        Prior::Unknown => Ok((None, Pose2::identity())),
        Prior::Pose { map_from_base, odom_from_base, covariance } => {
            if let Some(negative) = covariance.diagonal().iter().find(|v| **v < 0.0) {
                let (message, field) = ("prior", "covariance diagonal");
                let (found, expected) = (negative.to_string(), "numbers of at least zero");
                return Err(MessageFault { message, field, found, expected }.into());
            }
            Ok((Some((*map_from_base, *covariance)), *odom_from_base))
        }
    }
}

/// The beginning of those that need to know where: the pose in the map with its covariance, and the odometer's pose.
///
/// # Errors
/// As [`beginning`], and a prior that knows no pose.
pub fn known_beginning(prior: &Prior) -> Result<((Pose2, Matrix3<f64>), Pose2), LocalizeError> {
    const NEEDS: &str = "a pose";
    let (at, odom_from_base) = beginning(prior, NEEDS)?;
    let at = at.ok_or(LocalizeError::Prior { prior: "an unknown pose", needs: NEEDS })?;
    Ok((at, odom_from_base))
}

/// Everything valid that was seen, scans last: what says how the robot moved comes before the scans, which begin from it.
pub fn scans_last<'a>(seen: Seen<'a>, take: impl FnMut(&'a Observation)) {
    let is_scan = |observation: &Observation| matches!(observation.data, Data::LaserScan(_));
    let valid = seen.iter().filter(|observation| observation.valid);
    let others = valid.clone().filter(|one| !is_scan(one));
    others.chain(valid.filter(|one| is_scan(one))).for_each(take);
}
