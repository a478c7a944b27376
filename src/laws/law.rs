//! One law, and what a plugin can answer to it.

use super::subject::Subject;
use rumbo_core::map::GridFault;
use std::time::Duration;

/// One law.
#[derive(Debug)]
pub struct Law {
    /// What every plugin does, as a sentence.
    pub name: &'static str,
    /// How exactly it is meant; empty where there is nothing to measure.
    pub tolerance: &'static str,
    /// Asks one plugin.
    pub check: fn(&Subject) -> Verdict,
    /// Waits this long for the answer and no longer. Decides nothing else.
    pub patience: Duration,
}

impl Law {
    /// Generous for everything that is called a few times.
    pub const PATIENCE: Duration = Duration::from_secs(60);
    /// Generous for ten thousand calls.
    pub const LONG_PATIENCE: Duration = Duration::from_secs(600);

    /// A law without a tolerance.
    pub const fn new(name: &'static str, check: fn(&Subject) -> Verdict) -> Law {
        Law { name, tolerance: "", check, patience: Self::PATIENCE }
    }

    /// The same within a tolerance.
    pub const fn within(mut self, tolerance: &'static str) -> Law {
        self.tolerance = tolerance;
        self
    }

    /// The same with ten times the patience.
    pub const fn long(mut self) -> Law {
        self.patience = Self::LONG_PATIENCE;
        self
    }
}

/// A law that is kept says what was found; an empty text where there is nothing to add.
pub type Verdict = Result<String, Trouble>;

/// Why a law is not kept.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Trouble {
    /// The plugin breaks it.
    Broken {
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

impl Trouble {
    /// The plugin breaks the law.
    pub fn broken(found: impl Into<String>, expected: impl Into<String>) -> Trouble {
        Trouble::Broken { found: found.into(), expected: expected.into() }
    }

    /// Nobody can tell.
    pub fn not_applicable(why: impl Into<String>) -> Trouble {
        Trouble::NotApplicable { why: why.into() }
    }
}

impl From<GridFault> for Trouble {
    fn from(fault: GridFault) -> Trouble {
        Trouble::not_applicable(format!("the law's own map cannot be made: {fault}"))
    }
}

/// Goes on if it is so.
pub fn expect(
    is_so: bool,
    found: impl FnOnce() -> String,
    expected: impl Into<String>,
) -> Result<(), Trouble> {
    if is_so { Ok(()) } else { Err(Trouble::broken(found(), expected)) }
}
