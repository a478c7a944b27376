//! What a localizer says: where the robot is, how surely, and what would help.

use super::check::{Check, Checker, MessageFault};
use crate::frames::{Pose2, Pose3, Twist, flatten, lift};
use crate::time::Time;
use nalgebra::{Matrix3, Matrix6};
use serde::{Deserialize, Serialize};

/// How sure the localizer is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Status {
    /// No idea where the robot is.
    #[default]
    Lost,
    /// On the way to one answer.
    Converging,
    /// One answer, kept up to date.
    Tracking,
    /// Several places fit; see the candidates.
    Ambiguous,
}

/// A motion that would help the localizer; obeyed only while localizing, at the least speed, through the guard.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Wish {
    /// Stand still.
    HoldStill,
    /// Turn in place by this much, radians.
    TurnBy(f64),
    /// Drive ahead by this much, meters.
    MoveBy(f64),
}

/// A place that fits what was seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Candidate {
    /// The place.
    pub map_from_base: Pose2,
    /// How well it fits; all scores of one estimate sum to 1.
    pub score: f64,
}

/// Where the robot is.
#[doc(alias = "geometry_msgs/PoseWithCovarianceStamped")]
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The time this is true for.
    pub stamp: Time,
    /// The correction of the odometer: constant while the odometer is right.
    pub map_from_odom: Pose3,
    /// The robot.
    pub map_from_base: Pose3,
    /// Covariance of x, y, z, roll, pitch, yaw in the map's axes, m² and rad².
    pub covariance: Matrix6<f64>,
    /// How sure.
    pub status: Status,
    /// Places that fit, best first; empty unless ambiguous.
    pub candidates: Vec<Candidate>,
    /// A motion that would help.
    pub wish: Option<Wish>,
}

impl Estimate {
    /// An estimate in the plane: `covariance` is of x, y, yaw.
    pub fn planar(
        stamp: Time,
        map_from_base: Pose2,
        odom_from_base: Pose2,
        covariance: Matrix3<f64>,
    ) -> Estimate {
        let mut full = Matrix6::zeros();
        for (row, to_row) in [0, 1, 5].into_iter().enumerate() {
            for (col, to_col) in [0, 1, 5].into_iter().enumerate() {
                full[(to_row, to_col)] = covariance[(row, col)];
            }
        }
        Estimate {
            stamp,
            map_from_odom: lift(&(map_from_base * odom_from_base.inverse())),
            map_from_base: lift(&map_from_base),
            covariance: full,
            status: Status::Tracking,
            candidates: Vec::new(),
            wish: None,
        }
    }

    /// No idea.
    pub fn lost(stamp: Time) -> Estimate {
        let unsure = Matrix3::from_diagonal(&nalgebra::Vector3::new(1e6, 1e6, 10.0));
        let mut estimate = Estimate::planar(stamp, Pose2::identity(), Pose2::identity(), unsure);
        estimate.status = Status::Lost;
        estimate
    }

    /// The robot in the plane.
    pub fn pose2(&self) -> Pose2 {
        flatten(&self.map_from_base)
    }

    /// Covariance of x, y, yaw.
    pub fn covariance2(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|row, col| self.covariance[([0, 1, 5][row], [0, 1, 5][col])])
    }
}

impl Check for Estimate {
    fn check(&self) -> Result<(), MessageFault> {
        let c = Checker("estimate");
        c.pose3("map_from_odom", &self.map_from_odom)?;
        c.pose3("map_from_base", &self.map_from_base)?;
        c.finite("covariance", self.covariance.as_slice())?;
        self.covariance.diagonal().iter().try_for_each(|v| c.not_negative("covariance diagonal", *v))?;
        self.candidates.iter().try_for_each(|candidate| {
            c.pose2("candidates.map_from_base", &candidate.map_from_base)?;
            c.not_negative("candidates.score", candidate.score)
        })?;
        match self.wish {
            Some(Wish::TurnBy(v) | Wish::MoveBy(v)) => c.finite("wish", &[v]),
            _ => Ok(()),
        }
    }
}

impl Check for Twist {
    fn check(&self) -> Result<(), MessageFault> {
        Checker("twist").finite("parts", &[self.forward_m_s, self.left_m_s, self.turn_rad_s])
    }
}
