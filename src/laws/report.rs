//! What was found, plugin by plugin and law by law.

use super::law::{Law, Trouble, Verdict};
use super::runner::Ended;
use rumbo_core::registry::Entry;
use serde::Serialize;

/// The laws of several plugins.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    /// One report each, in the order of asking.
    pub plugins: Vec<PluginReport>,
}

/// The laws of one plugin.
#[derive(Debug, Clone, Serialize)]
pub struct PluginReport {
    /// Its section in a pipeline.
    pub stage: &'static str,
    /// Its name in a pipeline.
    pub name: String,
    /// Its version.
    pub version: String,
    /// The package or file that it comes from.
    pub origin: String,
    /// One law each.
    pub findings: Vec<Finding>,
}

/// What a plugin answered to one law.
#[derive(Debug, Clone, Serialize)]
pub struct Finding {
    /// The law.
    pub law: &'static str,
    /// How exactly it is meant.
    #[serde(skip_serializing_if = "str::is_empty")]
    pub tolerance: &'static str,
    /// What became of it.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// What became of a law.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum Outcome {
    /// It is kept.
    Pass {
        /// What was measured; may be empty.
        found: String,
    },
    /// It is broken.
    Fail {
        /// What the plugin did.
        found: String,
        /// What it should have done.
        expected: String,
    },
    /// Nobody can tell.
    NotApplicable {
        /// Why.
        why: String,
    },
}

impl Finding {
    pub(super) fn of(law: &'static Law, ended: Result<Verdict, Ended>) -> Finding {
        let outcome = match ended {
            Ok(Ok(found)) => Outcome::Pass { found: one_line(&found) },
            Ok(Err(Trouble::Broken { found, expected })) => {
                Outcome::Fail { found: one_line(&found), expected: one_line(&expected) }
            }
            Ok(Err(Trouble::NotApplicable { why })) => Outcome::NotApplicable { why: one_line(&why) },
            Err(Ended::Panicked(message)) => Outcome::Fail {
                found: format!("it panicked: {message}"),
                expected: "an answer or an error".into(),
            },
            Err(Ended::Hung(patience)) => Outcome::Fail {
                found: format!("it did not come back within {} s", patience.as_secs()),
                expected: "an answer or an error".into(),
            },
            Err(Ended::NoThread(reason)) => {
                Outcome::NotApplicable { why: format!("there is no thread to try it on: {reason}") }
            }
        };
        Finding { law: law.name, tolerance: law.tolerance, outcome }
    }

    pub(super) fn not_applicable(law: &'static Law, why: impl Into<String>) -> Finding {
        let outcome = Outcome::NotApplicable { why: why.into() };
        Finding { law: law.name, tolerance: law.tolerance, outcome }
    }

    /// The plugin breaks this law.
    pub fn is_broken(&self) -> bool {
        matches!(self.outcome, Outcome::Fail { .. })
    }
}

/// Errors of plugins may have several lines.
fn one_line(words: &str) -> String {
    words.split_whitespace().collect::<Vec<_>>().join(" ")
}

impl PluginReport {
    pub(super) fn new(entry: &Entry) -> PluginReport {
        PluginReport {
            stage: entry.stage.section(),
            name: entry.name.clone(),
            version: entry.version.clone(),
            origin: entry.origin.clone(),
            findings: Vec::new(),
        }
    }

    /// The laws that it breaks.
    pub fn broken(&self) -> impl Iterator<Item = &Finding> {
        self.findings.iter().filter(|finding| finding.is_broken())
    }
}

impl Report {
    /// No plugin breaks a law.
    pub fn is_good(&self) -> bool {
        self.plugins.iter().all(|plugin| plugin.broken().next().is_none())
    }

    /// How many laws are kept, broken, not applicable.
    pub fn tally(&self) -> [usize; 3] {
        let mut tally = [0; 3];
        for finding in self.plugins.iter().flat_map(|plugin| &plugin.findings) {
            let kind = match finding.outcome {
                Outcome::Pass { .. } => 0,
                Outcome::Fail { .. } => 1,
                Outcome::NotApplicable { .. } => 2,
            };
            tally[kind] += 1;
        }
        tally
    }
}
