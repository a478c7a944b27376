//! From a file to a pipeline, or to all its faults.

use crate::diagnostics;
use crate::exit::{Exit, Failure};
use crate::terminal::Terminal;
use rumbo_core::document::{to_commented_toml, to_json};
use rumbo_core::engine::EngineError;
use rumbo_core::pipeline::{Loaded, Pipeline, RecordTo};
use rumbo_core::registry::Registry;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A pipeline that can be built, and the file that it came from.
pub struct Ready {
    /// The pipeline.
    pub pipeline: Pipeline,
    /// The effective file, with the origin of each value.
    pub config: String,
    loaded: Loaded,
}

impl Ready {
    /// The whole run may take so many seconds of the world's time.
    pub fn limit(&mut self, duration_s: f64) {
        self.pipeline.mission.time_limit_s = duration_s;
        self.pipeline.duration_s = Some(duration_s);
    }

    /// Where the file wants the run to be recorded; `usual` is where a plain `true` puts it.
    pub fn record(&self, usual: impl FnOnce() -> PathBuf) -> Option<PathBuf> {
        match self.loaded.record.as_ref()? {
            RecordTo::File(path) => Some(path.clone()),
            RecordTo::Usual(is_wanted) => is_wanted.then(usual),
        }
    }

    /// Checksums of the libraries that this pipeline could name plugins of, each once.
    pub fn libraries(&self) -> BTreeSet<String> {
        let libraries = self.loaded.registry.iter().filter_map(|entry| entry.library.as_ref());
        libraries.map(|library| library.sha256.clone()).collect()
    }

    /// What will hardly do what is expected of it, for people.
    pub fn warn(&self, terminal: &Terminal) {
        let (warnings, sources) = (&self.loaded.warnings, &self.loaded.document.sources);
        if !warnings.is_empty() {
            terminal.say(diagnostics::render_warnings(warnings, sources, terminal.has_colors()));
        }
    }

    /// The same for programs.
    pub fn warnings(&self) -> serde_json::Value {
        self.loaded.warnings.iter().map(|doubt| doubt.to_json(&self.loaded.document.sources)).collect()
    }

    /// The effective file and the origin of each value, for programs.
    pub fn to_json(&self) -> serde_json::Value {
        to_json(&self.loaded.effective(), &self.loaded.document.sources)
    }

    /// Why the engine could not be built, with the line of the file where that is known.
    pub fn explain(&self, error: &EngineError, json: bool, terminal: &Terminal) -> Failure {
        let mut loaded = self.loaded.clone();
        loaded.check();
        if loaded.faults.is_empty() {
            return Failure::Usage(error.to_string());
        }
        Refused::new(loaded).tell(json, terminal)
    }
}

/// A pipeline that was refused.
pub struct Refused {
    loaded: Box<Loaded>,
}

impl Refused {
    fn new(loaded: Loaded) -> Refused {
        Refused { loaded: Box::new(loaded) }
    }

    /// The faults for people.
    pub fn show(&self, terminal: &Terminal) {
        let (faults, sources) = (&self.loaded.faults, &self.loaded.document.sources);
        terminal.say(diagnostics::render(faults, sources, terminal.has_colors()));
    }

    /// The faults for programs.
    pub fn to_json(&self) -> serde_json::Value {
        let sources = &self.loaded.document.sources;
        self.loaded.faults.iter().map(|fault| fault.to_json(sources)).collect()
    }

    /// Shows the faults to people, and to programs where they asked for it.
    pub fn tell(&self, json: bool, terminal: &Terminal) -> Failure {
        self.show(terminal);
        let shown =
            if json { terminal.json(&serde_json::json!({ "faults": self.to_json() })) } else { Ok(()) };
        shown.err().unwrap_or(Failure::Told(Exit::Faults))
    }
}

/// Libraries that the command line names, for the rest of this program's life.
static NAMED: OnceLock<Vec<PathBuf>> = OnceLock::new();
/// Where the environment names libraries and folders, as in `PATH`.
const SEARCH: &str = "RUMBO_PLUGIN_PATH";

/// From now on the plugins of these libraries can be named by every pipeline. Only the first call counts.
pub fn use_libraries(files: &[PathBuf]) {
    let _ = NAMED.set(files.to_vec());
}

/// Everything that is shipped.
pub fn linked() -> Result<Registry, Failure> {
    Registry::linked().map_err(|error| Failure::Internal(error.to_string()))
}

/// Everything that a pipeline can name: what is shipped, and the libraries of `--plugin` and `$RUMBO_PLUGIN_PATH`.
pub fn registry() -> Result<Registry, Failure> {
    let mut registry = linked()?;
    let mut faults = Vec::new();
    for file in NAMED.get().into_iter().flatten() {
        if let Err(error) = registry.load(file, None) {
            faults.push(format!("--plugin {}: {error}", file.display()));
        }
    }
    let search = std::env::var_os(SEARCH).unwrap_or_default();
    for path in std::env::split_paths(&search).filter(|path| !path.as_os_str().is_empty()) {
        if path.is_dir() {
            registry.search(path);
        } else if let Err(error) = registry.load(&path, None) {
            faults.push(format!("${SEARCH}: {error}"));
        }
    }
    if faults.is_empty() { Ok(registry) } else { Err(Failure::Usage(faults.join("\n"))) }
}

/// Reads a pipeline and proves that its parts fit together.
pub fn load(path: &Path, sets: &[String], registry: &Registry) -> Result<Ready, Refused> {
    sound(Loaded::read(path, sets, registry))
}

/// As [`load`] for a pipeline that is in no file.
pub fn from_text(path: &Path, text: &str, sets: &[String], registry: &Registry) -> Result<Ready, Refused> {
    sound(Loaded::from_text(path, text, sets, registry))
}

fn sound(loaded: Loaded) -> Result<Ready, Refused> {
    match loaded.sound() {
        Some(pipeline) => {
            let config = to_commented_toml(&loaded.effective(), &loaded.document.sources);
            Ok(Ready { pipeline: pipeline.clone(), config, loaded })
        }
        None => Err(Refused::new(loaded)),
    }
}

/// As [`load`], and looks at the files that the pipeline names, too.
pub fn load_and_check(path: &Path, sets: &[String], registry: &Registry) -> Result<Ready, Refused> {
    let mut loaded = Loaded::read(path, sets, registry);
    loaded.check();
    sound(loaded)
}

/// Reads a pipeline, and shows its faults, or what is doubtful in it.
pub fn pipeline(path: &Path, sets: &[String], json: bool, terminal: &Terminal) -> Result<Ready, Failure> {
    let ready = load(path, sets, &registry()?).map_err(|refused| refused.tell(json, terminal))?;
    ready.warn(terminal);
    Ok(ready)
}

/// As [`pipeline`], and looks at the files and places that the pipeline names before anything moves.
pub fn checked(path: &Path, sets: &[String], json: bool, terminal: &Terminal) -> Result<Ready, Failure> {
    let mut ready = pipeline(path, sets, json, terminal)?;
    ready.loaded.check();
    if ready.loaded.sound().is_some() {
        Ok(ready)
    } else {
        Err(Refused::new(ready.loaded).tell(json, terminal))
    }
}

/// `, did you mean ...?`, or nothing where no name is near.
pub fn did_you_mean<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let near = rumbo_core::document::did_you_mean(word, known);
    near.map(|name| format!(", did you mean `{name}`?")).unwrap_or_default()
}
