//! The plugin that a law looks at: how it is built, and what it says of itself.

use super::law::Trouble;
use super::props::Props;
use super::turn::Turn;
use rumbo_core::map::Layer;
use rumbo_core::registry::{Built, Entry, Manifest, Stage};
use rumbo_core::robot::{Drive, DriveKind, Robot, SteeredWheel};
use rumbo_core::stages::{BuildContext, BuildError};
use std::sync::Arc;

/// A plugin with the keys that it is built with.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The plugin.
    pub entry: Arc<Entry>,
    /// Files that it may be given.
    pub props: Arc<Props>,
    keys: toml::Table,
    has_recording: bool,
}

impl Subject {
    /// Where every random stream begins.
    const SEED: u64 = 7;

    /// The plugin with these keys.
    pub fn new(entry: Arc<Entry>, keys: toml::Table, props: Arc<Props>) -> Subject {
        Subject { entry, props, keys, has_recording: false }
    }

    /// The same plugin with what it cannot be built without: the recording of a world, or a file of its own. Says
    /// which.
    pub fn settle(&self) -> Result<(Subject, String), Trouble> {
        let first = match self.built(&self.context()) {
            Ok(_) => return Ok((self.clone(), String::new())),
            Err(error) => error,
        };
        let recorded = Subject { has_recording: true, ..self.clone() };
        if recorded.props.recording().is_some() && recorded.built(&recorded.context()).is_ok() {
            return Ok((recorded, "in a world that plays a recording".into()));
        }
        let mut with_file = self.clone();
        let file = if self.entry.stage == Stage::MapBuilder {
            self.props.map(Turn::None)
        } else {
            self.props.recording()
        };
        if let Some(file) = file.filter(|_| first.path == "file") {
            with_file.keys.insert("file".into(), file.to_string_lossy().into_owned().into());
            if with_file.built(&with_file.context()).is_ok() {
                return Ok((with_file, "with a made-up `file`".into()));
            }
        }
        let dry = BuildContext { dry_run: true, ..self.context() };
        if self.built(&dry).is_ok() {
            // A check touches no device, and a device is not here where nobody has plugged it in.
            let why = format!("a check takes it, but it cannot be built here: {}", first.message);
            return Err(Trouble::not_applicable(why));
        }
        Err(self.explain(&first))
    }

    /// A plugin may need keys that nobody can guess; a default that it refuses itself is a fault.
    fn explain(&self, error: &BuildError) -> Trouble {
        let key = error.path.split(['.', '[']).next().unwrap_or_default();
        let is_empty = |value: &toml::Value| value.as_str().is_some_and(str::is_empty);
        let has_default = self.entry.source.defaults().get(key).is_some_and(|value| !is_empty(value));
        if key.is_empty() || has_default || self.keys.contains_key(key) {
            let found = format!("{}: {}", if key.is_empty() { "build" } else { &error.path }, error.message);
            return Trouble::broken(found, "a stage that is built from its defaults");
        }
        Trouble::not_applicable(format!(
            "it needs `{}` ({}); give it with --set {}=...",
            error.path, error.message, error.path
        ))
    }

    fn built(&self, context: &BuildContext) -> Result<Built, BuildError> {
        let configured = self
            .entry
            .source
            .parse(self.keys.clone())
            .map_err(|fault| BuildError::at(fault.path, fault.message))?;
        if let Some(fault) = configured.check().into_iter().next() {
            return Err(fault);
        }
        configured.build(context)
    }

    /// What it is built in.
    pub fn context(&self) -> BuildContext {
        let recording = if self.has_recording { self.props.recording() } else { None };
        BuildContext {
            robot: Arc::new(self.robot()),
            seed: Self::SEED,
            world_map: self.props.world(Turn::None),
            world_recording: recording,
            wanted_layers: self.manifest().gives_layers,
            ..BuildContext::bare(self.entry.stage.section())
        }
    }

    /// It reads what somebody recorded instead of what it is shown.
    pub fn has_recording(&self) -> bool {
        self.has_recording || self.keys.contains_key("file")
    }

    /// What it needs and gives.
    pub fn manifest(&self) -> Manifest {
        self.entry.source.parse(self.keys.clone()).map(|configured| configured.manifest()).unwrap_or_default()
    }

    /// All its parameters.
    pub fn parameters(&self) -> toml::Table {
        self.entry
            .source
            .parse(self.keys.clone())
            .map(|configured| configured.parameters())
            .unwrap_or_default()
    }

    /// The usual robot on the first of the drives that the plugin can steer.
    pub fn robot(&self) -> Robot {
        let drive = match self.manifest().drives.first() {
            Some(DriveKind::Tricycle) => Drive::Tricycle {
                wheelbase_m: 0.4,
                track_m: 0.36,
                max_steer_deg: 60.0,
                max_steer_rate_deg_s: 90.0,
                steered: SteeredWheel::Front,
            },
            Some(DriveKind::Omnidirectional) => Drive::Omnidirectional {},
            _ => return Robot::default(),
        };
        Robot { drive, ..Robot::default() }
    }

    /// The stage, built.
    pub fn build<T>(&self) -> Result<T, Trouble>
    where
        T: TryFrom<Built, Error = BuildError>,
    {
        self.build_in(&self.context())
    }

    /// The stage, built in a context of the law's own.
    pub fn build_in<T>(&self, context: &BuildContext) -> Result<T, Trouble>
    where
        T: TryFrom<Built, Error = BuildError>,
    {
        let built = self.built(context).and_then(T::try_from);
        built.map_err(|error| {
            let found = format!("{}: {}", error.path, error.message);
            Trouble::broken(found, "a stage that can be built several times")
        })
    }

    /// Layers beside these cannot be made up.
    pub fn needs_only(&self, layers: &[Layer]) -> Result<(), Trouble> {
        let needed = self.manifest().needs_layers;
        match needed.iter().find(|layer| !layers.contains(layer)) {
            None => Ok(()),
            Some(layer) => {
                let why = format!("it needs the layer {}, which is not made up here", layer.name());
                Err(Trouble::not_applicable(why))
            }
        }
    }

    /// Observations beside those of the made-up drive cannot be had.
    pub fn sees_enough(&self) -> Result<(), Trouble> {
        let groups = self.manifest().consumes;
        let is_made_up = |group: &&Vec<_>| group.iter().any(|kind| super::drive::KINDS.contains(kind));
        match groups.iter().find(|group| !is_made_up(group)) {
            None => Ok(()),
            Some(group) => {
                let names: Vec<&str> = group.iter().map(|kind| kind.name()).collect();
                let why = format!("it needs {}, which is not made up here", names.join(" or "));
                Err(Trouble::not_applicable(why))
            }
        }
    }
}
