//! The figures of a run, gathered by an observer.

use super::errors::Errors;
use super::events::EventKind;
use super::observer::{Observer, StepView};
use super::order::State;
use super::run::EndReason;
use super::timing::{Part, StageTimes};
use crate::frames::{Point2, Pose2, flatten, wrap_angle};
use crate::messages::{Data, Observation, SensorId, Status};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The figures of a run. Errors are of the estimate against the truth, and absent where nobody knows the truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// All waypoints were reached.
    pub arrived: bool,
    /// Why the run ended.
    pub reason: EndReason,
    /// More about the end, for people.
    pub detail: Option<String>,
    /// Time in the world, seconds.
    pub time_s: f64,
    /// Way driven: by the truth where it is known, else by the odometer, which does not jump, meters.
    pub path_m: f64,
    /// True end to the last goal, meters.
    pub goal_error_m: Option<f64>,
    /// Last estimate to the truth, meters.
    pub final_error_m: Option<f64>,
    /// Last estimate to the truth along the map's x axis, meters, without sign.
    pub final_error_x_m: Option<f64>,
    /// Last estimate to the truth along the map's y axis, meters, without sign.
    pub final_error_y_m: Option<f64>,
    /// Last estimate to the truth, degrees.
    pub final_heading_error_deg: Option<f64>,
    /// Root mean square of estimate to truth, meters.
    pub rms_error_m: Option<f64>,
    /// 95 % of the steps are below this, estimate to truth, meters.
    pub p95_error_m: Option<f64>,
    /// Root mean square of the estimate's heading to the truth, degrees.
    pub rms_heading_error_deg: Option<f64>,
    /// Turns to either side added up, over the way driven, degrees a meter; absent where the robot stood still.
    pub turn_deg_m: Option<f64>,
    /// Hull to obstacle at the least, meters.
    pub min_clearance_m: Option<f64>,
    /// How often contact began.
    pub contacts: Option<u32>,
    /// In how many of these the robot's own motion was closing the distance.
    pub driven_contacts: Option<u32>,
    /// When contact first began, seconds.
    pub first_contact_s: Option<f64>,
    /// When the avoider first said that the way is blocked, seconds.
    pub first_blocked_s: Option<f64>,
    /// New plans after the first of each goal.
    pub replans: u32,
    /// How often the guard stepped in, counted in episodes.
    pub guard_interventions: u32,
    /// How often a stage failed.
    pub stage_failures: u32,
    /// Share of the steps in which the localizer was sure of one place.
    pub tracked_share: f64,
    /// Steps of the engine.
    pub steps: u64,
    /// What stages counted, if the engine was told to keep it ([`Engine::count`](super::Engine::count)).
    pub counters: BTreeMap<&'static str, Counted>,
}

/// All values of one counter.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Counted {
    /// How many there were.
    pub n: u64,
    /// Their mean.
    pub mean: f64,
    /// The last one.
    pub last: f64,
}

impl Counted {
    fn add(&mut self, value: f64) {
        self.n += 1;
        self.mean += (value - self.mean) / self.n as f64;
        self.last = value;
    }
}

/// Gathers a [`Summary`].
#[derive(Debug, Default)]
pub struct Metrics {
    time_s: f64,
    steps: u64,
    path_m: f64,
    turned_rad: f64,
    last_truth: Option<Pose2>,
    last_reading: Option<(SensorId, Pose2)>,
    n_tracked: u64,
    errors: Errors,
    squared_heading_errors_rad2: f64,
    final_error_m: Option<[f64; 2]>,
    final_heading_error_deg: Option<f64>,
    goal: Option<Point2>,
    goal_error_m: Option<f64>,
    min_clearance_m: Option<f64>,
    contacts: Option<u32>,
    driven_contacts: Option<u32>,
    first_contact_s: Option<f64>,
    first_blocked_s: Option<f64>,
    replans: u32,
    guard_interventions: u32,
    stage_failures: u32,
    times: StageTimes,
    counters: BTreeMap<&'static str, Counted>,
}

impl Metrics {
    /// A robot that drove less has no figure per meter.
    const LEAST_WAY_M: f64 = 0.01;

    /// Nothing seen yet.
    pub fn new() -> Metrics {
        Metrics::default()
    }

    /// Wall time used by each part of the steps.
    pub fn times(&self) -> &StageTimes {
        &self.times
    }

    /// `cpu_<part>_s` of every part, seconds.
    pub fn cpu_seconds(&self) -> impl Iterator<Item = (&'static str, f64)> + '_ {
        Part::ALL.into_iter().map(|part| (part.name(), self.times.of(part).as_secs_f64()))
    }

    /// The figures of a run that ended for this reason.
    pub fn summary(&self, reason: EndReason, detail: Option<String>) -> Summary {
        Summary {
            arrived: reason == EndReason::Arrived,
            reason,
            detail,
            time_s: self.time_s,
            path_m: self.path_m,
            goal_error_m: self.goal_error_m,
            final_error_m: self.errors.last_m(),
            final_error_x_m: self.final_error_m.map(|[x, _]| x),
            final_error_y_m: self.final_error_m.map(|[_, y]| y),
            final_heading_error_deg: self.final_heading_error_deg,
            rms_error_m: self.errors.rms_m(),
            p95_error_m: self.errors.quantile_m(0.95),
            rms_heading_error_deg: self.rms_heading_error_deg(),
            turn_deg_m: (self.path_m > Self::LEAST_WAY_M).then(|| self.turned_rad.to_degrees() / self.path_m),
            min_clearance_m: self.min_clearance_m,
            contacts: self.contacts,
            driven_contacts: self.driven_contacts,
            first_contact_s: self.first_contact_s,
            first_blocked_s: self.first_blocked_s,
            replans: self.replans,
            guard_interventions: self.guard_interventions,
            stage_failures: self.stage_failures,
            tracked_share: self.n_tracked as f64 / self.steps.max(1) as f64,
            steps: self.steps,
            counters: self.counters.clone(),
        }
    }

    fn rms_heading_error_deg(&self) -> Option<f64> {
        let n_errors = self.errors.n();
        (n_errors > 0).then(|| (self.squared_heading_errors_rad2 / n_errors as f64).sqrt().to_degrees())
    }

    /// The way of this step: that of the truth where it is known before and after, else that of the odometer.
    fn follow(&mut self, view: &StepView<'_>) {
        let truth = view.truth.map(|truth| flatten(&truth.map_from_base));
        let true_way = truth.zip(self.last_truth).map(|(now, last)| way(&last, &now));
        let rolled = self.rolled(view.observations);
        let (way_m, turn_rad) = true_way.unwrap_or(rolled);
        self.path_m += way_m;
        self.turned_rad += turn_rad;
        self.last_truth = truth;
        self.n_tracked += u64::from(view.estimate.status == Status::Tracking);
        self.goal = view.goal.map(|goal| goal.position).or(self.goal);
    }

    /// The way between the odometer's readings of this step; readings of the odometer seat go before those of wheels.
    fn rolled(&mut self, observations: &[Observation]) -> (f64, f64) {
        let mut rolled = (0.0, 0.0);
        for observation in observations {
            let Data::Odometry(odometry) = &observation.data else { continue };
            let pose = odometry.odom_from_base;
            match self.last_reading {
                Some((sensor, last)) if sensor == observation.sensor => {
                    let (way_m, turn_rad) = way(&last, &pose);
                    rolled = (rolled.0 + way_m, rolled.1 + turn_rad);
                }
                Some(_) if observation.sensor != SensorId::ODOMETER => continue,
                _ => {}
            }
            self.last_reading = Some((observation.sensor, pose));
        }
        rolled
    }

    fn judge(&mut self, view: &StepView<'_>) {
        let Some(truth) = view.truth else { return };
        let true_pose = flatten(&truth.map_from_base);
        if !matches!(view.state, State::NoMap | State::Lost | State::Localizing) {
            let error = view.map_from_base.translation.vector - true_pose.translation.vector;
            let error_m = error.norm();
            self.final_error_m = Some([error.x.abs(), error.y.abs()]);
            let turn = wrap_angle(view.map_from_base.rotation.angle() - true_pose.rotation.angle());
            self.errors.add(error_m);
            self.squared_heading_errors_rad2 += turn.powi(2);
            self.final_heading_error_deg = Some(turn.abs().to_degrees());
        }
        if truth.clearance_m.is_finite() {
            let least = self.min_clearance_m.map_or(truth.clearance_m, |m| m.min(truth.clearance_m));
            self.min_clearance_m = Some(least);
        }
        self.contacts = truth.contact_episodes;
        self.driven_contacts = truth.driven_contact_episodes;
        if self.contacts.is_some_and(|n| n > 0) {
            self.first_contact_s.get_or_insert(self.time_s);
        }
        self.goal_error_m = self.goal.map(|goal| (goal - Point2::from(true_pose.translation.vector)).norm());
    }
}

/// Meters and radians between two poses.
fn way(from: &Pose2, to: &Pose2) -> (f64, f64) {
    let turn_rad = wrap_angle(to.rotation.angle() - from.rotation.angle()).abs();
    ((to.translation.vector - from.translation.vector).norm(), turn_rad)
}

impl Observer for Metrics {
    fn on_step(&mut self, view: &StepView<'_>) {
        self.time_s = (view.now - view.started).as_secs();
        self.steps = view.step + 1;
        self.times = *view.times;
        self.follow(view);
        self.judge(view);
        for (name, value) in view.counters.iter().filter(|(_, value)| value.is_finite()) {
            self.counters.entry(name).or_default().add(*value);
        }
        for event in view.events {
            match event.kind {
                EventKind::PlanRequested { replans } if replans > 0 => self.replans += 1,
                EventKind::Blocked { .. } => {
                    self.first_blocked_s.get_or_insert(self.time_s);
                }
                EventKind::Guard(_) => self.guard_interventions += 1,
                EventKind::StageFailed { .. } => self.stage_failures += 1,
                _ => {}
            }
        }
    }
}
