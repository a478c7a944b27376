//! From a pipeline file to a pipeline, with every fault of the file.

use super::doubts::doubts;
use super::draft::Draft;
use super::libraries::with_libraries;
use super::own_sections::head;
use super::{Pipeline, RecordTo, fits};
use crate::document::{Document, Fault, FaultCode, Faults, Node, NodeValue, fill_defaults, join_path};
use crate::engine::Engine;
use crate::registry::Registry;
use crate::stages::BuildError;
use std::path::Path;

/// What came out of a pipeline file.
#[derive(Debug, Clone)]
pub struct Loaded {
    /// The file as text: places and origins.
    pub document: Document,
    /// Everything that is wrong, sorted by place.
    pub faults: Faults,
    /// What is possible, but will hardly do what is expected of it, sorted by place.
    pub warnings: Faults,
    /// The pipeline; none where so much is wrong that there is none.
    pub pipeline: Option<Pipeline>,
    /// Everything that this pipeline can name: what the program has, and the libraries of `plugin_path`.
    pub registry: Registry,
    /// Where to record the run (`record`): a file as seen from here.
    pub record: Option<RecordTo>,
    draft: Draft,
}

impl Loaded {
    /// Reads the file `path` with the `--set` arguments `sets`, and proves that its parts fit together. Touches no
    /// file but those that it includes; [`check`](Self::check) looks further.
    pub fn read(path: &Path, sets: &[String], registry: &Registry) -> Loaded {
        let (document, faults) = Document::load(path, sets);
        Loaded::from_document(document, faults, path, registry)
    }

    /// As [`read`](Self::read) for a text that is not in a file; `path` is shown in messages, and its folder is where
    /// relative paths start.
    pub fn from_text(path: &Path, text: &str, sets: &[String], registry: &Registry) -> Loaded {
        let (document, faults) = Document::from_text(path, text, sets);
        Loaded::from_document(document, faults, path, registry)
    }

    fn from_document(document: Document, mut faults: Faults, path: &Path, registry: &Registry) -> Loaded {
        // Of a file that cannot be read, or is no TOML, nothing more can be said that helps.
        let is_unreadable = |fault: &Fault| {
            matches!(fault.code, FaultCode::Syntax | FaultCode::File | FaultCode::RecursiveInclude)
        };
        let is_readable = !faults.iter().any(is_unreadable);
        let (mut draft, mut registry) = (Draft::default(), registry.clone());
        let folder = path.parent().unwrap_or(Path::new(""));
        if is_readable {
            let head = head(&document.root, path, &mut faults);
            registry = with_libraries(&document.root, &head, folder, &registry, &mut faults);
            draft = Draft::read(&document.root, head, &registry, &mut faults);
            fits::check(&draft, &registry, &mut faults);
        }
        let pipeline = draft.pipeline(folder);
        let record = draft.head.record.as_ref().map(|record| match record {
            RecordTo::File(path) => RecordTo::File(folder.join(path)),
            RecordTo::Usual(is_wanted) => RecordTo::Usual(*is_wanted),
        });
        faults.sort();
        let warnings = doubts(&draft);
        Loaded { document, faults, warnings, pipeline, registry, record, draft }
    }

    /// Builds every stage without touching a device, so that missing files, broken maps, a start inside a wall or a
    /// goal outside the map come to light.
    pub fn check(&mut self) {
        let Some(pipeline) = &self.pipeline else { return };
        let mut found = Faults::default();
        // A stage whose section is wrong would only say so again in other words.
        let is_sound = |name: &str| self.draft.section(name).is_none_or(|section| section.is_sound);
        let (errors, engine) = Engine::build_faults(pipeline, is_sound);
        for error in &errors {
            found.push(self.build_fault(&error.section, &error.error));
        }
        for fault in engine.iter().flat_map(|engine| engine.waypoint_faults()) {
            let path = format!("mission.waypoints[{}]", fault.index);
            let place = self.document.root.nearest(&path).origin;
            found.push(Fault::new(FaultCode::Place, path, place, fault.message));
        }
        self.faults.extend(found);
        self.faults.sort();
    }

    /// The pipeline, if nothing is wrong at all.
    pub fn sound(&self) -> Option<&Pipeline> {
        self.pipeline.as_ref().filter(|_| self.faults.is_empty())
    }

    /// One line a fault: file, line, column, path, message.
    pub fn lines(&self) -> Vec<String> {
        self.faults.lines(&self.document.sources)
    }

    /// The document as it takes effect: with all defaults, and with the variants that apply laid into their sections.
    pub fn effective(&self) -> Node {
        let mut root = self.document.root.clone();
        let Some(table) = root.as_table_mut() else { return root };
        for section in self.draft.sections() {
            let mut node = section.node.clone();
            if let Some(spec) = &section.spec {
                fill_defaults(&mut node, &spec.configured.parameters());
            }
            replace(table, &section.path, &self.document.root, node);
        }
        fill_defaults(&mut root, &self.draft.defaults());
        root
    }
}

/// Puts a section back where it came from.
fn replace(table: &mut crate::document::Table, path: &str, original: &Node, node: Node) {
    let top = path.split(['.', '[']).next().unwrap_or(path);
    let Some(old) = table.get_mut(top) else { return };
    match (&mut old.value, original.get(top).and_then(Node::as_array)) {
        (NodeValue::Array(items), Some(originals)) => {
            let same = |(idx, item): (usize, &Node)| crate::document::item_path(top, idx, item) == path;
            if let Some(idx) = originals.iter().enumerate().position(same) {
                items[idx] = node;
            }
        }
        _ => *old = node,
    }
}

impl Loaded {
    /// What a plugin, or the mission, said when it was built, at its place in the file.
    fn build_fault(&self, name: &str, error: &BuildError) -> Fault {
        if let Some(section) = self.draft.section(name) {
            return section.plugin_fault(error);
        }
        let path = join_path(name, &error.path);
        let place = self.document.root.nearest(&path).origin;
        Fault::new(FaultCode::Plugin, path, place, error.message.clone())
    }
}
