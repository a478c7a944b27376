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

/// A pose in space on the floor, as [`lift`](rumbo_core::frames::lift) of [`flatten`](rumbo_core::frames::flatten), by the
/// formulas of the half angle: no angle in between, and none of the four functions that it takes. For eyes, not to the bit.
pub fn upright(pose: &Pose3) -> Pose3 {
    let forward = pose.rotation * nalgebra::Vector3::x();
    let length = forward.x.hypot(forward.y);
    upright_of(pose.translation.x, pose.translation.y, forward.x / length, forward.y / length)
}

/// As [`upright`].
pub fn upright2(pose: &Pose2) -> Pose3 {
    upright_of(pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im)
}

fn upright_of(x: f64, y: f64, cosine: f64, sine: f64) -> Pose3 {
    let larger = ((1.0 + cosine.abs()) * 0.5).sqrt();
    let smaller = sine / (2.0 * larger);
    let (k, w) = if cosine >= 0.0 { (smaller, larger) } else { (larger.copysign(sine), smaller.abs()) };
    pose3_of([x, y, 0.0, 0.0, 0.0, k, w])
}

pub(super) fn put_twist(cdr: &mut CdrWriter, twist: &Twist) {
    cdr.array(&[twist.forward_m_s, twist.left_m_s, twist.turn_rad_s]);
}

pub(super) fn twist(cdr: &mut CdrReader<'_>) -> Result<Twist, CdrError> {
    let [forward_m_s, left_m_s, turn_rad_s] = cdr.array()?;
    Ok(Twist { forward_m_s, left_m_s, turn_rad_s })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::frames::{flatten, lift, pose2};

    #[test]
    fn a_pose_is_set_upright_without_an_angle_as_with_one() {
        for step in -36..=36 {
            let pose = pose2(1.0, -2.0, f64::from(step) * 0.087);
            let tilt = UnitQuaternion::from_euler_angles(0.1, -0.2, 0.0);
            let tilted = Pose3::from_parts(lift(&pose).translation, lift(&pose).rotation * tilt);
            for (found, expected) in [
                (upright2(&pose), lift(&pose)),
                (upright(&lift(&pose)), lift(&pose)),
                (upright(&tilted), lift(&flatten(&tilted))),
            ] {
                let off = found.rotation.angle_to(&expected.rotation);
                assert!(
                    off < 1e-7 && found.translation == expected.translation,
                    "{step}: {found} {expected}"
                );
                assert!((found.rotation.norm() - 1.0).abs() < 1e-12);
            }
        }
    }
}
