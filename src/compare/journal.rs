//! `runs.jsonl`: one line for each run that ended, so that a sweep that was stopped goes on where it was.

use super::design::{Design, Run};
use super::result::RunResult;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// One line.
#[derive(Serialize, Deserialize)]
struct Line {
    design: String,
    alternative: String,
    world: String,
    seed: u64,
    mission: u32,
    result: RunResult,
}

/// The file, held by one process at a time.
#[derive(Debug)]
pub struct Journal {
    file: File,
    path: PathBuf,
    fingerprint: String,
}

/// Why a folder cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The runs in it are of another design.
    #[error(
        "{} holds runs of another design ({found}, this one is {expected}): the pipeline, a world, the swaps, the \
         ranges or the version of rumbo has changed; name another folder with --output, or remove {}",
        path.display(),
        path.display()
    )]
    OtherDesign {
        /// The file.
        path: PathBuf,
        /// Fingerprint in the file.
        found: String,
        /// Fingerprint of this design.
        expected: String,
    },
    /// A line is no run.
    #[error("{}: line {line} is damaged ({reason}); remove that line, and its run is done again", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Counted from 1.
        line: usize,
        /// What the parser said.
        reason: String,
    },
    /// Another process writes to it.
    #[error("another `rumbo compare` works in {}; wait for it, or name another folder with --output", path.display())]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// The system refused.
    #[error("cannot write {}: {reason}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
}

impl Journal {
    /// Opens the file, makes it where it is missing, and reads the runs of this design. A last line without its end,
    /// which is what an interrupted write leaves, is cut off.
    pub fn open(
        path: &Path,
        design: &Design,
        fingerprint: &str,
    ) -> Result<(Journal, BTreeMap<Run, RunResult>), JournalError> {
        let io = |error: std::io::Error| JournalError::Io { path: path.into(), reason: error.to_string() };
        let file = OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path);
        let file = file.map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(JournalError::InUse { path: path.into() }),
            Err(TryLockError::Error(error)) => return Err(io(error)),
        }
        let bytes = std::fs::read(path).map_err(io)?;
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        let mut journal = Journal { file, path: path.into(), fingerprint: fingerprint.into() };
        let done = journal.read(bytes.get(..whole).unwrap_or_default(), design)?;
        journal.file.set_len(whole as u64).map_err(io)?;
        journal.file.seek(SeekFrom::End(0)).map_err(io)?;
        Ok((journal, done))
    }

    fn read(&self, whole: &[u8], design: &Design) -> Result<BTreeMap<Run, RunResult>, JournalError> {
        let known: BTreeMap<_, Run> = design
            .runs()
            .into_iter()
            .map(|run| {
                let names = (design.alternative_name(&run), design.place_name(&run).to_owned());
                ((names, run.seed, run.mission), run)
            })
            .collect();
        let mut done = BTreeMap::new();
        for (idx, text) in whole.split(|byte| *byte == b'\n').enumerate().filter(|(_, text)| !text.is_empty())
        {
            let line: Line = serde_json::from_slice(text).map_err(|error| JournalError::Damaged {
                path: self.path.clone(),
                line: idx + 1,
                reason: error.to_string(),
            })?;
            if line.design != self.fingerprint {
                return Err(JournalError::OtherDesign {
                    path: self.path.clone(),
                    found: line.design,
                    expected: self.fingerprint.clone(),
                });
            }
            let key = ((line.alternative, line.world), line.seed, line.mission);
            // Runs that an earlier call asked for and this one does not stay in the file for the next.
            if let Some(run) = known.get(&key) {
                done.insert(*run, line.result);
            }
        }
        Ok(done)
    }

    /// Appends a run, on the disk when this returns.
    pub fn append(&mut self, design: &Design, run: &Run, result: &RunResult) -> Result<(), JournalError> {
        let line = Line {
            design: self.fingerprint.clone(),
            alternative: design.alternative_name(run),
            world: design.place_name(run).to_owned(),
            seed: run.seed,
            mission: run.mission,
            result: result.clone(),
        };
        let text = serde_json::to_string(&line).map_err(std::io::Error::other);
        let written = text
            .and_then(|text| self.file.write_all((text + "\n").as_bytes()))
            .and_then(|()| self.file.sync_data());
        written.map_err(|error| JournalError::Io { path: self.path.clone(), reason: error.to_string() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::{swap, worlds::Place};

    fn design() -> Design {
        Design {
            title: String::new(),
            base: "p.toml".into(),
            sets: Vec::new(),
            ranges: Vec::new(),
            alternatives: swap::alternatives(&[swap::parse("planner=dp,a_star").unwrap()], &[]),
            places: vec![Place::own()],
            seeds: vec![1],
            show: Vec::new(),
        }
    }

    fn result(detail: &str) -> RunResult {
        RunResult::without_drive("panicked", detail.to_owned())
    }

    fn scratch(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("rumbo-journal-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        folder.join("runs.jsonl")
    }

    #[test]
    fn a_last_line_cut_at_any_byte_is_its_run_again_and_nothing_else() {
        let (path, design) = (scratch("cut"), design());
        let _ = std::fs::remove_file(&path);
        let (mut journal, _) = Journal::open(&path, &design, "f").unwrap();
        for run in &design.runs() {
            journal.append(&design, run, &result("on ä line")).unwrap();
        }
        drop(journal);
        let whole = std::fs::read(&path).unwrap();
        let first = whole.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        for length in first..whole.len() {
            std::fs::write(&path, &whole[..length]).unwrap();
            let (mut journal, done) = Journal::open(&path, &design, "f").unwrap();
            assert_eq!(done.keys().map(|run| run.alternative).collect::<Vec<_>>(), [0], "{length}");
            journal.append(&design, &design.runs()[1], &result("on ä line")).unwrap();
            drop(journal);
            assert_eq!(std::fs::read(&path).unwrap(), whole, "{length}");
        }
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn a_file_of_another_design_or_another_process_is_left_alone() {
        let (path, design) = (scratch("other"), design());
        let _ = std::fs::remove_file(&path);
        let (mut journal, _) = Journal::open(&path, &design, "f").unwrap();
        journal.append(&design, &design.runs()[0], &result("")).unwrap();
        assert!(matches!(Journal::open(&path, &design, "f"), Err(JournalError::InUse { .. })));
        drop(journal);
        assert!(matches!(Journal::open(&path, &design, "g"), Err(JournalError::OtherDesign { .. })));
        assert_eq!(Journal::open(&path, &design, "f").unwrap().1.len(), 1);
        std::fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }
}
