//! Which tests there are.

use crate::drive::drive;
use crate::exit::{Exit, Failure};
use crate::load::{self, Ready};
use crate::record::RunRecord;
use crate::terminal::Terminal;
use rumbo_core::engine::EngineError;
use rumbo_core::pipeline::PipelineTest;
use rumbo_core::registry::Registry;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// One test of one pipeline.
pub struct Case {
    /// The pipeline's file.
    pub file: String,
    /// What is expected.
    pub test: PipelineTest,
    ready: Arc<Ready>,
}

impl Case {
    /// Runs it.
    pub fn drive(&self) -> Result<RunRecord, EngineError> {
        let mut pipeline = self.ready.pipeline.clone();
        pipeline.seed = self.test.seed.unwrap_or(pipeline.seed);
        let never = AtomicBool::new(false);
        drive(&pipeline, &self.file, &self.ready.config, &mut [], &never)
    }

    /// A file name made of the pipeline's and the test's.
    pub fn report_name(&self) -> String {
        let stem = Path::new(&self.file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let plain = |letter: char| if letter.is_alphanumeric() { letter } else { '-' };
        format!("{stem}.{}.html", self.test.name.chars().map(plain).collect::<String>())
    }
}

/// What was found.
pub struct Found {
    /// In the order of files and of the tests in each.
    pub cases: Vec<Case>,
    /// Some files have faults, which have been shown.
    pub has_faults: bool,
}

/// All tests of these files and folders.
pub fn cases(
    paths: &[PathBuf],
    sets: &[String],
    filter: Option<&str>,
    json: bool,
    terminal: &Terminal,
) -> Result<Found, Failure> {
    let registry = load::registry()?;
    let mut found = Found { cases: Vec::new(), has_faults: false };
    for path in paths {
        for file in files(path)? {
            add(&file, sets, filter, json, &registry, terminal, &mut found)?;
        }
    }
    Ok(found)
}

fn add(
    file: &Path,
    sets: &[String],
    filter: Option<&str>,
    json: bool,
    registry: &Registry,
    terminal: &Terminal,
    found: &mut Found,
) -> Result<(), Failure> {
    let name = file.display().to_string();
    let ready = match load::load(file, sets, registry) {
        Ok(ready) => Arc::new(ready),
        Err(refused) if json => {
            terminal.json(&serde_json::json!({ "file": name, "faults": refused.to_json() }))?;
            return Err(Failure::Told(Exit::Faults));
        }
        Err(refused) => {
            refused.show(terminal);
            found.has_faults = true;
            return Ok(());
        }
    };
    for test in &ready.pipeline.tests {
        if filter.is_none_or(|part| test.name.contains(part)) {
            found.cases.push(Case { file: name.clone(), test: test.clone(), ready: Arc::clone(&ready) });
        }
    }
    Ok(())
}

/// The file itself, or the pipelines directly inside a folder, sorted.
fn files(path: &Path) -> Result<Vec<PathBuf>, Failure> {
    if !path.is_dir() {
        return Ok(vec![path.to_path_buf()]);
    }
    let trouble = |error: std::io::Error| Failure::Usage(format!("cannot read {}: {error}", path.display()));
    let mut files = Vec::new();
    for entry in std::fs::read_dir(path).map_err(trouble)? {
        let file = entry.map_err(trouble)?.path();
        if file.is_file() && file.extension().is_some_and(|extension| extension == "toml") {
            files.push(file);
        }
    }
    files.sort();
    Ok(files)
}
