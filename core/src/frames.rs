//! Frames and the poses between them, as REP-105 names them and REP-103 orients them: x forward, y left, z up, angles
//! counter-clockwise, radians.
//!
//! A variable is `target_from_source`: it maps coordinates in `source` to coordinates in `target`, so that inner names
//! cancel: `map_from_base = map_from_odom * odom_from_base`.

use nalgebra::{Isometry2, Isometry3, Translation2, Translation3, UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// A planar pose or transform.
#[doc(alias = "geometry_msgs/Pose2D")]
pub type Pose2 = Isometry2<f64>;
/// A pose or transform in space.
#[doc(alias = "geometry_msgs/Transform")]
pub type Pose3 = Isometry3<f64>;
/// A point of the plane.
pub type Point2 = nalgebra::Point2<f64>;
/// A point in space.
pub type Point3 = nalgebra::Point3<f64>;

/// The frames of the framework.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Frame {
    /// Fixed to the building; the estimate may jump in it.
    Map,
    /// Fixed to where the odometer started; smooth, drifts.
    Odom,
    /// The robot, projected to the floor.
    BaseFootprint,
    /// The robot, leveled by its attitude.
    BaseStabilized,
    /// The robot's body.
    BaseLink,
}

/// A planar pose from its three numbers, meters and radians.
pub fn pose2(x_m: f64, y_m: f64, yaw_rad: f64) -> Pose2 {
    Pose2::new(nalgebra::Vector2::new(x_m, y_m), yaw_rad)
}

/// A planar pose lifted to the floor of space.
pub fn lift(pose: &Pose2) -> Pose3 {
    Pose3::from_parts(
        Translation3::new(pose.translation.x, pose.translation.y, 0.0),
        UnitQuaternion::from_axis_angle(&Vector3::z_axis(), pose.rotation.angle()),
    )
}

/// A pose in space projected to the floor: its yaw is where its x axis points.
pub fn flatten(pose: &Pose3) -> Pose2 {
    let forward = pose.rotation * Vector3::x();
    Pose2::from_parts(
        Translation2::new(pose.translation.x, pose.translation.y),
        nalgebra::UnitComplex::new(forward.y.atan2(forward.x)),
    )
}

/// The same angle in [-pi, pi).
#[doc(alias = "normalize_angle")]
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let wrapped = (angle_rad + PI).rem_euclid(TAU) - PI;
    // The remainder of a tiny negative number rounds up to the full turn.
    if wrapped >= PI { -PI } else { wrapped }
}

/// A pose between two others: on the straight line, turning the short way round; `share` is 0 at the first.
pub fn interpolate2(from: &Pose2, to: &Pose2, share: f64) -> Pose2 {
    let turn_rad = wrap_angle(to.rotation.angle() - from.rotation.angle()) * share;
    let place = from.translation.vector.lerp(&to.translation.vector, share);
    Pose2::new(place, from.rotation.angle() + turn_rad)
}

/// Every number of the pose is finite.
pub fn is_finite2(pose: &Pose2) -> bool {
    pose.translation.vector.iter().chain([&pose.rotation.re, &pose.rotation.im]).all(|v| v.is_finite())
}

/// Every number of the pose is finite.
pub fn is_finite3(pose: &Pose3) -> bool {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).all(|v| v.is_finite())
}

/// Velocity of the base in its own frame.
#[doc(alias = "geometry_msgs/Twist")]
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Twist {
    /// Forward, m/s.
    pub forward_m_s: f64,
    /// To the left, m/s; zero unless the drive is omnidirectional.
    pub left_m_s: f64,
    /// Counter-clockwise, rad/s.
    pub turn_rad_s: f64,
}

impl Twist {
    /// Standing still.
    pub const ZERO: Twist = Twist { forward_m_s: 0.0, left_m_s: 0.0, turn_rad_s: 0.0 };

    /// Forward and turning.
    pub fn new(forward_m_s: f64, turn_rad_s: f64) -> Twist {
        Twist { forward_m_s, left_m_s: 0.0, turn_rad_s }
    }

    /// All three parts times one factor: the path's curvature is kept.
    pub fn scaled(self, factor: f64) -> Twist {
        Twist {
            forward_m_s: self.forward_m_s * factor,
            left_m_s: self.left_m_s * factor,
            turn_rad_s: self.turn_rad_s * factor,
        }
    }

    /// Speed over the floor, m/s.
    pub fn speed_m_s(self) -> f64 {
        self.forward_m_s.hypot(self.left_m_s)
    }

    /// Every number is finite.
    pub fn is_finite(self) -> bool {
        self.forward_m_s.is_finite() && self.left_m_s.is_finite() && self.turn_rad_s.is_finite()
    }

    /// Where a base ends, seen from where it started, after this twist for `seconds` (exact arc).
    pub fn integrate(self, seconds: f64) -> Pose2 {
        let turn = self.turn_rad_s * seconds;
        // sin(x)/x and (1-cos(x))/x by their series where the quotient loses digits.
        let (sinc, cosc) = if turn.abs() < 1e-6 {
            (1.0 - turn * turn / 6.0, turn / 2.0)
        } else {
            (turn.sin() / turn, (1.0 - turn.cos()) / turn)
        };
        let (ahead, left) = (self.forward_m_s * seconds, self.left_m_s * seconds);
        pose2(ahead * sinc - left * cosc, ahead * cosc + left * sinc, turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_wrap_to_the_half_open_turn_on_both_sides() {
        for (angle, expected) in
            [(PI, -PI), (-PI, -PI), (3.0 * PI, -PI), (0.5, 0.5), (-0.5, -0.5), (TAU + 0.25, 0.25)]
        {
            assert!((wrap_angle(angle) - expected).abs() < 1e-12, "{angle}");
        }
        assert!(wrap_angle(-1e-17) < PI);
    }

    #[test]
    fn a_quarter_arc_ends_beside_and_ahead_by_the_radius() {
        for side in [1.0, -1.0] {
            let end = Twist::new(1.0, side * 0.5).integrate(PI);
            assert!((end.translation.x - 2.0).abs() < 1e-12);
            assert!((end.translation.y - side * 2.0).abs() < 1e-12);
            assert!((end.rotation.angle() - side * PI / 2.0).abs() < 1e-12);
        }
    }

    #[test]
    fn the_exact_arc_agrees_with_many_small_steps() {
        let twist = Twist { forward_m_s: 0.7, left_m_s: -0.3, turn_rad_s: 1.1 };
        let mut small = Pose2::identity();
        for _ in 0..200_000 {
            small *= pose2(0.7e-5, -0.3e-5, 1.1e-5);
        }
        let exact = twist.integrate(2.0);
        assert!((small.translation.vector - exact.translation.vector).norm() < 1e-4);
        assert!(small.rotation.angle_to(&exact.rotation).abs() < 1e-9);
    }

    #[test]
    fn flattening_undoes_lifting_for_both_turns() {
        for yaw in [-3.1, -1.0, 0.0, 2.0, 3.1] {
            let pose = pose2(1.0, -2.0, yaw);
            assert!((flatten(&lift(&pose)).to_homogeneous() - pose.to_homogeneous()).norm() < 1e-12);
        }
    }
}
