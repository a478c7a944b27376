//! The whole state as bytes, to go on from later.

use super::atlas::{Atlas, KeyFrame};
use super::saved_look::{look, put_look};
use super::saved_reckoned::{put_reckoned, reckoned};
use super::surface::Surface;
use super::tracker::{Before, Fit, Track, Tracker, TrackerSettings};
use crate::gyro::Gyro;
use nalgebra::{Matrix3, Quaternion, Translation3, UnitQuaternion};
use rumbo_core::frames::{Pose2, Pose3, is_finite2, is_finite3, pose2};
use rumbo_core::messages::{Check, LaserScan};
use rumbo_core::seal::{Broken, Reader, Seal};
use rumbo_core::time::Time;
use rumbo_kit::pose_graph::{Constraint, RobustKernel};

const SEAL: Seal = Seal { magic: *b"RUMBOGRF", version: 6 };

/// Everything that the next scan depends on.
pub(super) fn write(tracker: &Tracker) -> Vec<u8> {
    let mut bytes = SEAL.begin(1 << 20);
    let to = &mut bytes;
    put_count(to, tracker.atlas.frames.len());
    for (idx, frame) in tracker.atlas.frames.iter().enumerate() {
        put_pose(to, &tracker.atlas.pose(idx));
        put_frame(to, frame);
    }
    put_count(to, tracker.atlas.graph.constraints().len());
    for link in tracker.atlas.graph.constraints() {
        put_constraint(to, link);
    }
    let tried: Vec<(usize, usize)> = tracker.atlas.tried().collect();
    put_count(to, tried.len());
    tried.iter().flat_map(|(a, b)| [*a, *b]).for_each(|node| put_count(to, node));
    put_count(to, tracker.tracks.len());
    for track in &tracker.tracks {
        to.extend(track.stamp.0.to_le_bytes());
        put_count(to, track.frame);
        put_pose(to, &track.frame_from_base);
    }
    put_robot(to, tracker);
    Seal::close(bytes)
}

fn put_robot(to: &mut Vec<u8>, tracker: &Tracker) {
    put_count(to, tracker.front.frame);
    put_count(to, tracker.front.frames().len());
    tracker.front.frames().iter().for_each(|frame| put_count(to, *frame));
    put_pose(to, &tracker.frame_from_base);
    put_pose(to, &tracker.first_pose);
    put_numbers(to, tracker.covariance.iter());
    put_some(to, tracker.frame_reckoned.as_ref(), put_reckoned);
    put_some(to, tracker.before.as_ref(), |to, before| {
        put_reckoned(to, &before.reckoned);
        put_pose(to, &before.motion);
        to.extend(before.seconds.to_le_bytes());
    });
    put_some(to, tracker.odometry.newest().as_ref(), |to, (stamp, pose)| {
        to.extend(stamp.0.to_le_bytes());
        put_pose(to, pose);
    });
    let (run, newest) = tracker.gyro.newest();
    put_count(to, run as usize);
    put_some(to, newest.as_ref(), |to, (stamp, turn)| {
        to.extend(stamp.0.to_le_bytes());
        put_pose(to, turn);
    });
    put_count(to, usize::from(tracker.is_adrift));
    put_some(to, tracker.unsure_since.as_ref(), |to, since| put_count(to, *since));
    put_count(to, usize::from(tracker.is_doubtful));
    put_some(to, tracker.saw_at.as_ref(), |to, stamp| to.extend(stamp.0.to_le_bytes()));
    put_count(to, tracker.fit as usize);
    put_count(to, tracker.n_missed as usize);
    put_count(to, tracker.since_optimized);
    put_count(to, tracker.n_strained);
    put_count(to, tracker.n_loops);
    tracker.catch_up.iter().for_each(|frame| put_count(to, *frame));
    put_some(to, tracker.look.as_ref(), put_look);
}

/// The state that was saved.
///
/// # Errors
/// What is wrong with the bytes.
pub(super) fn read(bytes: &[u8], settings: TrackerSettings) -> Result<Tracker, String> {
    let mut from = SEAL.open(bytes).map_err(|broken| match broken {
        Broken::Foreign => "these bytes are no saved state of graph_slam".to_owned(),
        Broken::Version(found) => format!("the saved state has version {found}, expected {}", SEAL.version),
        Broken::Damaged => "the saved state is damaged".to_owned(),
    })?;
    let damaged = || "the saved state does not hold together".to_owned();
    let mut tracker = Tracker::new(settings, Pose2::identity());
    tracker.atlas = atlas(&mut from, settings).ok_or_else(damaged)?;
    tracker.tracks = tracks(&mut from, tracker.atlas.frames.len()).ok_or_else(damaged)?;
    robot(&mut from, &mut tracker).filter(|()| from.is_empty()).ok_or_else(damaged)?;
    Ok(tracker)
}

fn atlas(from: &mut Reader<'_>, settings: TrackerSettings) -> Option<Atlas> {
    let mut atlas = Atlas::new(settings.tie);
    for _ in 0..count(from)? {
        let pose = pose(from)?;
        let mut frame = frame(from)?;
        frame.surface = Surface::of(&frame.scan, &frame.base_from_sensor, &settings.limits);
        atlas.add(frame, &pose, None)?;
    }
    for _ in 0..count(from)? {
        atlas.put_back(constraint(from)?)?;
    }
    for _ in 0..count(from)? {
        let pair = (count(from)?, count(from)?);
        atlas.mark_tried(pair);
    }
    Some(atlas)
}

fn tracks(from: &mut Reader<'_>, n_frames: usize) -> Option<Vec<Track>> {
    let mut tracks = Vec::new();
    for _ in 0..count(from)? {
        let track = Track { stamp: Time(from.i64()?), frame: count(from)?, frame_from_base: pose(from)? };
        if track.frame >= n_frames {
            return None;
        }
        tracks.push(track);
    }
    Some(tracks)
}

fn robot(from: &mut Reader<'_>, tracker: &mut Tracker) -> Option<()> {
    let frame = count(from)?;
    let n_frames = count(from)?;
    let frames = (0..n_frames).map(|_| count(from)).collect::<Option<Vec<usize>>>()?;
    let n_known = tracker.atlas.frames.len();
    if frames.iter().any(|frame| *frame >= n_known) || (n_known > 0 && frame >= n_known) {
        return None;
    }
    tracker.front.look_from(&tracker.atlas, frame, &frames);
    tracker.frame_from_base = pose(from)?;
    tracker.first_pose = pose(from)?;
    let numbers = numbers::<9>(from)?;
    tracker.covariance = Matrix3::from_column_slice(&numbers);
    tracker.frame_reckoned = some(from, reckoned)?;
    tracker.before = some(from, |from| {
        Some(Before { reckoned: reckoned(from)?, motion: pose(from)?, seconds: from.f64()? })
    })?;
    if let Some((stamp, odom)) = some(from, |from| Some((Time(from.i64()?), pose(from)?)))? {
        tracker.odometry.push(stamp, odom);
    }
    let run = from.u32()?;
    let newest = some(from, |from| Some((Time(from.i64()?), pose(from)?)))?;
    tracker.gyro = Gyro::go_on(run, newest);
    tracker.is_adrift = count(from)? != 0;
    tracker.unsure_since = some(from, count)?;
    tracker.is_doubtful = count(from)? != 0;
    tracker.saw_at = some(from, |from| Some(Time(from.i64()?)))?;
    tracker.fit = match count(from)? {
        0 => Fit::Placed,
        1 => Fit::Guessed,
        2 => Fit::Lost,
        _ => return None,
    };
    tracker.n_missed = count(from)? as u32;
    tracker.since_optimized = count(from)?;
    tracker.n_strained = count(from)?;
    tracker.n_loops = count(from)?;
    tracker.catch_up = [count(from)?, count(from)?];
    tracker.look = some(from, |from| look(from, &tracker.atlas))?;
    (tracker.catch_up[1] <= n_known).then_some(())
}

pub(super) fn put_count(to: &mut Vec<u8>, count: usize) {
    to.extend((count as u32).to_le_bytes());
}

fn put_numbers<'a>(to: &mut Vec<u8>, numbers: impl Iterator<Item = &'a f64>) {
    numbers.for_each(|v| to.extend(v.to_le_bytes()));
}

pub(super) fn put_pose(to: &mut Vec<u8>, pose: &Pose2) {
    // The parts of the rotation as they are: an angle would lose its last bits.
    put_numbers(to, [pose.translation.x, pose.translation.y, pose.rotation.re, pose.rotation.im].iter());
}

pub(super) fn put_some<T>(to: &mut Vec<u8>, value: Option<&T>, put: impl Fn(&mut Vec<u8>, &T)) {
    put_count(to, usize::from(value.is_some()));
    if let Some(value) = value {
        put(to, value);
    }
}

fn put_frame(to: &mut Vec<u8>, frame: &KeyFrame) {
    let scan = &frame.scan;
    put_numbers(to, [scan.first_bearing_rad, scan.bearing_step_rad, scan.sweep_s].iter());
    put_numbers(to, [f64::from(scan.min_range_m), f64::from(scan.max_range_m)].iter());
    put_count(to, scan.ranges_m.len());
    scan.ranges_m.iter().for_each(|range| to.extend(range.to_le_bytes()));
    put_numbers(to, frame.base_from_sensor.translation.vector.iter());
    put_numbers(to, frame.base_from_sensor.rotation.coords.iter());
    put_count(to, usize::from(frame.is_guessed));
}

fn put_constraint(to: &mut Vec<u8>, link: &Constraint) {
    put_some(to, link.from.as_ref(), |to, from| put_count(to, *from));
    put_count(to, link.to);
    put_pose(to, &link.from_to);
    put_numbers(to, link.information.iter());
    let (kind, c) = match link.kernel {
        RobustKernel::Quadratic => (0, 1.0),
        RobustKernel::Huber { c } => (1, c),
        RobustKernel::Cauchy { c } => (2, c),
        RobustKernel::GemanMcClure { c } => (3, c),
    };
    put_count(to, kind);
    to.extend(f64::to_le_bytes(c));
}

pub(super) fn count(from: &mut Reader<'_>) -> Option<usize> {
    from.u32().map(|count| count as usize)
}

fn numbers<const N: usize>(from: &mut Reader<'_>) -> Option<[f64; N]> {
    let mut numbers = [0.0; N];
    for number in &mut numbers {
        *number = from.f64()?;
    }
    Some(numbers)
}

pub(super) fn pose(from: &mut Reader<'_>) -> Option<Pose2> {
    let [x, y, re, im] = numbers(from)?;
    let mut pose = pose2(x, y, 0.0);
    pose.rotation = nalgebra::UnitComplex::new_unchecked(nalgebra::Complex::new(re, im));
    (is_finite2(&pose) && (re.hypot(im) - 1.0).abs() < 1e-6).then_some(pose)
}

pub(super) fn some<'b, T>(
    from: &mut Reader<'b>,
    get: impl Fn(&mut Reader<'b>) -> Option<T>,
) -> Option<Option<T>> {
    if count(from)? == 0 { Some(None) } else { get(from).map(Some) }
}

fn frame(from: &mut Reader<'_>) -> Option<KeyFrame> {
    let [first_bearing_rad, bearing_step_rad, sweep_s, min_range_m, max_range_m] = numbers(from)?;
    let n_ranges = count(from)?;
    let ranges_m: Vec<f32> = from.u32s(n_ranges)?.into_iter().map(f32::from_bits).collect();
    let scan = LaserScan {
        first_bearing_rad,
        bearing_step_rad,
        sweep_s,
        min_range_m: min_range_m as f32,
        max_range_m: max_range_m as f32,
        ranges_m: ranges_m.into(),
        ..LaserScan::default()
    };
    let [x, y, z, i, j, k, w] = numbers(from)?;
    let rotation = UnitQuaternion::new_unchecked(Quaternion::new(w, i, j, k));
    let base_from_sensor = Pose3::from_parts(Translation3::new(x, y, z), rotation);
    let is_turn = (rotation.coords.norm() - 1.0).abs() < 1e-6;
    let is_guessed = count(from)? != 0;
    let fits = scan.check().is_ok() && is_finite3(&base_from_sensor) && is_turn;
    fits.then(|| KeyFrame { scan, base_from_sensor, surface: Surface::default(), is_guessed })
}

fn constraint(from: &mut Reader<'_>) -> Option<Constraint> {
    let origin = some(from, count)?;
    let to = count(from)?;
    let from_to = pose(from)?;
    let information = Matrix3::from_column_slice(&numbers::<9>(from)?);
    let (kind, c) = (count(from)?, from.f64()?);
    let kernel = match kind {
        0 => RobustKernel::Quadratic,
        1 => RobustKernel::Huber { c },
        2 => RobustKernel::Cauchy { c },
        3 => RobustKernel::GemanMcClure { c },
        _ => return None,
    };
    Some(Constraint { from: origin, to, from_to, information, kernel })
}
