//! The observer that writes a run down.

use super::{EventRecord, PathRecord, PlanDrawing, RunRecord, SCHEMA, Sample, outline_of};
use crate::picture::MapImage;
use rumbo_core::engine::{EventKind, Observer, State, StepView};
use rumbo_core::frames::{Pose2, flatten};
use rumbo_core::map::{Lines, Map};
use rumbo_core::messages::StampedPose;
use rumbo_core::pipeline::Pipeline;
use rumbo_core::time::{Span, Time};
use rumbo_core::trace::Drawing;
use std::collections::BTreeSet;

/// Moments that are kept at most; when they are full every second one is dropped and half as many are taken.
const ROOM: usize = 4096;
/// Events that are kept at most, beside what the world tells: a table that a person reads.
const EVENTS: usize = 400;
/// Failures of stages that get a line on the terminal.
const TOLD_FAILURES: usize = 3;
/// Paths that are kept at most; the first and the latest.
const PATHS: usize = 64;

/// Writes a run down at a fixed period of the world's time.
pub struct Recorder {
    /// Somebody will draw the run; otherwise events are all that is kept.
    is_drawn: bool,
    period: Span,
    due: Time,
    samples: Vec<Sample>,
    paths: Vec<PathRecord>,
    path_number: u64,
    plan_drawings: Vec<PlanDrawing>,
    /// Obstacles in hundredths of a meter, so that the same one is kept once.
    obstacles: BTreeSet<[i32; 3]>,
    events: Vec<EventRecord>,
    n_events_left_out: usize,
    n_failures_told: usize,
    start: Option<[f64; 3]>,
}

impl Default for Recorder {
    fn default() -> Self {
        Recorder {
            is_drawn: true,
            period: Span::from_secs(0.1),
            due: Time::ZERO,
            samples: Vec::with_capacity(ROOM),
            paths: Vec::new(),
            path_number: 0,
            plan_drawings: Vec::new(),
            obstacles: BTreeSet::new(),
            events: Vec::with_capacity(EVENTS),
            n_events_left_out: 0,
            n_failures_told: 0,
            start: None,
        }
    }
}

impl Recorder {
    /// Keeps what a summary tells, and no moments, paths and drawings: nobody will draw the run.
    pub fn of_events() -> Recorder {
        Recorder { is_drawn: false, samples: Vec::new(), ..Recorder::default() }
    }

    /// Everything that was written down, with the map as the run left it.
    pub fn finish(self, pipeline: &Pipeline, file: &str, map: &Map, config: String) -> RunRecord {
        let mission = &pipeline.mission;
        RunRecord {
            schema: SCHEMA,
            name: pipeline.name.clone(),
            file: file.to_owned(),
            outcome: None,
            hull: outline_of(&pipeline.robot.hull()),
            arrival_radius_m: mission.arrival_radius_m,
            start: self.start,
            goals: mission.waypoints.iter().map(|waypoint| [waypoint.x_m, waypoint.y_m]).collect(),
            samples: self.samples,
            known_way: Vec::new(),
            paths: self.paths,
            obstacles: self.obstacles.iter().map(|cm| cm.map(|v| f64::from(v) * 0.01)).collect(),
            events: self.events,
            n_events_left_out: self.n_events_left_out,
            map: map.grid.as_ref().and_then(MapImage::of),
            walls: map.lines.as_ref().map(walls).unwrap_or_default(),
            seen: Vec::new(),
            plan_drawings: self.plan_drawings,
            config,
        }
    }

    fn sample(&mut self, view: &StepView<'_>) {
        if view.now < self.due {
            return;
        }
        self.due = view.now + self.period;
        if self.samples.len() == ROOM {
            let mut idx = 0;
            self.samples.retain(|_| {
                idx += 1;
                idx % 2 == 1
            });
            self.period = Span(self.period.0 * 2);
        }
        let covariance = view.estimate.covariance2();
        self.samples.push(Sample {
            time_s: view.now.as_secs(),
            truth: view.truth.map(|truth| numbers(&flatten(&truth.map_from_base))),
            estimate: numbers(&view.map_from_base),
            covariance: [covariance[(0, 0)], covariance[(0, 1)], covariance[(1, 1)]],
            is_located: !matches!(view.state, State::NoMap | State::Lost | State::Localizing),
            clearance_m: view.truth.map(|truth| truth.clearance_m).filter(|m| m.is_finite()),
            speed_m_s: view.command.twist.forward_m_s.hypot(view.command.twist.left_m_s),
            turn_rad_s: view.command.twist.turn_rad_s,
        });
    }

    fn follow_path(&mut self, view: &StepView<'_>) {
        if view.path_number == self.path_number {
            return;
        }
        self.path_number = view.path_number;
        let Some(path) = view.path else { return };
        if self.paths.len() == PATHS {
            self.paths.remove(1);
        }
        let points = path.points().iter().map(|point| [point.position.x, point.position.y]).collect();
        self.paths.push(PathRecord { time_s: view.now.as_secs(), points });
    }

    /// Also of a plan that failed: then they say most.
    fn keep_drawings(&mut self, view: &StepView<'_>) {
        let is_plan =
            |kind: &EventKind| matches!(kind, EventKind::PlanFound { .. } | EventKind::PlanFailed { .. });
        if view.events.iter().any(|event| is_plan(&event.kind)) {
            self.plan_drawings = view.drawings.iter().filter_map(plan_drawing).collect();
        }
    }

    fn note_events(&mut self, view: &StepView<'_>) {
        for event in view.events {
            if matches!(event.kind, EventKind::Blocked { .. }) {
                let hundredths = |m: f64| (m * 100.0).round() as i32;
                self.obstacles.extend(view.obstacles.iter().map(|obstacle| {
                    [obstacle.position.x, obstacle.position.y, obstacle.radius_m].map(hundredths)
                }));
            }
            let is_told = matches!(event.kind, EventKind::Notice(_));
            let is_failure = matches!(event.kind, EventKind::StageFailed { .. });
            // The first failures are told; a stage that goes on failing says the same again.
            let is_notice = is_told || is_failure && self.n_failures_told < TOLD_FAILURES;
            self.n_failures_told += usize::from(is_failure && is_notice);
            if self.events.len() >= EVENTS && !is_notice {
                self.n_events_left_out += 1;
                continue;
            }
            let is_trouble = !matches!(
                event.kind,
                EventKind::State { .. }
                    | EventKind::Status(_)
                    | EventKind::GoalAccepted(_)
                    | EventKind::PlanRequested { .. }
                    | EventKind::PlanFound { .. }
                    | EventKind::Forgot { .. }
                    | EventKind::Arrived(_)
                    | EventKind::Relocalized
            );
            let (time_s, text) = (event.stamp.as_secs(), event.kind.to_string());
            self.events.push(EventRecord { time_s, text, is_trouble, is_notice });
        }
    }
}

impl Observer for Recorder {
    fn on_step(&mut self, view: &StepView<'_>) {
        if self.start.is_none() {
            self.start = view.truth.map(|truth| numbers(&flatten(&truth.map_from_base)));
        }
        if self.is_drawn {
            self.sample(view);
            self.follow_path(view);
            self.keep_drawings(view);
        }
        self.note_events(view);
    }
}

/// Walls that a picture can show, to the centimeter.
fn walls(lines: &Lines) -> Vec<[[f64; 2]; 2]> {
    let walls = lines.lines.iter().map(|line| [line.from, line.to].map(|end| end.map(in_cm)));
    walls.filter(|wall| wall.iter().flatten().all(|v| v.is_finite())).collect()
}

/// Whole centimeters: a picture shows no more.
fn in_cm(v: f64) -> f64 {
    (v * 100.0).round() * 0.01
}

/// Poses as a way that a picture can show: as many places as moments are kept.
pub fn way(poses: &[StampedPose]) -> Vec<[f64; 2]> {
    let stride = poses.len().div_ceil(ROOM).max(1);
    let places = poses.iter().map(|pose| pose.map_from_base.translation.vector);
    places.step_by(stride).map(|place| [in_cm(place.x), in_cm(place.y)]).collect()
}

fn plan_drawing(drawing: &Drawing) -> Option<PlanDrawing> {
    let (name, is_points, points) = match drawing {
        Drawing::Polyline { name, points } => (name, false, points),
        Drawing::Points { name, points } => (name, true, points),
        _ => return None,
    };
    let mut points: Vec<[f64; 2]> = points.iter().map(|p| [in_cm(p.x), in_cm(p.y)]).collect();
    points.retain(|point| point.iter().all(|v| v.is_finite()));
    points.dedup();
    Some(PlanDrawing { name: (*name).to_owned(), is_points, points })
}

fn numbers(pose: &Pose2) -> [f64; 3] {
    [pose.translation.x, pose.translation.y, pose.rotation.angle()]
}
