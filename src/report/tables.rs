//! The figures and lists of a report.

use crate::outcome::Outcome;
use crate::picture::escape;
use crate::record::RunRecord;
use rumbo_core::engine::Part;
use std::fmt::Write as _;

/// A figure with its name, as people read it.
pub struct Figure {
    /// What it is.
    pub name: &'static str,
    /// How much.
    pub value: String,
    /// It deserves attention.
    pub is_trouble: bool,
}

/// The figures of a run in reading order; what nobody knows is left out.
pub fn figures(outcome: &Outcome) -> Vec<Figure> {
    let mut figures = Vec::new();
    let mut add = |name, value: Option<String>, is_trouble| {
        figures.extend(value.map(|value| Figure { name, value, is_trouble }));
    };
    let meters = |m: Option<f64>| m.map(|m| format!("{m:.3} m"));
    add("result", Some(outcome.reason.to_string().replace('_', " ")), !outcome.is_success());
    add("time", Some(format!("{:.1} s", outcome.time_s)), false);
    add("way driven", Some(format!("{:.2} m", outcome.path_m)), false);
    add("true end to goal", meters(outcome.goal_error_m), false);
    add("final error", meters(outcome.final_error_m), false);
    add("final heading error", outcome.final_heading_error_deg.map(|d| format!("{d:.2}°")), false);
    add("rms error", meters(outcome.rms_error_m), false);
    add("95 % of errors below", meters(outcome.p95_error_m), false);
    add(
        "least clearance",
        meters(outcome.min_clearance_m),
        outcome.min_clearance_m.is_some_and(|m| m <= 0.0),
    );
    add("contacts", outcome.contacts.map(|n| n.to_string()), outcome.contacts.is_some_and(|n| n > 0));
    let driven = outcome.driven_contacts;
    add("contacts by driving", driven.map(|n| n.to_string()), driven.is_some_and(|n| n > 0));
    add(
        "sure of the place",
        outcome.tracked_share.map(|share| format!("{:.0} % of the time", share * 100.0)),
        false,
    );
    add("new plans", Some(outcome.replans.to_string()), false);
    add("guard stepped in", Some(times(outcome.guard_interventions)), false);
    add("stage failures", Some(outcome.stage_failures.to_string()), outcome.stage_failures > 0);
    add("faster than real time", outcome.realtime_factor.map(|f| format!("{f:.0} x")), false);
    figures
}

fn times(n: u32) -> String {
    match n {
        0 => "never".into(),
        1 => "once".into(),
        n => format!("{n} times"),
    }
}

/// The figures as a list of tiles.
pub fn tiles(outcome: &Outcome) -> String {
    let mut html = String::from("<dl class=\"tiles\">\n");
    for figure in figures(outcome) {
        let class = if figure.is_trouble { " class=\"trouble\"" } else { "" };
        let _ =
            writeln!(html, "<div{class}><dt>{}</dt><dd>{}</dd></div>", figure.name, escape(&figure.value));
    }
    html.push_str("</dl>\n");
    html
}

/// Time used by each part of the steps, as bars.
pub fn cpu_table(outcome: &Outcome) -> String {
    let most = Part::ALL.into_iter().map(|part| outcome.cpu_s(part)).fold(1e-12, f64::max);
    let mut html = String::from(
        "<table class=\"cpu\"><thead><tr><th>stage</th><th>time</th><th>per second of robot time</th></tr></thead><tbody>\n",
    );
    for part in Part::ALL {
        let seconds = outcome.cpu_s(part);
        let (name, width) = (part.name().replace('_', " "), seconds / most * 100.0);
        let per_second = seconds / outcome.time_s.max(1e-9) * 1e6;
        let _ = writeln!(
            html,
            "<tr><td>{name}</td><td>{:.1} ms</td><td><span class=\"bar\" style=\"width:{width:.0}%\"></span>\
             <span class=\"over\">{per_second:.0} µs</span></td></tr>",
            seconds * 1e3
        );
    }
    html.push_str("</tbody></table>\n");
    html
}

/// What happened, with times.
pub fn event_table(record: &RunRecord) -> String {
    if record.events.is_empty() {
        return "<p>Nothing happened.</p>\n".into();
    }
    let mut html = String::from("<div class=\"scroll\"><table class=\"events\"><tbody>\n");
    for event in &record.events {
        let class = if event.is_trouble { " class=\"trouble\"" } else { "" };
        let _ =
            writeln!(html, "<tr{class}><td>{:.2} s</td><td>{}</td></tr>", event.time_s, escape(&event.text));
    }
    html.push_str("</tbody></table></div>\n");
    if record.n_events_left_out > 0 {
        let _ = writeln!(html, "<p>… and {} more.</p>", record.n_events_left_out);
    }
    html
}
