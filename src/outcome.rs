//! The figures of one run, as `--json` prints them and saved runs keep them.

use rumbo_core::engine::{Counted, EndReason, Metrics, Part, RunEnd};
use rumbo_core::map::{Grid, Map};
use rumbo_core::pipeline::Pipeline;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Duration;

/// The figures of one run. Two runs of the same pipeline and seed differ in `realtime_factor` and `cpu_*` only.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Name of the pipeline.
    pub pipeline: String,
    /// Seed of the run.
    pub seed: u64,
    /// All waypoints were reached.
    pub arrived: bool,
    /// Why the run ended.
    pub reason: EndReason,
    /// More about the end, for people.
    pub detail: Option<String>,
    /// Time in the world, seconds.
    pub time_s: f64,
    /// Way driven, meters.
    pub path_m: f64,
    /// True end to the last goal, meters.
    pub goal_error_m: Option<f64>,
    /// Last estimate to the truth, meters.
    pub final_error_m: Option<f64>,
    /// Last estimate to the truth along the map's x axis, meters, without sign.
    #[serde(default)]
    pub final_error_x_m: Option<f64>,
    /// Last estimate to the truth along the map's y axis, meters, without sign.
    #[serde(default)]
    pub final_error_y_m: Option<f64>,
    /// Last estimate to the truth, degrees.
    pub final_heading_error_deg: Option<f64>,
    /// Root mean square of estimate to truth, meters.
    pub rms_error_m: Option<f64>,
    /// 95 % of the steps are below this, estimate to truth, meters.
    pub p95_error_m: Option<f64>,
    /// Root mean square of the heading's error, degrees.
    #[serde(default)]
    pub rms_heading_error_deg: Option<f64>,
    /// Turns to either side added up, over the way driven, degrees a meter.
    #[serde(default)]
    pub turn_deg_m: Option<f64>,
    /// Hull to obstacle at the least, meters.
    pub min_clearance_m: Option<f64>,
    /// How often contact began.
    pub contacts: Option<u32>,
    /// In how many of these the robot's own motion was closing the distance: not those of somebody who walked into it.
    #[serde(default)]
    pub driven_contacts: Option<u32>,
    /// When contact first began, seconds.
    #[serde(default)]
    pub first_contact_s: Option<f64>,
    /// When the avoider first said that the way is blocked, seconds.
    #[serde(default)]
    pub first_blocked_s: Option<f64>,
    /// New plans after the first of each goal.
    pub replans: u32,
    /// How often the guard stepped in.
    pub guard_interventions: u32,
    /// How often a stage failed.
    pub stage_failures: u32,
    /// Share of the steps in which the localizer was sure of one place.
    #[serde(default)]
    pub tracked_share: Option<f64>,
    /// Free space on the map at the end, m².
    #[serde(default)]
    pub map_free_m2: Option<f64>,
    /// Steps of the engine.
    pub steps: u64,
    /// What stages counted, where that was asked for.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub counters: BTreeMap<String, Counted>,
    /// Time in the world over time on the wall.
    pub realtime_factor: Option<f64>,
    /// `cpu_<part>_s`: time on the wall that each part of the steps used, seconds.
    #[serde(flatten)]
    pub cpu: BTreeMap<String, f64>,
}

impl Outcome {
    /// The figures of a run that ended.
    pub fn new(pipeline: &Pipeline, metrics: &Metrics, end: &RunEnd, map: &Map, wall: Duration) -> Outcome {
        let summary = metrics.summary(end.reason, end.detail.clone());
        let mut cpu: BTreeMap<String, f64> = Part::ALL
            .into_iter()
            .map(|part| (format!("cpu_{}_s", part.name()), metrics.times().of(part).as_secs_f64()))
            .collect();
        cpu.insert("cpu_total_s".into(), metrics.times().total().as_secs_f64());
        Outcome {
            pipeline: pipeline.name.clone(),
            seed: pipeline.seed,
            arrived: summary.arrived,
            reason: summary.reason,
            detail: summary.detail,
            time_s: summary.time_s,
            path_m: summary.path_m,
            goal_error_m: summary.goal_error_m,
            final_error_m: summary.final_error_m,
            final_error_x_m: summary.final_error_x_m,
            final_error_y_m: summary.final_error_y_m,
            final_heading_error_deg: summary.final_heading_error_deg,
            rms_error_m: summary.rms_error_m,
            p95_error_m: summary.p95_error_m,
            rms_heading_error_deg: summary.rms_heading_error_deg,
            turn_deg_m: summary.turn_deg_m,
            min_clearance_m: summary.min_clearance_m,
            contacts: summary.contacts,
            driven_contacts: summary.driven_contacts,
            first_contact_s: summary.first_contact_s,
            first_blocked_s: summary.first_blocked_s,
            replans: summary.replans,
            guard_interventions: summary.guard_interventions,
            stage_failures: summary.stage_failures,
            tracked_share: Some(summary.tracked_share),
            map_free_m2: map.grid.as_ref().map(Grid::free_area_m2),
            steps: summary.steps,
            counters: summary.counters.into_iter().map(|(name, of)| (name.to_owned(), of)).collect(),
            realtime_factor: (wall > Duration::ZERO).then(|| summary.time_s / wall.as_secs_f64()),
            cpu,
        }
    }

    /// The run did what it was for.
    pub fn is_success(&self) -> bool {
        self.arrived || matches!(self.reason, EndReason::Ended | EndReason::Finished)
    }

    /// The avoider saw what is in the way before the hull touched anything; true where it touched nothing, and absent where
    /// nobody knows.
    pub fn saw_before_contact(&self) -> Option<bool> {
        let contacts = self.contacts?;
        let saw = self.first_blocked_s.zip(self.first_contact_s).is_some_and(|(saw, touched)| saw < touched);
        Some(contacts == 0 || saw)
    }

    /// Time used by one part, seconds.
    pub fn cpu_s(&self, part: Part) -> f64 {
        self.cpu.get(&format!("cpu_{}_s", part.name())).copied().unwrap_or(0.0)
    }

    /// What to try next, where the run did not succeed.
    pub fn hint(&self) -> Option<&'static str> {
        Some(match self.reason {
            EndReason::Unreachable => {
                "look at the picture: is the way really closed? A smaller clearance of the planner may open it"
            }
            EndReason::Stuck => {
                "the robot made no way in one place; the events in the report say where, and what was in the way"
            }
            EndReason::Timeout => "raise `mission.goal_timeout_s`, or look in the report where the time went",
            EndReason::TimeLimit => {
                "raise `mission.time_limit_s` (or --duration), or look in the report why it took so long"
            }
            EndReason::PlannerFailed => "move the start or the goal to a free place, or name another planner",
            EndReason::StageFailed => "the events in the report name the stage and what it said",
            EndReason::WorldFailed => "the world cannot go on; see its message above",
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use crate::record::test_record;

    #[test]
    fn the_json_has_every_promised_field_on_one_level() {
        let json = serde_json::to_value(test_record().outcome).unwrap();
        for field in "arrived reason time_s path_m goal_error_m final_error_m rms_error_m p95_error_m \
                      min_clearance_m contacts replans guard_interventions realtime_factor cpu_planner_s"
            .split_whitespace()
        {
            assert!(json.get(field).is_some(), "{field}");
        }
    }
}
