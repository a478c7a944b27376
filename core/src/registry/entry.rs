//! One plugin as everybody sees it, wherever it comes from.

use super::{Manifest, Surroundings};
use crate::stages::{Avoider, BuildContext, BuildError, Localizer, MapBuilder, Planner, Sensor, Slam, World};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

/// The stages that plugins can fill.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Stage {
    /// Where the robot is.
    World,
    /// What it sees.
    Sensor,
    /// What it keeps.
    MapBuilder,
    /// Where it thinks it is.
    Localizer,
    /// Map and place at once.
    Slam,
    /// Which way to go.
    Planner,
    /// What to do now.
    Avoider,
}

impl Stage {
    /// All of them, in the order of the data.
    pub const ALL: [Stage; 7] = [
        Stage::World,
        Stage::Sensor,
        Stage::MapBuilder,
        Stage::Localizer,
        Stage::Slam,
        Stage::Planner,
        Stage::Avoider,
    ];

    /// Its section in a pipeline file.
    pub fn section(self) -> &'static str {
        match self {
            Stage::World => "world",
            Stage::Sensor => "sensor",
            Stage::MapBuilder => "map_builder",
            Stage::Localizer => "localizer",
            Stage::Slam => "slam",
            Stage::Planner => "planner",
            Stage::Avoider => "avoider",
        }
    }
}

/// A stage, built.
pub enum Built {
    /// A sensor.
    Sensor(Box<dyn Sensor>),
    /// A map builder.
    MapBuilder(Box<dyn MapBuilder>),
    /// A localizer.
    Localizer(Box<dyn Localizer>),
    /// A SLAM plugin.
    Slam(Box<dyn Slam>),
    /// A planner.
    Planner(Box<dyn Planner>),
    /// An avoider.
    Avoider(Box<dyn Avoider>),
    /// A world.
    World(Box<dyn World>),
}

macro_rules! built_from {
    ($($stage:ident),*) => { $(
        impl From<Box<dyn $stage>> for Built {
            fn from(stage: Box<dyn $stage>) -> Built {
                Built::$stage(stage)
            }
        }

        impl TryFrom<Built> for Box<dyn $stage> {
            type Error = BuildError;
            fn try_from(built: Built) -> Result<Self, BuildError> {
                match built {
                    Built::$stage(stage) => Ok(stage),
                    _ => Err(BuildError::at("plugin", "the plugin built a stage of another kind than it declares")),
                }
            }
        }
    )* };
}
built_from!(Sensor, MapBuilder, Localizer, Slam, Planner, Avoider, World);

/// A key of a plugin's section that cannot be understood.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParseFault {
    /// Key inside the section, such as `weights[2]`.
    pub path: String,
    /// What was found and what was expected.
    pub message: String,
}

/// A plugin with its parameters, ready to be built.
pub trait Configured: Send + Sync {
    /// What it needs and gives, with these parameters.
    fn manifest(&self) -> Manifest;
    /// Every impossible value at once.
    fn check(&self) -> Vec<BuildError>;
    /// Values that will hardly do what is expected of them; a library has none.
    fn doubts(&self, _surroundings: &Surroundings) -> Vec<BuildError> {
        Vec::new()
    }
    /// All parameters, defaults included.
    fn parameters(&self) -> toml::Table;
    /// Makes the stage.
    fn build(&self, context: &BuildContext) -> Result<Built, BuildError>;
}

/// Where an entry's knowledge comes from: this program, or a library.
pub trait EntrySource: Send + Sync {
    /// JSON schema of the parameters.
    fn schema(&self) -> serde_json::Value;
    /// All parameters at their defaults.
    fn defaults(&self) -> toml::Table;
    /// Reads the plugin's own keys of its section; stops at the first that it cannot understand.
    fn parse(&self, keys: toml::Table) -> Result<Box<dyn Configured>, ParseFault>;
}

/// A shared library, as it was loaded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LibraryInfo {
    /// The file, with links followed.
    pub path: PathBuf,
    /// SHA-256 of the file, in hexadecimal.
    pub sha256: String,
    /// Major and minor of the ABI that it was built with.
    pub abi: (u32, u32),
    /// Compiler and versions, in its own words.
    pub build_info: String,
}

/// One plugin.
pub struct Entry {
    /// The seat that it fills.
    pub stage: Stage,
    /// Its name in a pipeline.
    pub name: String,
    /// What it is, in one line.
    pub summary: String,
    /// Its version.
    pub version: String,
    /// The package or file that it comes from.
    pub origin: String,
    /// The library that it comes from; none where it is linked into this program.
    pub library: Option<Arc<LibraryInfo>>,
    /// The rest.
    pub source: Box<dyn EntrySource>,
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} {} ({})", self.stage.section(), self.name, self.version, self.origin)
    }
}
