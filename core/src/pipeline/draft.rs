//! A pipeline on its way from the file: every section as far as it can be understood.

use super::own_sections::{Head, mission, robot, test};
use super::section::Section;
use super::{Mission, Pipeline, PipelineTest, Seat, SensorSpec, StageSpec, sensors};
use crate::document::{Fault, FaultCode, Faults, Node, item_path, join_path};
use crate::registry::Registry;
use crate::robot::Robot;
use std::path::Path;
use std::sync::Arc;

/// All sections, as far as they are understood.
#[derive(Debug, Clone, Default)]
pub(super) struct Draft {
    pub head: Head,
    pub robot: Robot,
    pub mission: Mission,
    pub tests: Vec<PipelineTest>,
    /// Sections with one plugin each, in the order of [`Seat::ALL`].
    pub singles: Vec<Section>,
    pub sensors: Vec<Section>,
    pub builders: Vec<Section>,
    /// In the order in which they run; none where one of them is not understood.
    pub arranged: Option<Vec<SensorSpec>>,
    /// Where `[mission]` is written.
    pub mission_node: Option<Node>,
    /// Where the tests are written.
    pub test_nodes: Vec<Node>,
}

impl Draft {
    pub fn read(root: &Node, head: Head, registry: &Registry, faults: &mut Faults) -> Draft {
        let mut draft = Draft {
            head,
            robot: robot(root.get("robot"), faults),
            mission: mission(root.get("mission"), faults),
            mission_node: root.get("mission").cloned(),
            ..Draft::default()
        };
        let items = list(root, "test", faults);
        draft.tests = items.iter().enumerate().filter_map(|(idx, item)| test(item, idx, faults)).collect();
        draft.test_nodes = items;
        draft.sensors = parts(root, Seat::Sensor, registry, faults);
        draft.builders = parts(root, Seat::MapBuilder, registry, faults);
        for seat in Seat::ALL {
            if matches!(seat, Seat::Sensor | Seat::MapBuilder) {
                continue;
            }
            if let Some(node) = root.get(seat.section()) {
                let (name, path) = (seat.section(), seat.section().to_owned());
                draft.singles.push(Section::parse(seat, name, path, node, registry, faults));
            }
        }
        refuse_same_names(&draft.sensors, &draft.builders, faults);
        draft.arranged = sensors::arranged(&draft.sensors, faults);
        draft
    }

    /// The section in this seat.
    pub fn single(&self, seat: Seat) -> Option<&Section> {
        self.singles.iter().find(|section| section.seat == seat)
    }

    /// Every section with a plugin, in no particular order.
    pub fn sections(&self) -> impl Iterator<Item = &Section> {
        self.singles.iter().chain(&self.sensors).chain(&self.builders)
    }

    /// The section of the stage with this name.
    pub fn section(&self, name: &str) -> Option<&Section> {
        self.sections().find(|section| section.spec.as_ref().is_some_and(|spec| spec.name == name))
    }

    /// Defaults of the sections that the framework itself reads, and of the keys outside sections.
    pub fn defaults(&self) -> toml::Table {
        let mut defaults = toml::Table::try_from(&self.head).unwrap_or_default();
        let mut add = |key: &str, table: Result<toml::Table, toml::ser::Error>| {
            defaults.insert(key.to_owned(), table.unwrap_or_default().into());
        };
        add("robot", toml::Table::try_from(&self.robot));
        add("mission", toml::Table::try_from(&self.mission));
        defaults
    }

    /// The pipeline, where nothing that it consists of is missing.
    pub fn pipeline(&self, folder: &Path) -> Option<Pipeline> {
        let all_understood = self.sections().all(|section| section.spec.is_some());
        let spec = |seat: Seat| -> Option<StageSpec> { self.single(seat)?.spec.clone() };
        let (localizer, slam) = (spec(Seat::Localizer), spec(Seat::Slam));
        if !all_understood || (localizer.is_none() && slam.is_none()) {
            return None;
        }
        Some(Pipeline {
            name: self.head.name.clone(),
            seed: self.head.seed,
            folder: folder.to_path_buf(),
            robot: Arc::new(self.robot.clone()),
            world: spec(Seat::World)?,
            duration_s: self.single(Seat::World).and_then(|world| world.reserved.duration_s),
            sensors: self.arranged.clone()?,
            odometer: spec(Seat::Odometer),
            map_builders: self.builders.iter().filter_map(|section| section.spec.clone()).collect(),
            localizer,
            relocalizer: spec(Seat::Relocalizer),
            slam,
            resume: self.single(Seat::Slam).and_then(|slam| slam.reserved.resume.clone()),
            planner: spec(Seat::Planner),
            planner_fallback: spec(Seat::PlannerFallback),
            avoider: spec(Seat::Avoider),
            mission: self.mission.clone(),
            tests: self.tests.clone(),
        })
    }
}

/// The tables of a list such as `[[sensor]]`.
fn list(root: &Node, key: &str, faults: &mut Faults) -> Vec<Node> {
    let Some(node) = root.get(key) else { return Vec::new() };
    if let Some(items) = node.as_array() {
        return items.to_vec();
    }
    let message = match node.as_table() {
        Some(_) => format!("is one table, expected a list: write [[{key}]] in double brackets"),
        None => format!("is {}, expected [[{key}]] with one table a part", node.shown()),
    };
    faults.push(Fault::new(FaultCode::WrongType, key, node.place(), message));
    // The one table is read all the same, so that its own faults show.
    node.as_table().map(|_| node.clone()).into_iter().collect()
}

/// Sections that there may be several of.
fn parts(root: &Node, seat: Seat, registry: &Registry, faults: &mut Faults) -> Vec<Section> {
    let key = seat.section();
    if let (Seat::MapBuilder, Some(node)) = (seat, root.get(key).filter(|node| node.as_table().is_some())) {
        return vec![Section::parse(seat, key, key.to_owned(), node, registry, faults)];
    }
    let items = list(root, key, faults);
    let mut sections = Vec::new();
    for (idx, item) in items.iter().enumerate() {
        let path = item_path(key, idx, item);
        let given = item.get("name").and_then(Node::as_str).filter(|name| !name.is_empty());
        let by_plugin = || item.get("plugin").and_then(Node::as_str).unwrap_or(key).to_owned();
        let name = match (given, seat) {
            (Some(name), _) => name.to_owned(),
            (None, Seat::MapBuilder) => by_plugin(),
            (None, _) => {
                // A name that is there but is no text is reported with the other keys.
                if item.get("name").is_none_or(|name| name.as_str().is_some()) {
                    let message = "is missing, expected the name of this sensor in quotes";
                    let place = item.place();
                    faults.push(Fault::new(FaultCode::MissingKey, join_path(&path, "name"), place, message));
                }
                format!("{key} {idx}")
            }
        };
        sections.push(Section::parse(seat, &name, path, item, registry, faults));
    }
    sections
}

/// Names tell random streams, messages and events apart.
fn refuse_same_names(sensors: &[Section], builders: &[Section], faults: &mut Faults) {
    let mut earlier: Vec<(&str, &Section)> = Vec::new();
    for section in sensors.iter().chain(builders) {
        let Some(name) = section.spec.as_ref().map(|spec| spec.name.as_str()) else { continue };
        let place = section.node.get("name").map_or(section.node.place(), |name| name.origin);
        let path = join_path(&section.path, "name");
        if section.seat == Seat::Sensor && Seat::ALL.iter().any(|seat| seat.section() == name) {
            let message = format!("is \"{name}\", which is the name of a section; choose another");
            faults.push(Fault::new(FaultCode::DuplicateName, path, place, message));
        } else if let Some((_, first)) = earlier.iter().find(|(other, _)| *other == name) {
            let message = format!("two parts are called \"{name}\", rename one");
            let fault = Fault::new(FaultCode::DuplicateName, path, place, message);
            faults.push(fault.note("the first is here", first.node.place()));
        }
        earlier.push((name, section));
    }
}
