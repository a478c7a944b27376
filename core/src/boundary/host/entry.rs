//! A library's entry as the registry sees it: the same traits as a plugin that is linked into the program.
#![allow(unsafe_code)]

use super::super::abi::*;
use super::super::convert::{RobotLoan, manifest_from, manifest_of, read, string_from, text_in};
use super::super::status::Crosses;
use super::avoider::DynAvoider;
use super::call::{Instance, Kept, Pushed, Who, push_bytes};
use super::callbacks::HOST;
use super::config::{Config, fits_schema};
use super::localizer::DynLocalizer;
use super::map_builder::DynMapBuilder;
use super::module::Record;
use super::paths::Paths;
use super::planner::DynPlanner;
use super::sensor::DynSensor;
use super::slam::DynSlam;
use crate::registry::{Built, Configured, Entry, EntrySource, LibraryInfo, Manifest, ParseFault, Stage};
use crate::stages::{BuildContext, BuildError};
use std::ffi::c_void;
use std::sync::Arc;

/// The registry entry of a library's entry.
pub(super) fn entry(record: Record, library: &Arc<LibraryInfo>) -> Entry {
    let origin = library.path.display().to_string();
    let who = Who { name: record.name.clone(), origin: origin.clone() };
    Entry {
        stage: record.stage,
        name: record.name.clone(),
        summary: record.summary.clone(),
        version: record.version.clone(),
        origin,
        library: Some(library.clone()),
        source: Box::new(Source { record: Arc::new(record), who }),
    }
}

/// Faults of one section at most.
const MOST_FAULTS: usize = 1000;

struct Source {
    record: Arc<Record>,
    who: Who,
}

impl EntrySource for Source {
    fn schema(&self) -> serde_json::Value {
        self.record.schema.clone()
    }

    fn defaults(&self) -> toml::Table {
        self.record.defaults.clone()
    }

    fn parse(&self, keys: toml::Table) -> Result<Box<dyn Configured>, ParseFault> {
        fits_schema(&self.record, &keys)?;
        let config = Config::new(&keys, &self.record.defaults);
        let faults = self.check(&config)?;
        let manifest = self.manifest(&config)?;
        let parameters = self.parameters(&config)?;
        let (record, who) = (self.record.clone(), self.who.clone());
        Ok(Box::new(Ready { record, who, config, faults, manifest, parameters }))
    }
}

impl Source {
    /// What one of the entry's own functions says.
    fn ask(
        &self,
        config: &Config,
        function: impl FnOnce(*const rumbo_entry, *const rumbo_config, *mut rumbo_error) -> i32,
    ) -> Result<(), ParseFault> {
        let view = config.lend();
        let mut error = rumbo_error::none();
        match function(self.record.at, &raw const view, &raw mut error) {
            RUMBO_OK => Ok(()),
            RUMBO_BAD_CONFIG => {
                Err(ParseFault { path: text_in(&error.path), message: error.words(RUMBO_BAD_CONFIG) })
            }
            code => Err(ParseFault {
                path: String::new(),
                message: format!("{} failed to read its parameters: {}", self.who, error.words(code)),
            }),
        }
    }

    fn check(&self, config: &Config) -> Result<Vec<BuildError>, ParseFault> {
        let mut faults: Vec<BuildError> = Vec::new();
        let Some(check) = self.record.entry.check else { return Ok(faults) };
        let mut out = rumbo_fault_out {
            size: size_of::<rumbo_fault_out>(),
            ctx: std::ptr::from_mut(&mut faults).cast(),
            push: Some(push_fault),
        };
        // SAFETY: a function of the library, with views that live until it returns.
        self.ask(config, |entry, config, error| unsafe { check(entry, config, &raw mut out, error) })?;
        Ok(faults)
    }

    fn manifest(&self, config: &Config) -> Result<Manifest, ParseFault> {
        let mut view = manifest_of(&Manifest::default());
        if let Some(manifest) = self.record.entry.manifest {
            // SAFETY: as above.
            self.ask(config, |entry, config, error| unsafe {
                manifest(entry, config, &raw mut view, error)
            })?;
        }
        let bad = |bad: super::super::convert::BadView| ParseFault { path: String::new(), message: bad.0 };
        manifest_from(&view).map_err(bad)
    }

    fn parameters(&self, config: &Config) -> Result<toml::Table, ParseFault> {
        let Some(parameters) = self.record.entry.parameters else { return Ok(config.all()) };
        let mut bytes = Pushed::<u8>::new();
        let size = size_of::<rumbo_bytes_out>();
        let mut out = rumbo_bytes_out { size, ctx: bytes.begin(), push: Some(push_bytes) };
        // SAFETY: as above.
        self.ask(config, |entry, config, error| unsafe { parameters(entry, config, &raw mut out, error) })?;
        let wrong = |why: String| ParseFault { path: String::new(), message: format!("{} {why}", self.who) };
        if let Some(fault) = bytes.fault("parameters") {
            return Err(wrong(format!("gave {fault}")));
        }
        let text = String::from_utf8(bytes.items)
            .map_err(|_| wrong("gave parameters that are no UTF-8".to_owned()))?;
        toml::from_str(&text).map_err(|e| wrong(format!("gave parameters that are no TOML: {}", e.message())))
    }
}

unsafe extern "C" fn push_fault(ctx: *mut c_void, path: rumbo_str, message: rumbo_str, help: rumbo_str) {
    // SAFETY: the context of a `check` that has not returned, and texts of the plugin.
    unsafe {
        let Some(faults) = ctx.cast::<Vec<BuildError>>().as_mut() else { return };
        let fault = BuildError::at(string_from(path), string_from(message));
        let help = string_from(help);
        // Nobody reads more of them.
        if faults.len() >= MOST_FAULTS {
            return;
        }
        faults.push(if help.is_empty() { fault } else { fault.help(help) });
    }
}

struct Ready {
    record: Arc<Record>,
    who: Who,
    config: Config,
    faults: Vec<BuildError>,
    manifest: Manifest,
    parameters: toml::Table,
}

impl Configured for Ready {
    fn manifest(&self) -> Manifest {
        self.manifest.clone()
    }

    fn check(&self) -> Vec<BuildError> {
        self.faults.clone()
    }

    fn parameters(&self) -> toml::Table {
        self.parameters.clone()
    }

    fn build(&self, context: &BuildContext) -> Result<Built, BuildError> {
        let create = self.record.entry.create.ok_or_else(|| BuildError::at("plugin", "cannot be created"))?;
        let kept = Kept { rng: Box::new(context.rng()), abort: Arc::new(context.background.abort().clone()) };
        let robot = &mut RobotLoan::new(&context.robot);
        let paths = Paths::of(context)?;
        let view = paths.lend(context, robot, &kept);
        let config = self.config.lend();
        let mut this = std::ptr::null_mut();
        let mut error = rumbo_error::none();
        // SAFETY: a function of the library, with views that live until it returns.
        let code = unsafe {
            create(
                self.record.at,
                &raw const HOST,
                &raw const config,
                &raw const view,
                &raw mut this,
                &raw mut error,
            )
        };
        match code {
            RUMBO_OK if this.is_null() => {
                Err(BuildError::at("plugin", format!("{} gave no instance", self.who)))
            }
            RUMBO_OK => Ok(self.built(this, kept, context)),
            RUMBO_PANIC => {
                let words = error.words(code);
                Err(BuildError::at("plugin", format!("{} panicked when it was made: {words}", self.who)))
            }
            code => Err(BuildError::from_code(code, &error)),
        }
    }
}

impl Ready {
    /// The instance as a stage.
    fn built(&self, this: *mut c_void, kept: Kept, context: &BuildContext) -> Built {
        let who = self.who.clone();
        let at = self.record.entry.table;
        macro_rules! table {
            ($kind:ty) => {{
                // SAFETY: the record was checked: the table of this stage lies there.
                let table = unsafe { read(at.cast::<$kind>()) };
                // SAFETY: all zeros is a table without functions; it is never needed, since the record was checked.
                table.unwrap_or_else(|| unsafe { std::mem::zeroed() })
            }};
        }
        match self.record.stage {
            Stage::Planner => {
                let table = table!(rumbo_planner_table);
                let instance = Instance::new(this, table.destroy, who, kept);
                Built::Planner(Box::new(DynPlanner::new(instance, table, &context.robot)))
            }
            Stage::Avoider => {
                let table = table!(rumbo_avoider_table);
                let instance = Instance::new(this, table.destroy, who, kept);
                Built::Avoider(Box::new(DynAvoider::new(instance, table, &context.robot)))
            }
            Stage::Localizer => {
                let table = table!(rumbo_localizer_table);
                let instance = Instance::new(this, table.destroy, who, kept);
                Built::Localizer(Box::new(DynLocalizer::new(instance, table)))
            }
            Stage::Slam => {
                let table = table!(rumbo_slam_table);
                let instance = Instance::new(this, table.destroy, who, kept);
                Built::Slam(Box::new(DynSlam::new(instance, table)))
            }
            Stage::Sensor => {
                let table = table!(rumbo_sensor_table);
                let instance = Instance::new(this, table.destroy, who, kept);
                Built::Sensor(Box::new(DynSensor::new(instance, table, context.sensor)))
            }
            Stage::MapBuilder | Stage::World => {
                let table = table!(rumbo_map_builder_table);
                let instance = Instance::new(this, table.destroy, who, kept);
                Built::MapBuilder(Box::new(DynMapBuilder::new(instance, table)))
            }
        }
    }
}
