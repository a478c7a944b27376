//! Lines of the logs of Wean Hall: `O` and `L`, in centimeters. The laser sits about 25 cm ahead of the robot's center,
//! which is for the mount of the pipeline's sensor to say.

use super::beam_rule::BeamRule;
use super::error::LineFault;
use super::reader::Desk;
use super::record::{LaserSide, RecordedOdometry, Told};
use super::words::Words;

/// Meters in a centimeter.
const CM: f64 = 0.01;
/// Every scan of these logs has so many beams, one degree apart.
const N_BEAMS: usize = 180;

/// Reads a line whose first word is taken; nothing where this is no message of these logs.
pub(super) fn told(name: &[u8], words: Words<'_>, desk: &mut Desk) -> Option<Result<Told, LineFault>> {
    match name {
        b"O" => Some(odometry(words.of("O"))),
        b"L" => Some(laser(words.of("L"), desk)),
        _ => None,
    }
}

/// `x y theta t`.
fn odometry(mut words: Words<'_>) -> Result<Told, LineFault> {
    let odom_from_base = words.pose(["x", "y", "theta"], CM)?;
    let stamp = words.stamp("t")?;
    Ok(Told::Odometry(RecordedOdometry { stamp, odom_from_base, twist: None }))
}

/// `x y theta xl yl thetal r1..r180 t`.
fn laser(mut words: Words<'_>, desk: &mut Desk) -> Result<Told, LineFault> {
    let odom_from_base = words.pose(["x", "y", "theta"], CM)?;
    words.pose(["xl", "yl", "thetal"], CM)?;
    words.beams("r", N_BEAMS, CM, &mut desk.ranges_m)?;
    let stamp = words.stamp("t")?;
    let rule = BeamRule::of_count(N_BEAMS).with(&desk.known);
    Ok(Told::Scan(desk.scan(LaserSide::Front, stamp, &rule, odom_from_base)))
}
