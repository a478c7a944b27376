//! What odometer and gyroscope said, as bytes.

use super::saved::{pose, put_count, put_pose, put_some, some};
use super::tracker::Reckoned;
use crate::gyro::Heading;
use rumbo_core::seal::Reader;
use rumbo_core::time::Time;

/// Writes what odometer and gyroscope said.
pub(super) fn put_reckoned(to: &mut Vec<u8>, reckoned: &Reckoned) {
    to.extend(reckoned.stamp.0.to_le_bytes());
    put_some(to, reckoned.odom_from_base.as_ref(), put_pose);
    put_some(to, reckoned.heading.as_ref(), |to, heading| {
        put_count(to, heading.run as usize);
        put_pose(to, &heading.turn);
    });
}

/// What was written.
pub(super) fn reckoned(from: &mut Reader<'_>) -> Option<Reckoned> {
    let stamp = Time(from.i64()?);
    let odom_from_base = some(from, pose)?;
    let heading = some(from, |from| Some(Heading { run: from.u32()?, turn: pose(from)? }))?;
    Some(Reckoned { stamp, odom_from_base, heading })
}
