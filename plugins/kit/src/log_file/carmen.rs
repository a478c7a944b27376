//! Lines of CARMEN logs (`.log`, `.clf`), and of the pose graphs that TORO writes among them.

use rumbo_core::frames::Twist;

use super::beam_rule::BeamRule;
use super::error::{FaultKind, LineFault};
use super::reader::Desk;
use super::record::{LaserSide, PoseEdge, RecordedOdometry, RecordedScan, Told};
use super::words::Words;

const ROBOT: [&str; 3] = ["odom_x", "odom_y", "odom_theta"];
/// Words behind the readings of `FLASER`: two poses, stamp, host, logger's stamp.
const N_AFTER_OLD: usize = 9;
/// Words behind the remissions of `ROBOTLASER1`: two poses, two velocities, four distances, stamp, host, logger's stamp.
const N_AFTER_NEW: usize = 14;

/// Reads a line whose first word is taken; nothing where this is no CARMEN message that we know.
pub(super) fn told(name: &[u8], words: Words<'_>, desk: &mut Desk) -> Option<Result<Told, LineFault>> {
    Some(match name {
        b"FLASER" => old_laser(words.of("FLASER"), LaserSide::Front, desk),
        b"RLASER" => old_laser(words.of("RLASER"), LaserSide::Rear, desk),
        b"ROBOTLASER1" => robot_laser(words.of("ROBOTLASER1"), LaserSide::Front, desk),
        b"ROBOTLASER2" => robot_laser(words.of("ROBOTLASER2"), LaserSide::Rear, desk),
        b"ODOM" => odometry(words.of("ODOM")),
        b"VERTEX2" => vertex(words.of("VERTEX2")),
        b"EDGE2" => edge(words.of("EDGE2")),
        b"PARAM" => parameter(words.of("PARAM")),
        b"SYNC" => Ok(Told::Sync),
        _ => return None,
    })
}

/// `n r1..rn x y theta odom_x odom_y odom_theta ipc_time host logger_time`.
fn old_laser(mut words: Words<'_>, side: LaserSide, desk: &mut Desk) -> Result<Told, LineFault> {
    let n_beams = words.n_beams("num_readings", 1)?;
    fits(words.clone(), "num_readings", n_beams + N_AFTER_OLD, |words| {
        words.beams("ranges", n_beams, 1.0, &mut desk.ranges_m)?;
        let map_from_base = words.pose(["x", "y", "theta"], 1.0)?;
        let odom_from_base = words.pose(ROBOT, 1.0)?;
        let stamp = words.stamp("ipc_time")?;
        words.word("host")?;
        words.word("logger_time")?;
        let rule = BeamRule::of_count(n_beams).with(&desk.known);
        desk.note_guess(&rule, n_beams);
        let scan = desk.scan(side, stamp, &rule, odom_from_base);
        Ok(Told::Scan(RecordedScan { map_from_base, ..scan }))
    })
}

/// `laser_type start_angle field_of_view angular_resolution maximum_range accuracy remission_mode` and then readings,
/// remissions, `laser_pose robot_pose laser_tv laser_rv forward_safety_dist side_safety_dist turn_axis ipc_time host
/// logger_time`.
fn robot_laser(mut words: Words<'_>, side: LaserSide, desk: &mut Desk) -> Result<Told, LineFault> {
    words.number("laser_type")?;
    let first_bearing_rad = angle(&mut words, "start_angle")?;
    angle(&mut words, "field_of_view")?;
    let bearing_step_rad = angle(&mut words, "angular_resolution")?;
    let reach_m = words.number("maximum_range")?;
    words.number("accuracy")?;
    words.number("remission_mode")?;
    let n_beams = words.n_beams("num_readings", 1)?;
    words.beams("readings", n_beams, 1.0, &mut desk.ranges_m)?;
    let n_remissions = words.n_beams("num_remissions", 0)?;
    fits(words.clone(), "num_remissions", n_remissions + N_AFTER_NEW, |words| {
        words.beams("remissions", n_remissions, 1.0, &mut desk.intensities)?;
        words.pose(["laser_pose_x", "laser_pose_y", "laser_pose_theta"], 1.0)?;
        let odom_from_base = words.pose(["robot_pose_x", "robot_pose_y", "robot_pose_theta"], 1.0)?;
        let twist = Twist::new(words.number("laser_tv")?, words.number("laser_rv")?);
        for field in ["forward_safety_dist", "side_safety_dist", "turn_axis"] {
            words.number(field)?;
        }
        let stamp = words.stamp("ipc_time")?;
        words.word("host")?;
        words.word("logger_time")?;
        let max_range_m = if reach_m > 0.0 { reach_m } else { BeamRule::of_count(n_beams).max_range_m };
        let said = BeamRule { first_bearing_rad, bearing_step_rad, max_range_m, is_guess: false };
        let rule = said.with(&desk.known);
        let scan = desk.scan(side, stamp, &rule, odom_from_base);
        let intensities = if n_remissions == n_beams { desk.intensities() } else { scan.intensities.clone() };
        let map_from_base = desk.vertex.take().unwrap_or(odom_from_base);
        Ok(Told::Scan(RecordedScan { twist: Some(twist), intensities, map_from_base, ..scan }))
    })
}

/// An angle within two turns: everything else is damage.
fn angle(words: &mut Words<'_>, field: &str) -> Result<f64, LineFault> {
    let value = words.number(field)?;
    if value.abs() <= 4.0 * std::f64::consts::PI {
        return Ok(value);
    }
    Err(words.fault(FaultKind::OutOfRange, field, value.to_string(), "an angle in radians"))
}

/// Reads the rest of a line that must have `n_words` left. Where it has another number, that is the fault, whichever
/// field happens to stumble over it.
fn fits(
    mut words: Words<'_>,
    count: &str,
    n_words: usize,
    read: impl FnOnce(&mut Words<'_>) -> Result<Told, LineFault>,
) -> Result<Told, LineFault> {
    let start = words.clone();
    let outcome = read(&mut words);
    if outcome.is_ok() && words.next().is_none() {
        return outcome;
    }
    let found = start.n_left();
    if found == n_words {
        return outcome;
    }
    let kind = if found < n_words { FaultKind::TooFewFields } else { FaultKind::CountDiffers };
    let found = format!("followed by {found} words");
    Err(start.fault(kind, count, found, &format!("{n_words} words of readings, poses and stamps")))
}

/// `x y theta tv rv accel ipc_time host logger_time`.
fn odometry(mut words: Words<'_>) -> Result<Told, LineFault> {
    let odom_from_base = words.pose(["x", "y", "theta"], 1.0)?;
    let twist = Twist::new(words.number("tv")?, words.number("rv")?);
    words.number("accel")?;
    let stamp = words.stamp("ipc_time")?;
    words.word("host")?;
    words.word("logger_time")?;
    Ok(Told::Odometry(RecordedOdometry { stamp, odom_from_base, twist: Some(twist) }))
}

/// `id x y theta`.
fn vertex(mut words: Words<'_>) -> Result<Told, LineFault> {
    let id = words.number("id")? as i64;
    Ok(Told::Vertex { id, map_from_base: words.pose(["x", "y", "theta"], 1.0)? })
}

/// `from to x y theta` and six numbers of the information matrix.
fn edge(mut words: Words<'_>) -> Result<Told, LineFault> {
    let (from, to) = (words.number("from")? as i64, words.number("to")? as i64);
    let from_to = words.pose(["x", "y", "theta"], 1.0)?;
    let mut information = [0.0; 6];
    for value in &mut information {
        *value = words.number("information")?;
    }
    Ok(Told::Edge(PoseEdge { from, to, from_to, information }))
}

/// `name value ...`.
fn parameter(mut words: Words<'_>) -> Result<Told, LineFault> {
    let mut text = |field| words.word(field).map(|word| String::from_utf8_lossy(word).into_owned());
    Ok(Told::Parameter { name: text("name")?, value: text("value")? })
}
