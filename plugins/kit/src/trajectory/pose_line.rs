//! One line of a file of poses.

use nalgebra::{Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion};
use rumbo_core::frames::{Pose3, lift};
use rumbo_core::time::Time;

use super::{StampedPose, TrajectoryFormat};
use crate::log_file::words::Words;
use crate::log_file::{FaultKind, LineFault};

/// A rotation matrix whose rows differ from a rotation by more than this is none.
const MOST_SKEW: f64 = 1e-2;

/// Reads a line; `index` is the stamp of a pose that has none.
pub(super) fn pose_line(
    line: u64,
    bytes: &[u8],
    format: TrajectoryFormat,
    index: Time,
) -> Result<StampedPose, LineFault> {
    let mut words = Words::new(line, bytes).of("pose");
    let pose = match format {
        TrajectoryFormat::Kitti => {
            let world_from_body = matrix(&mut words)?;
            StampedPose { stamp: index, world_from_body }
        }
        TrajectoryFormat::Tum => {
            let stamp = words.stamp("t")?;
            StampedPose { stamp, world_from_body: quaternion(&mut words)? }
        }
        TrajectoryFormat::Planar | TrajectoryFormat::Log | TrajectoryFormat::Odometry => {
            let stamp = words.stamp("t")?;
            return Ok(StampedPose { stamp, world_from_body: lift(&words.pose(["x", "y", "theta"], 1.0)?) });
        }
    };
    over(&mut words, format.pattern())?;
    Ok(pose)
}

/// Reads a line with nothing but a stamp.
pub(super) fn stamp_line(line: u64, bytes: &[u8]) -> Result<Time, LineFault> {
    let mut words = Words::new(line, bytes).of("times");
    let stamp = words.stamp("t")?;
    over(&mut words, "one stamp a line")?;
    Ok(stamp)
}

/// Nothing may follow.
fn over(words: &mut Words<'_>, expected: &str) -> Result<(), LineFault> {
    match words.n_left() {
        0 => Ok(()),
        n => {
            Err(words.fault(FaultKind::CountDiffers, "end", format!("followed by {n} more words"), expected))
        }
    }
}

/// `tx ty tz qx qy qz qw`; the quaternion may have any length but zero.
fn quaternion(words: &mut Words<'_>) -> Result<Pose3, LineFault> {
    let translation = Translation3::new(words.number("tx")?, words.number("ty")?, words.number("tz")?);
    let mut part = |field| words.number(field);
    let (x, y, z, w) = (part("qx")?, part("qy")?, part("qz")?, part("qw")?);
    let rotation = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 1e-6);
    let rotation = rotation.ok_or_else(|| {
        let found = format!("{x} {y} {z} {w}");
        words.fault(FaultKind::OutOfRange, "quaternion", found, "four numbers that are not all zero")
    })?;
    Ok(Pose3::from_parts(translation, rotation))
}

/// The upper three rows of a pose matrix; its rotation is replaced by the nearest one.
fn matrix(words: &mut Words<'_>) -> Result<Pose3, LineFault> {
    const NAMES: [[&str; 4]; 3] =
        [["r11", "r12", "r13", "tx"], ["r21", "r22", "r23", "ty"], ["r31", "r32", "r33", "tz"]];
    let mut rows = [[0.0; 4]; 3];
    for (row, names) in rows.iter_mut().zip(NAMES) {
        for (value, name) in row.iter_mut().zip(names) {
            *value = words.number(name)?;
        }
    }
    let [[a, b, c, tx], [d, e, f, ty], [g, h, i, tz]] = rows;
    let read = Matrix3::new(a, b, c, d, e, f, g, h, i);
    let no_rotation = |words: &Words<'_>| {
        let found = format!("[{a} {b} {c}; {d} {e} {f}; {g} {h} {i}]");
        words.fault(FaultKind::OutOfRange, "rotation", found, "a rotation matrix")
    };
    let svd = read.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Err(no_rotation(words)) };
    let nearest = u * v_t;
    if (nearest - read).abs().max() > MOST_SKEW || nearest.determinant() < 0.0 {
        return Err(no_rotation(words));
    }
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(nearest));
    Ok(Pose3::from_parts(Translation3::new(tx, ty, tz), rotation))
}
