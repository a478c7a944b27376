//! Rows in the order of their stamps.

use rumbo_core::time::{Span, Time};

use super::table::Row;
use crate::log_file::Steps;

/// A row with a stamp.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stamped<T> {
    pub stamp: Time,
    pub told: T,
}

/// Rows up to this much out of order are sorted in; the stamp of one that is farther off is wrong.
const WINDOW: Span = Span(2_000_000_000);

/// Sorts rows by their stamps, rows of one stamp as they stand in the file, and leaves out those whose stamp fits neither
/// the row before them nor the row behind. Says both.
pub(crate) fn sorted<T>(rows: Vec<Row<Stamped<T>>>, name: &str) -> (Vec<Stamped<T>>, Vec<String>) {
    let stamps: Vec<Time> = rows.iter().map(|row| row.told.stamp).collect();
    let (mut steps, mut strays) = (Steps::default(), Vec::new());
    let mut kept: Vec<Stamped<T>> = Vec::with_capacity(rows.len());
    let mut newest: Option<Time> = None;
    for (idx, row) in rows.into_iter().enumerate() {
        let stamp = row.told.stamp;
        let is_behind = newest.is_some_and(|newest| newest - stamp > WINDOW);
        // The row behind says who is wrong: a stamp that leaps ahead of it, or a gap of the log.
        let next = stamps.get(idx + 1).copied();
        let leaps = next
            .is_some_and(|next| stamp - next > WINDOW && newest.is_none_or(|newest| newest - next <= WINDOW));
        if is_behind || leaps {
            strays.push(row.line);
            continue;
        }
        steps.see(stamp, row.line);
        newest = newest.max(Some(stamp));
        kept.push(row.told);
    }
    kept.sort_by_key(|row| row.stamp);
    (kept, sentences(name, &steps, &strays))
}

fn sentences(name: &str, steps: &Steps, strays: &[u64]) -> Vec<String> {
    let mut sentences = Vec::new();
    if steps.n > 0 {
        sentences.push(format!(
            "{name}: stamps step backward {} times, first in line {}, at most {:.3} s; these rows are sorted in",
            steps.n,
            steps.first_line,
            steps.largest.as_secs()
        ));
    }
    if let Some(first) = strays.first() {
        let n = strays.len();
        sentences.push(format!(
            "{name}: left out {n} rows whose stamps are more than 2 s out of order, the first in line {first}"
        ));
    }
    sentences
}
