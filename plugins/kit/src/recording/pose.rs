//! Poses to the bit: a rotation is kept as it is, never through an angle.

use super::cdr::{CdrError, CdrReader, CdrWriter};
use nalgebra::{Complex, Quaternion, Translation2, Translation3, UnitComplex, UnitQuaternion};
use rumbo_core::frames::{Pose2, Pose3, Twist};

/// x, y, cosine, sine.
pub fn numbers2(pose: &Pose2) -> [f64; 4] {
    [pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im]
}

/// The pose of [`numbers2`].
pub fn pose2_of([x, y, re, im]: [f64; 4]) -> Pose2 {
    Pose2::from_parts(Translation2::new(x, y), UnitComplex::new_unchecked(Complex::new(re, im)))
}

/// x, y, z, and the quaternion's i, j, k, w.
pub fn numbers3(pose: &Pose3) -> [f64; 7] {
    let (t, q) = (&pose.translation, &pose.rotation);
    [t.x, t.y, t.z, q.i, q.j, q.k, q.w]
}

/// The pose of [`numbers3`].
pub fn pose3_of([x, y, z, i, j, k, w]: [f64; 7]) -> Pose3 {
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
    Pose3::from_parts(Translation3::new(x, y, z), rotation)
}

pub(super) fn put_twist(cdr: &mut CdrWriter, twist: &Twist) {
    cdr.array(&[twist.forward_m_s, twist.left_m_s, twist.turn_rad_s]);
}

pub(super) fn twist(cdr: &mut CdrReader<'_>) -> Result<Twist, CdrError> {
    let [forward_m_s, left_m_s, turn_rad_s] = cdr.array()?;
    Ok(Twist { forward_m_s, left_m_s, turn_rad_s })
}
