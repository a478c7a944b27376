//! What a localizer is told at the start, for those that begin at a pose or anywhere.

use nalgebra::Matrix3;
use rumbo_core::frames::Pose2;
use rumbo_core::messages::{Check, MessageFault, Prior};
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
