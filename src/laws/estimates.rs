//! Laws of localizers and SLAM plugins: where the robot is, how surely, and the same from every side.

use super::drive::{Drive, step_time};
use super::estimate_faults as faults;
use super::estimators::{Tracker, covariance_is_sane, estimates, numbers_are_sane};
use super::law::{Law, Trouble, Verdict, expect};
use super::memory::stays_finite;
use super::slam;
use super::subject::Subject;
use super::turn::Turn;
use rumbo_core::boundary::Buffer;
use rumbo_core::frames::{Pose2, wrap_angle};
use rumbo_core::messages::{Estimate, Prior};
use rumbo_core::stages::BuildContext;

const FOLLOWS: Law =
    Law::new("it follows a robot from a known pose", follows).within("0.30 m and 10 degrees over 3 m");
const FINITE: Law = Law::new("every number of an estimate is finite, and none is of the future", finite);
const COVARIANCE: Law = Law::new("covariances are symmetric and positive semi-definite", covariance)
    .within("1e-9 of the largest");
const DETERMINISTIC: Law =
    Law::new("the same drive gives the same estimates, also after a new start", deterministic)
        .within("to the bit, with the same seed");
const SYMMETRIC: Law = Law::new("a world turned or mirrored turns the estimate with it", symmetric)
    .within("1 cm and 0.5 degrees; 15 cm and 5 degrees where chance plays a part");
const MEMORY: Law = Law::new("10,000 calls use finite memory", finite_memory).within("64 MiB").long();

/// What every localizer keeps.
pub const LOCALIZER_LAWS: &[Law] = &[
    FOLLOWS,
    FINITE,
    COVARIANCE,
    DETERMINISTIC,
    SYMMETRIC,
    faults::NOTHING_NEW,
    faults::NOT_STARTED,
    faults::BAD_PRIOR,
    faults::ODD_READINGS,
    faults::EMPTY_MAP,
    MEMORY,
];

/// What every SLAM plugin keeps.
pub const SLAM_LAWS: &[Law] = &[
    FOLLOWS,
    FINITE,
    COVARIANCE,
    DETERMINISTIC,
    SYMMETRIC,
    Law::new("it gives the layers that it declares", gives_its_layers),
    Law::new("it goes on from what it saved", goes_on).within("1e-9 m and rad"),
    faults::BAD_SAVED,
    slam::TRAJECTORY,
    slam::RELOCATES,
    faults::NOTHING_NEW,
    faults::NOT_STARTED,
    faults::BAD_PRIOR,
    faults::ODD_READINGS,
    MEMORY,
];

/// How far two poses are apart: meters, and degrees.
pub(super) fn apart(one: &Pose2, other: &Pose2) -> [f64; 2] {
    let way_m = (one.translation.vector - other.translation.vector).norm();
    [way_m, wrap_angle(one.rotation.angle() - other.rotation.angle()).abs().to_degrees()]
}

fn follows(subject: &Subject) -> Verdict {
    let (drive, estimates) = estimates(subject, Turn::None)?;
    let (mut worst_m, mut worst_deg) = (0f64, 0f64);
    for (frame, estimate) in drive.frames.iter().zip(&estimates) {
        let [off_m, off_deg] = apart(&frame.map_from_base, &estimate.pose2());
        (worst_m, worst_deg) = (worst_m.max(off_m), worst_deg.max(off_deg));
        let found = || format!("{off_m:.2} m and {off_deg:.1} degrees off at {:.1} s", frame.now.as_secs());
        expect(off_m <= 0.30 && off_deg <= 10.0, found, "at most 0.30 m and 10 degrees")?;
    }
    Ok(format!("at most {worst_m:.3} m and {worst_deg:.2} degrees off"))
}

fn finite(subject: &Subject) -> Verdict {
    let (drive, estimates) = estimates(subject, Turn::None)?;
    for (frame, estimate) in drive.frames.iter().zip(&estimates) {
        numbers_are_sane(&format!("after {:.1} s", frame.now.as_secs()), estimate, frame.now)?;
    }
    Ok(format!("{} estimates", estimates.len()))
}

fn covariance(subject: &Subject) -> Verdict {
    let (_, estimates) = estimates(subject, Turn::None)?;
    for estimate in &estimates {
        covariance_is_sane(&format!("at {:.1} s", estimate.stamp.as_secs()), estimate)?;
    }
    Ok(String::new())
}

fn deterministic(subject: &Subject) -> Verdict {
    let (drive, first) = estimates(subject, Turn::None)?;
    let mut other = Tracker::new(subject, &drive)?;
    let same = |estimates: &[Estimate], which: &str| {
        let differs = first.iter().zip(estimates).position(|(a, b)| a != b);
        let found = || format!("{which}: estimate {} differs", differs.unwrap_or_default());
        expect(differs.is_none(), found, "the same estimates")
    };
    same(&other.follow_all(&drive)?, "another one")?;
    let map = other.map.clone();
    same(&other.follow_all(&drive)?, "the same one, started again")?;
    let other_map = Tracker::new(subject, &drive).and_then(|mut third| {
        third.follow_all(&drive)?;
        Ok(third.map)
    })?;
    expect(map == other_map, || "two maps of the same drive differ".into(), "the same map")?;
    Ok(format!("{} estimates", first.len()))
}

fn symmetric(subject: &Subject) -> Verdict {
    if subject.has_recording() {
        return Err(Trouble::not_applicable("its poses come from a file, which nobody turns"));
    }
    let (drive, as_is) = estimates(subject, Turn::None)?;
    let other_seed = BuildContext { seed: subject.context().seed + 1, ..subject.context() };
    let is_random = Tracker::new_in(subject, &drive, &other_seed)?.follow_all(&drive)? != as_is;
    let (most_m, most_deg) = if is_random { (0.15, 5.0) } else { (0.01, 0.5) };
    let height_m = drive.world.height_m();
    // The drive lies in the hall as it is, whose height turned worlds need.
    let (mut worst_m, mut worst_deg) = (0f64, 0f64);
    for turn in Turn::BOTH {
        let (turned_drive, turned) = estimates(subject, turn)?;
        for ((estimate, other), frame) in as_is.iter().zip(&turned).zip(&turned_drive.frames) {
            let [off_m, off_deg] = apart(&turn.pose(&estimate.pose2(), height_m), &other.pose2());
            (worst_m, worst_deg) = (worst_m.max(off_m), worst_deg.max(off_deg));
            let found = || {
                let at_s = frame.now.as_secs();
                format!("{off_m:.3} m and {off_deg:.2} degrees apart at {at_s:.1} s, {}", turn.name())
            };
            expect(
                off_m <= most_m && off_deg <= most_deg,
                found,
                format!("at most {most_m} m and {most_deg} degrees"),
            )?;
        }
    }
    let chance = if is_random { ", with chance" } else { "" };
    Ok(format!("at most {worst_m:.4} m and {worst_deg:.3} degrees{chance}"))
}

fn gives_its_layers(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let mut tracker = Tracker::new(subject, &drive)?;
    if let Some(first) = drive.frames.first() {
        tracker.start_at(first)?;
    }
    for layer in subject.manifest().gives_layers {
        let found = || format!("no layer {} after the start", layer.name());
        expect(tracker.map.has(layer), found, "every layer that it declares")?;
    }
    let version = tracker.map.version;
    for frame in &drive.frames {
        tracker.follow(frame)?;
    }
    let found = || format!("the map's version is {version} at the start and at the end");
    expect(tracker.map.version > version, found, "a version that goes up with every change")?;
    Ok(String::new())
}

fn goes_on(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let (before, after) = drive.frames.split_at(drive.frames.len() / 2);
    let mut first = Tracker::new(subject, &drive)?;
    let (Some(start), Some(next)) = (before.first(), after.first()) else { return Ok(String::new()) };
    first.start_at(start)?;
    for frame in before {
        first.follow(frame)?;
    }
    let Some(saved) = first.save() else {
        return Err(Trouble::not_applicable("it cannot save its state"));
    };
    let mut second = Tracker::new(subject, &drive)?;
    second.map = first.map.clone();
    let n_bytes = saved.len();
    second.start(&Prior::Saved(Buffer::from(saved))).map_err(|error| {
        Trouble::broken(format!("it does not start from what it saved: {error}"), "a start")
    })?;
    let [off_m, off_deg] = apart(&first.follow(next)?.pose2(), &second.follow(next)?.pose2());
    let found = || format!("{off_m:e} m and {off_deg:e} degrees apart");
    expect(off_m <= 1e-9 && off_deg.to_radians() <= 1e-9, found, "the same estimate")?;
    Ok(format!("{n_bytes} bytes"))
}

fn finite_memory(subject: &Subject) -> Verdict {
    let drive = Drive::seen_from(Turn::None)?;
    let mut tracker = Tracker::new(subject, &drive)?;
    if let Some(first) = drive.frames.first() {
        tracker.start_at(first)?;
    }
    // There and back again, so that the odometer never jumps.
    let mut frames = drive.frames.iter().chain(drive.frames.iter().rev()).cycle();
    stays_finite(|k| {
        if let Some(frame) = frames.next() {
            let now = step_time(k);
            let mut seen = frame.seen.clone();
            seen.iter_mut().for_each(|observation| observation.stamp = now);
            // What it answers is judged by other laws.
            let _ = tracker.update(now, &seen);
        }
        Ok(())
    })
}
