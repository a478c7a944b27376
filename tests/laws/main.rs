//! Every plugin of the shipped registry keeps the laws of its stage, and plugins that break a law are told.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../boundary/alone.rs"]
mod alone;
mod doubles;
mod shipped;
mod spoiled_planners;
mod spoiled_stages;

use rumbo::laws::{Finding, Outcome, PluginReport, verify};
use rumbo_core::registry::{Entry, Registry, Stage};
use std::sync::Arc;

/// A plugin that is shipped.
fn shipped(stage: Stage, name: &str) -> Arc<Entry> {
    rumbo::registry().unwrap().get(stage, name).unwrap().clone()
}

fn registry() -> Registry {
    rumbo::registry().unwrap()
}

/// What the laws say of one plugin.
fn report(entry: Entry) -> PluginReport {
    let entry = Arc::new(entry);
    verify(std::iter::once(&entry)).plugins.remove(0)
}

/// The laws that a plugin breaks, in the order of the report.
fn broken(report: &PluginReport) -> Vec<&'static str> {
    report.broken().map(|finding| finding.law).collect()
}

/// The plugin breaks these laws and no other.
fn breaks(entry: Entry, laws: &[&str]) {
    let report = report(entry);
    assert_eq!(broken(&report), laws, "{}", told(report.broken()));
}

/// For people.
fn told<'f>(findings: impl Iterator<Item = &'f Finding>) -> String {
    let line = |finding: &Finding| match &finding.outcome {
        Outcome::Fail { found, expected } => format!("{}: found {found}, expected {expected}", finding.law),
        other => format!("{}: {other:?}", finding.law),
    };
    findings.map(line).collect::<Vec<_>>().join("\n")
}
