//! The figures that alternatives are compared by.

use super::result::RunResult;
use crate::outcome::Outcome;

/// One figure of a run.
#[derive(Debug, Clone, Copy)]
pub struct Figure {
    /// In JSON and CSV.
    pub key: &'static str,
    /// For people.
    pub name: &'static str,
    /// Behind the number.
    pub unit: &'static str,
    /// What it is multiplied with for people.
    pub scale: f64,
    /// Digits behind the point for people.
    pub digits: usize,
    /// Only runs that succeeded have it.
    pub successes_only: bool,
    get: fn(&Outcome, &RunResult) -> Option<f64>,
}

impl Figure {
    /// Of one run.
    pub fn of(&self, result: &RunResult) -> Option<f64> {
        let outcome = result.outcome.as_ref()?;
        if self.successes_only && !result.is_success() {
            return None;
        }
        (self.get)(outcome, result).filter(|value| value.is_finite())
    }

    /// A value for people.
    pub fn show(&self, value: f64) -> String {
        format!("{:.*}", self.digits, value * self.scale)
    }
}

const fn figure(
    key: &'static str,
    (name, unit): (&'static str, &'static str),
    (scale, digits): (f64, usize),
    successes_only: bool,
    get: fn(&Outcome, &RunResult) -> Option<f64>,
) -> Figure {
    Figure { key, name, unit, scale, digits, successes_only, get }
}

/// All of them, in reading order. A way that was broken off is short and quick: time, way, detour and turns are of
/// runs that succeeded.
pub const FIGURES: [Figure; 17] = [
    figure("time_s", ("time to goal", "s"), (1.0, 1), true, |o, _| Some(o.time_s)),
    figure("path_m", ("way driven", "m"), (1.0, 2), true, |o, _| Some(o.path_m)),
    figure("detour", ("way over straight line", ""), (1.0, 3), true, |o, r| Some(o.path_m / r.straight_m?)),
    figure("turn_deg_m", ("turns per meter", "°/m"), (1.0, 1), true, |o, _| o.turn_deg_m),
    figure("min_clearance_m", ("least clearance", "cm"), (100.0, 1), false, |o, _| o.min_clearance_m),
    figure("contacts", ("contacts", ""), (1.0, 2), false, |o, _| o.contacts.map(f64::from)),
    figure("driven_contacts", ("contacts by driving", ""), (1.0, 2), false, |o, _| {
        o.driven_contacts.map(f64::from)
    }),
    figure("rms_error_m", ("position error, RMS", "cm"), (100.0, 2), false, |o, _| o.rms_error_m),
    figure("p95_error_m", ("position error, 95 %", "cm"), (100.0, 2), false, |o, _| o.p95_error_m),
    figure("rms_heading_error_deg", ("heading error, RMS", "°"), (1.0, 2), false, |o, _| {
        o.rms_heading_error_deg
    }),
    figure("goal_error_m", ("true end to goal", "cm"), (100.0, 2), true, |o, _| o.goal_error_m),
    figure("final_error_m", ("final error", "cm"), (100.0, 2), false, |o, _| o.final_error_m),
    figure("final_error_x_m", ("final error along x", "cm"), (100.0, 2), false, |o, _| o.final_error_x_m),
    figure("final_error_y_m", ("final error along y", "cm"), (100.0, 2), false, |o, _| o.final_error_y_m),
    figure("final_heading_error_deg", ("final heading error", "°"), (1.0, 2), false, |o, _| {
        o.final_heading_error_deg
    }),
    figure("saw_before_contact", ("saw it before contact", "%"), (100.0, 0), false, |o, _| {
        o.saw_before_contact().map(|saw| f64::from(u8::from(saw)))
    }),
    figure("replans", ("new plans", ""), (1.0, 2), false, |o, _| Some(f64::from(o.replans))),
];
