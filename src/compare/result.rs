//! What one run gives, also one that never drove.

use super::design::{Design, Run, effective};
use crate::drive::drive_for_figures;
use crate::load::{Ready, Refused};
use crate::outcome::Outcome;
use crate::test::expect::failures;
use rumbo_core::engine::EndReason;
use rumbo_core::pipeline::Expect;
use rumbo_core::registry::Registry;
use serde::{Deserialize, Serialize};
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::AtomicBool;

/// The result of one run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RunResult {
    /// Why it ended: the run's own reason, or `refused`, `not_built`, `panicked`.
    pub end: String,
    /// More about the end.
    pub detail: Option<String>,
    /// Start, meters and degrees; absent where the pipeline was refused.
    pub start: Option<[f64; 3]>,
    /// Last waypoint, meters.
    pub goal: Option<[f64; 2]>,
    /// From the start over all waypoints in straight lines, meters.
    pub straight_m: Option<f64>,
    /// The figures of a run that drove.
    pub outcome: Option<Outcome>,
    /// What was drawn for it, as arguments of `--set`: with them and its seed, `rumbo run` does it again.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drawn: Vec<String>,
    /// Whether it met what the study expects; absent where there is no such expectation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub as_expected: Option<bool>,
}

impl RunResult {
    /// It did what it was for.
    pub fn is_success(&self) -> bool {
        let outcome = self.outcome.as_ref();
        outcome.is_some_and(|outcome| self.as_expected.unwrap_or_else(|| outcome.is_success()))
    }

    /// Somebody asked to stop: this is no result.
    fn is_interrupted(&self) -> bool {
        self.outcome.as_ref().is_some_and(|outcome| outcome.reason == EndReason::Interrupted)
    }

    /// A run that never drove.
    pub fn without_drive(end: &str, detail: String) -> RunResult {
        let end = end.to_owned();
        RunResult {
            end,
            detail: Some(detail),
            start: None,
            goal: None,
            straight_m: None,
            outcome: None,
            drawn: Vec::new(),
            as_expected: None,
        }
    }
}

/// Does one run; none when it was interrupted.
pub fn work(design: &Design, run: &Run, registry: &Registry, interrupt: &AtomicBool) -> Option<RunResult> {
    let drawn = match design.drawn(run) {
        Ok(drawn) => drawn,
        Err(message) => return Some(RunResult::without_drive("not_drawn", message)),
    };
    let drive = || match design.load(run, &drawn, registry) {
        Ok(ready) => driven(&ready, design.expect(run), interrupt),
        Err(refused) => RunResult::without_drive("refused", first_message(&refused)),
    };
    let result = RunResult { drawn: drawn.clone(), ..caught(drive) };
    (!result.is_interrupted()).then_some(result)
}

/// What `drive` gives, or that it panicked.
fn caught(drive: impl FnOnce() -> RunResult) -> RunResult {
    catch_unwind(AssertUnwindSafe(drive))
        .unwrap_or_else(|payload| RunResult::without_drive("panicked", said(payload.as_ref())))
}

fn said(payload: &(dyn Any + Send)) -> String {
    let text = payload.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| payload.downcast_ref::<String>().cloned()).unwrap_or_else(|| "without a message".into())
}

fn driven(ready: &Ready, expect: Option<&Expect>, interrupt: &AtomicBool) -> RunResult {
    let outcome = match drive_for_figures(&ready.pipeline, interrupt) {
        Ok(outcome) => outcome,
        Err(error) => return RunResult::without_drive("not_built", error.to_string()),
    };
    let pipeline = effective(ready);
    let number = |key: &str| pipeline.pointer(&format!("/world/start/{key}")).and_then(|v| v.as_f64());
    let start = number("x_m").zip(number("y_m")).map(|(x, y)| [x, y, number("yaw_deg").unwrap_or(0.0)]);
    let way: Vec<[f64; 2]> = start
        .iter()
        .map(|[x, y, _]| [*x, *y])
        .chain(ready.pipeline.mission.waypoints.iter().map(|waypoint| [waypoint.x_m, waypoint.y_m]))
        .collect();
    let legs = way.iter().zip(way.iter().skip(1));
    let straight_m: f64 = legs.map(|(a, b)| (b[0] - a[0]).hypot(b[1] - a[1])).sum();
    RunResult {
        end: outcome.reason.to_string(),
        detail: outcome.detail.clone(),
        start,
        goal: ready.pipeline.mission.waypoints.last().map(|waypoint| [waypoint.x_m, waypoint.y_m]),
        straight_m: (start.is_some() && straight_m > 0.0).then_some(straight_m),
        drawn: Vec::new(),
        as_expected: expect.map(|expect| failures(expect, &outcome).is_empty()),
        outcome: Some(outcome),
    }
}

fn first_message(refused: &Refused) -> String {
    let faults = refused.to_json();
    let first = faults.get(0);
    let word = |key: &str| first.and_then(|fault| fault.get(key)?.as_str()).unwrap_or("").to_owned();
    format!("{}: {}", word("path"), word("message"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_a_result_with_its_message() {
        let quiet = std::panic::take_hook();
        std::panic::set_hook(Box::new(|_| {}));
        let (plain, formatted) = (caught(|| panic!("a plug fell out")), caught(|| panic!("cell {}", 7)));
        std::panic::set_hook(quiet);
        assert_eq!((plain.end.as_str(), plain.detail.as_deref()), ("panicked", Some("a plug fell out")));
        assert_eq!(formatted.detail.as_deref(), Some("cell 7"));
        assert!(!plain.is_success());
    }
}
