//! What stages said in a step, to the bit: estimate, path, command, events; and the mark that closes the step.

use super::cdr::{CdrError, CdrReader, CdrWriter};
use super::pose::{numbers2, numbers3, pose2_of, pose3_of, put_twist, twist};
use rumbo_core::engine::{Event, State};
use rumbo_core::frames::{Point2, Pose3};
use rumbo_core::messages::{Command, Estimate, Path, PathPoint, Status, Wish};
use rumbo_core::stages::Truth;
use rumbo_core::time::Time;

/// Writes an estimate.
pub fn put_estimate(cdr: &mut CdrWriter, estimate: &Estimate) {
    cdr.begin().i64(estimate.stamp.0);
    cdr.array(&numbers3(&estimate.map_from_odom));
    cdr.array(&numbers3(&estimate.map_from_base));
    cdr.array(estimate.covariance.as_slice());
    cdr.u8(match estimate.status {
        Status::Lost => 0,
        Status::Converging => 1,
        Status::Tracking => 2,
        Status::Ambiguous => 3,
        _ => u8::MAX,
    });
    cdr.length(estimate.candidates.len());
    for candidate in &estimate.candidates {
        cdr.array(&numbers2(&candidate.map_from_base));
        cdr.f64(candidate.score);
    }
    let (wish, by) = match estimate.wish {
        None => (0, 0.0),
        Some(Wish::HoldStill) => (1, 0.0),
        Some(Wish::TurnBy(by)) => (2, by),
        Some(Wish::MoveBy(by)) => (3, by),
        Some(_) => (u8::MAX, 0.0),
    };
    cdr.u8(wish);
    cdr.f64(by);
}

/// The place in an estimate that was written.
pub fn estimated_place(message: &[u8]) -> Result<Pose3, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    cdr.i64()?;
    let _map_from_odom: [f64; 7] = cdr.array()?;
    Ok(pose3_of(cdr.array()?))
}

/// Writes the path that is followed, or that there is none.
pub fn put_path(cdr: &mut CdrWriter, number: u64, path: Option<&Path>) {
    cdr.begin().u64(number);
    cdr.f64s(path.map(|path| path.cost).as_slice());
    put_points(cdr, path.map_or(&[], Path::points));
}

pub(super) fn put_points(cdr: &mut CdrWriter, points: &[PathPoint]) {
    cdr.length(points.len());
    for point in points {
        cdr.array(&[point.position.x, point.position.y]);
        cdr.f64s(point.yaw_rad.as_slice());
    }
}

pub(super) fn points(cdr: &mut CdrReader<'_>) -> Result<Vec<PathPoint>, CdrError> {
    let point = |cdr: &mut CdrReader<'_>| {
        let [x, y] = cdr.array()?;
        Ok(PathPoint { position: Point2::new(x, y), yaw_rad: cdr.f64s()?.first().copied() })
    };
    (0..cdr.length(16)?).map(|_| point(cdr)).collect()
}

/// The path that was written.
pub fn read_path(message: &[u8]) -> Result<Option<Path>, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    cdr.u64()?;
    let cost = cdr.f64s()?.first().copied();
    let points = points(&mut cdr)?;
    Ok(cost.and_then(|cost| Path::new(points, cost)))
}

/// Writes what went to the wheels.
pub fn put_command(cdr: &mut CdrWriter, command: &Command, is_actuated: bool) {
    cdr.begin().i64(command.stamp.0);
    put_twist(cdr, &command.twist);
    cdr.bool(is_actuated);
}

/// What went to the wheels, and whether they obeyed.
pub fn read_command(message: &[u8]) -> Result<(Command, bool), CdrError> {
    let mut cdr = CdrReader::new(message)?;
    Ok((Command { stamp: Time(cdr.i64()?), twist: twist(&mut cdr)? }, cdr.bool()?))
}

/// Writes an event.
pub fn put_event(cdr: &mut CdrWriter, event: &Event) {
    cdr.begin().i64(event.stamp.0);
    // The derived text has every number in full, whatever kinds of events are added.
    let exact = format!("{:?}", event.kind);
    let kind = exact.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
    cdr.text(kind);
    cdr.text(&exact);
    cdr.text(&event.kind.to_string());
}

/// An event as it was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RecordedEvent {
    /// When.
    pub stamp: Time,
    /// Its kind, one word.
    pub kind: String,
    /// All that it says, with every digit.
    pub exact: String,
    /// For people.
    pub text: String,
}

/// An event that was written.
pub fn read_event(message: &[u8]) -> Result<RecordedEvent, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    Ok(RecordedEvent { stamp: Time(cdr.i64()?), kind: cdr.text()?, exact: cdr.text()?, text: cdr.text()? })
}

/// What closes a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepMark {
    /// How many steps there were before.
    pub step: u64,
    /// The time of the engine.
    pub now: Time,
    /// Where the robot really was.
    pub truth: Option<Truth>,
}

/// Writes what closes a step.
pub fn put_step(cdr: &mut CdrWriter, mark: &StepMark, state: State) {
    cdr.begin().u64(mark.step);
    cdr.i64(mark.now.0);
    cdr.u8(match state {
        State::NoMap => 0,
        State::Lost => 1,
        State::Localizing => 2,
        State::Waiting => 3,
        State::Navigating => 4,
    });
    cdr.length(usize::from(mark.truth.is_some()));
    if let Some(truth) = &mark.truth {
        cdr.array(&numbers3(&truth.map_from_base));
        put_twist(cdr, &truth.twist);
        cdr.f64(truth.clearance_m);
        // All of them, then those that the robot drove into: recordings from before they were told apart have one number.
        let episodes = truth.contact_episodes.into_iter().chain(truth.driven_contact_episodes);
        cdr.length(episodes.clone().count());
        episodes.for_each(|n| cdr.u32(n));
    }
}

/// What closed a step.
pub fn read_step(message: &[u8]) -> Result<StepMark, CdrError> {
    let mut cdr = CdrReader::new(message)?;
    let (step, now, _state) = (cdr.u64()?, Time(cdr.i64()?), cdr.u8()?);
    let truth = match cdr.length(1)? {
        0 => None,
        _ => {
            let (map_from_base, twist) = (pose3_of(cdr.array()?), twist(&mut cdr)?);
            let (clearance_m, n_episodes) = (cdr.f64()?, cdr.length(4)?);
            let contact_episodes = (n_episodes > 0).then(|| cdr.u32()).transpose()?;
            let driven_contact_episodes = (n_episodes > 1).then(|| cdr.u32()).transpose()?;
            Some(Truth { map_from_base, twist, clearance_m, contact_episodes, driven_contact_episodes })
        }
    };
    Ok(StepMark { step, now, truth })
}

/// The place in the plane that four numbers stand for.
pub fn place2(numbers: &[f64]) -> Option<rumbo_core::frames::Pose2> {
    numbers.try_into().ok().map(pose2_of)
}
