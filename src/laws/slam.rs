//! Laws of SLAM plugins beside those of all that find the robot: what they know of their way, and what they are told on it.

use super::drive::{Drive, Frame};
use super::estimates::apart;
use super::estimators::{Tracker, prior_of};
use super::law::{Law, Trouble, Verdict, expect};
use super::subject::Subject;
use super::turn::Turn;
use rumbo_core::frames::pose2;
use rumbo_core::map::Map;
use rumbo_core::messages::{Check as _, Data};
use rumbo_core::time::Time;

pub const TRAJECTORY: Law = Law::new(
    "its trajectory is finite, in order, and of moments at which it was given something",
    trajectory,
);
pub const RELOCATES: Law = Law::new(
    "told where the robot is, it keeps its map and goes on from there with another clock and odometer",
    relocates,
)
.within("0.30 m and 10 degrees");

fn trajectory(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let mut tracker = Tracker::new(subject, &drive)?;
    tracker.follow_all(&drive)?;
    let none = || Trouble::not_applicable("it keeps no trajectory");
    let poses = tracker.trajectory().ok_or_else(none)?;
    let poses = poses.map_err(|error| Trouble::broken(format!("none: {error}"), "a trajectory"))?;
    if poses.is_empty() {
        return Err(none());
    }
    let mut before: Option<Time> = None;
    for pose in &poses {
        let at_s = pose.stamp.as_secs();
        pose.check()
            .map_err(|fault| Trouble::broken(format!("at {at_s:.3} s: {fault}"), "finite numbers"))?;
        let found =
            || format!("a pose at {at_s:.3} s behind one at {:.3} s", before.unwrap_or_default().as_secs());
        expect(before.is_none_or(|before| before < pose.stamp), found, "stamps that grow")?;
        before = Some(pose.stamp);
        let is_seen = drive.frames.iter().flat_map(|frame| &frame.seen).any(|seen| seen.stamp == pose.stamp);
        expect(is_seen, || format!("a pose at {at_s:.3} s"), "stamps of what it was given")?;
    }
    Ok(format!("{} poses", poses.len()))
}

fn relocates(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let (before, after) = drive.frames.split_at(drive.frames.len() / 2);
    let (Some(start), Some(next)) = (before.first(), after.first()) else { return Ok(String::new()) };
    let mut tracker = Tracker::new(subject, &drive)?;
    tracker.start_at(start)?;
    for frame in before {
        tracker.follow(frame)?;
    }
    let known = n_known(&tracker.map);
    let told = tracker.relocate(&prior_of(&anew(next, next.now)));
    let told = told.ok_or_else(|| Trouble::not_applicable("it cannot be told"))?;
    told.map_err(|error| Trouble::broken(error, "a pose in its own map that it takes"))?;
    let (mut worst_m, mut worst_deg) = (0f64, 0f64);
    for frame in after {
        let estimate = tracker.follow(&anew(frame, next.now))?;
        let [off_m, off_deg] = apart(&frame.map_from_base, &estimate.pose2());
        (worst_m, worst_deg) = (worst_m.max(off_m), worst_deg.max(off_deg));
        let found = || format!("{off_m:.2} m and {off_deg:.1} degrees off at {:.1} s", frame.now.as_secs());
        expect(off_m <= 0.30 && off_deg <= 10.0, found, "at most 0.30 m and 10 degrees")?;
        let found = || format!("{} cells, lines and marks of {known}", n_known(&tracker.map));
        expect(2 * n_known(&tracker.map) >= known, found, "the map that it has built")?;
    }
    Ok(format!("at most {worst_m:.3} m and {worst_deg:.2} degrees off"))
}

/// The same moment by a clock that began at `start`, and an odometer that began elsewhere.
fn anew(frame: &Frame, start: Time) -> Frame {
    let mut frame = frame.clone();
    let by_clock = |stamp: Time| Time::ZERO + (stamp - start);
    let odom_from_before = pose2(5.0, -3.0, 2.0);
    frame.now = by_clock(frame.now);
    frame.odom_from_base = odom_from_before * frame.odom_from_base;
    for seen in &mut frame.seen {
        seen.stamp = by_clock(seen.stamp);
        if let Data::Odometry(odometry) = &mut seen.data {
            odometry.odom_from_base = odom_from_before * odometry.odom_from_base;
        }
    }
    frame
}

/// How much is in a map.
fn n_known(map: &Map) -> usize {
    let cells = map.grid.iter().flat_map(|grid| grid.cells.iter()).filter(|cell| **cell != 0.0).count();
    let lines = map.lines.as_ref().map_or(0, |lines| lines.lines.len());
    cells + lines + map.landmarks.as_ref().map_or(0, |marks| marks.landmarks.len())
}
