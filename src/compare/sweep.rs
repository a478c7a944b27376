//! Does the runs of a design that are not done yet, on several threads.

use super::design::{Design, Run};
use super::journal::{Journal, JournalError};
use super::progress::Progress;
use super::result::{RunResult, work};
use super::summary::Results;
use crate::queue::in_order;
use rumbo_core::registry::Registry;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// Adds every missing run to `results` and to the journal. Raising `stop` ends it after the runs under way; those are
/// not kept. What a run gives depends on the run alone, so neither order nor number of threads is seen in the results.
pub fn sweep(
    design: &Design,
    registry: &Registry,
    journal: Journal,
    results: &mut Results,
    n_threads: usize,
    progress: &Progress,
    stop: &AtomicBool,
) -> Result<(), JournalError> {
    let missing: Vec<Run> = design.runs().into_iter().filter(|run| !results.contains_key(run)).collect();
    let journal = Mutex::new(journal);
    let done = |run: &Run| -> Result<Option<RunResult>, JournalError> {
        if stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let Some(result) = work(design, run, registry, stop) else { return Ok(None) };
        let mut journal = journal.lock().unwrap_or_else(PoisonError::into_inner);
        let written = journal.append(design, run, &result);
        // A disk that is full stops the sweep at once, not after hours.
        if written.is_err() {
            stop.store(true, Ordering::Relaxed);
        }
        progress.step(&format!("{}: {}", design.place_name(run), result.end));
        written.map(|()| Some(result))
    };
    let mut trouble = None;
    in_order(
        &missing,
        n_threads,
        |run| (*run, done(run)),
        |(run, ended)| match ended {
            Ok(result) => results.extend(result.map(|result| (run, result))),
            Err(error) => trouble = Some(error),
        },
    );
    trouble.map_or(Ok(()), Err)
}
