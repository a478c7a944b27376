//! Inertial navigation in space: attitude, position and velocity from turning rates and specific forces, held by what else
//! is known of the robot (Kohlbrecher et al., *A Flexible and Scalable SLAM System with Full 3D Motion Estimation*, 2011;
//! Arroyo Sánchez, 2013, section 3.2, equations 1 to 3).
//!
//! The attitude is a unit quaternion with an error of three angles in the body's frame, so no attitude is singular. Biases
//! of both devices are states. What differs from the source:
//!
//! - Gravity is not left out: the accelerometer reads +9.80665 m/s² upward at rest.
//! - Leveling compares directions of gravity instead of Euler angles, and each aid is used at most once in
//!   [`NavSettings::aid_period`]: what the accelerometer errs by on a moving robot does not change from sample to sample, and
//!   200 samples of it a second would count as 200 independent ones.
//! - What holds a body on its curve is taken off before it is leveled, as far as its velocity is known, and leveling counts less
//!   beyond the gate of the rates instead of not at all: a body that sways is hardly ever below it.
//! - Where gravity says for long that the attitude is wrong, the attitude is what gravity says ([`NavSettings::level_anew_after`]).
//! - Not sliding says nothing about the attitude, and less about the vertical velocity of a body that sways on its wheels.
//! - Steps over the floor that scans alone know are measurements of their own ([`Fusion::Alone`]): they owe the state nothing,
//!   and covariance intersection would never learn a bias from them that is smaller than the noise of one.
//! - The way since the last step has a frame of its own, the anchor; what the state has in common with the anchor is carried
//!   along, so that the output says how sure it is although a bias turns all steps alike.
//! - Covariance intersection of a planar pose changes the covariance of that pose, and of all else only by what it has in
//!   common with it ([`Intersected::Pose`]). The published form ([`Intersected::Everything`]) divides the covariance of all
//!   states by `1 - omega`, roll, pitch and biases among them, at each scan.

mod aiding;
mod aids;
mod chain;
mod euler;
mod filter;
mod fusion;
mod history;
mod intersection;
mod leveling;
mod model;
mod moment;
mod output;
mod settings;
mod update;

pub use aids::{Aid, leveled_angles};
pub use chain::{FrameChain, map_from_odom};
pub use euler::{Degenerate, EulerState};
pub use filter::{NavCounts, NavFilter};
pub use fusion::Fusion;
pub use intersection::{PlanarPose, best_omega, intersect, intersect_pose};
pub use leveling::Leveler;
pub use model::{Covariance, GRAVITY_M_S2, ImuSample, NavState, jacobian, noise, propagate};
pub use output::{NavOutput, NavStatus};
pub use settings::{Intersected, NavFault, NavSettings, Omega};
pub use update::{CHI2_95, Updated, joseph};

#[cfg(test)]
mod tests;
