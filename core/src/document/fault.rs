//! What is wrong with a document, and where.

use super::source::{Origin, Sources};
use serde::Serialize;
use std::fmt::Write;

/// The kind of a fault: a stable word for machines and for the help page.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum FaultCode {
    /// The text is not TOML.
    Syntax,
    /// A file cannot be read.
    File,
    /// A file includes itself.
    RecursiveInclude,
    /// A `--set` argument cannot be applied.
    Set,
    /// Nobody knows this key.
    UnknownKey,
    /// A key that must be there is not.
    MissingKey,
    /// A value of another type than expected.
    WrongType,
    /// A value that cannot be.
    BadValue,
    /// NaN or infinity.
    NotFinite,
    /// No plugin of this stage has this name.
    UnknownPlugin,
    /// A library with plugins cannot be loaded.
    Library,
    /// A plugin refuses its parameters.
    Plugin,
    /// A rate that nobody can keep.
    Rate,
    /// Two parts of the pipeline have the same name.
    DuplicateName,
    /// A name that nothing in the pipeline has.
    UnknownName,
    /// Sensors that wait for each other.
    Cycle,
    /// Two parts of the pipeline claim the same seat.
    TwoOwners,
    /// A part that the pipeline cannot do without.
    MissingPart,
    /// A map layer that a stage needs and nobody gives.
    MissingLayer,
    /// An observation that a stage needs and no sensor makes.
    MissingObservation,
    /// A drive that a plugin cannot steer.
    Drive,
    /// A place where the robot cannot be.
    Place,
    /// A value that is possible, but will hardly do what is expected of it: a warning.
    Doubtful,
}

impl FaultCode {
    /// The word.
    pub fn name(self) -> &'static str {
        use FaultCode::*;
        match self {
            Syntax => "syntax",
            File => "file",
            RecursiveInclude => "recursive_include",
            Set => "set",
            UnknownKey => "unknown_key",
            MissingKey => "missing_key",
            WrongType => "wrong_type",
            BadValue => "bad_value",
            NotFinite => "not_finite",
            UnknownPlugin => "unknown_plugin",
            Library => "library",
            Plugin => "plugin",
            Rate => "rate",
            DuplicateName => "duplicate_name",
            UnknownName => "unknown_name",
            Cycle => "cycle",
            TwoOwners => "two_owners",
            MissingPart => "missing_part",
            MissingLayer => "missing_layer",
            MissingObservation => "missing_observation",
            Drive => "drive",
            Place => "place",
            Doubtful => "doubtful",
        }
    }
}

/// Another place that helps to understand a fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// What is there.
    pub message: String,
    /// Where.
    pub origin: Origin,
}

/// One fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// What kind of fault.
    pub code: FaultCode,
    /// What was found, what was expected; reads on from the path.
    pub message: String,
    /// Full key, such as `planner.weights[2]`; empty for the file itself.
    pub path: String,
    /// Where; none where the fault is that something is not there at all.
    pub origin: Option<Origin>,
    /// What to do.
    pub help: Option<String>,
    /// Other places that matter.
    pub notes: Vec<Note>,
}

impl Fault {
    /// A fault at a place.
    pub fn new(
        code: FaultCode,
        path: impl Into<String>,
        origin: impl Into<Option<Origin>>,
        message: impl Into<String>,
    ) -> Fault {
        Fault {
            code,
            message: message.into(),
            path: path.into(),
            origin: origin.into(),
            help: None,
            notes: Vec::new(),
        }
    }

    /// The same with advice.
    pub fn help(mut self, help: impl Into<String>) -> Fault {
        self.help = Some(help.into());
        self
    }

    /// The same with another place.
    pub fn note(mut self, message: impl Into<String>, origin: Origin) -> Fault {
        self.notes.push(Note { message: message.into(), origin });
        self
    }

    /// One line: `office.toml:31:1 planner.prefered_clearance_m: unknown key, did you mean preferred_clearance_m?`
    pub fn line(&self, sources: &Sources) -> String {
        let mut line = String::new();
        if let Some(source) = self.origin.and_then(|origin| sources.get(origin.source)) {
            let _ = write!(line, "{source}:");
        }
        if let Some((row, column)) = self.origin.and_then(|origin| sources.line_column(origin)) {
            let _ = write!(line, "{row}:{column} ");
        }
        if !self.path.is_empty() {
            let _ = write!(line, "{}: ", self.path);
        }
        line.push_str(&self.message);
        if let Some(help) = &self.help {
            let _ = write!(line, "; {help}");
        }
        line
    }

    /// For machines.
    pub fn to_json(&self, sources: &Sources) -> serde_json::Value {
        let place = |origin: Option<Origin>| {
            let origin = origin?;
            let (line, column) = sources.line_column(origin)?;
            let file = sources.get(origin.source)?.to_string();
            Some(serde_json::json!({ "file": file, "line": line, "column": column,
                "start": origin.start, "end": origin.end }))
        };
        let notes: Vec<_> = self
            .notes
            .iter()
            .map(|note| serde_json::json!({ "message": note.message, "place": place(Some(note.origin)) }))
            .collect();
        serde_json::json!({
            "code": self.code.name(), "path": self.path, "message": self.message, "help": self.help,
            "place": place(self.origin), "notes": notes,
        })
    }
}

/// All faults found so far.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Faults {
    list: Vec<Fault>,
}

impl Faults {
    /// Adds a fault; a second one of the same words at the same place is dropped.
    pub fn push(&mut self, fault: Fault) {
        if !self.list.contains(&fault) {
            self.list.push(fault);
        }
    }

    /// Adds many.
    pub fn extend(&mut self, other: Faults) {
        other.list.into_iter().for_each(|fault| self.push(fault));
    }

    /// Nothing is wrong.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// In the order found, or sorted.
    pub fn iter(&self) -> impl Iterator<Item = &Fault> {
        self.list.iter()
    }

    /// Something is wrong at this path or below.
    pub fn any_below(&self, path: &str) -> bool {
        self.list.iter().any(|fault| is_below(&fault.path, path))
    }

    /// Sorts by file and place; what has no place comes last.
    pub fn sort(&mut self) {
        self.list.sort_by(|a, b| {
            let key = |fault: &Fault| (fault.origin.is_none(), fault.origin);
            key(a).cmp(&key(b)).then_with(|| a.path.cmp(&b.path)).then_with(|| a.message.cmp(&b.message))
        });
    }

    /// One line a fault.
    pub fn lines(&self, sources: &Sources) -> Vec<String> {
        self.list.iter().map(|fault| fault.line(sources)).collect()
    }
}

/// `path` is `parent`, or lies below it.
pub(super) fn is_below(path: &str, parent: &str) -> bool {
    path.strip_prefix(parent).is_some_and(|rest| {
        rest.is_empty() || parent.is_empty() || rest.starts_with('.') || rest.starts_with('[')
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::document::source::SourceName;

    #[test]
    fn a_line_says_place_path_message_and_help() {
        let mut sources = Sources::default();
        let source = sources.add(SourceName::File("a.toml".into()), "x = 1\ny = 2\n");
        let fault = Fault::new(FaultCode::BadValue, "y", Origin { source, start: 10, end: 11 }, "is 2");
        assert_eq!(fault.line(&sources), "a.toml:2:5 y: is 2");
        assert_eq!(fault.help("take 3").line(&sources), "a.toml:2:5 y: is 2; take 3");
        let nowhere = Fault::new(FaultCode::MissingPart, "", None, "no world");
        assert_eq!(nowhere.line(&sources), "no world");
    }

    #[test]
    fn faults_are_sorted_by_place_and_said_once() {
        let mut sources = Sources::default();
        let source = sources.add(SourceName::File("a.toml".into()), "x = 1\ny = 2\n");
        let at = |start| Origin { source, start, end: start + 1 };
        let mut faults = Faults::default();
        faults.push(Fault::new(FaultCode::MissingPart, "", None, "nowhere"));
        for start in [6, 0, 6] {
            faults.push(Fault::new(FaultCode::BadValue, "", at(start), "bad"));
        }
        faults.sort();
        assert_eq!(faults.lines(&sources), ["a.toml:1:1 bad", "a.toml:2:1 bad", "nowhere"]);
    }

    #[test]
    fn below_means_the_same_key_or_deeper_never_a_longer_word() {
        assert!(is_below("planner.weights[2]", "planner"));
        assert!(is_below("planner", "planner") && is_below("anything", ""));
        assert!(!is_below("planner_fallback.x", "planner"));
    }

    #[test]
    fn every_code_has_the_name_that_machines_read() {
        for code in [FaultCode::UnknownKey, FaultCode::TwoOwners, FaultCode::MissingObservation] {
            assert_eq!(serde_json::to_value(code).unwrap(), code.name());
        }
    }
}
