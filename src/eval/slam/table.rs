//! The rows of `rumbo eval slam` for people.

use super::{Errors, Row};
use rumbo_kit::spread::Spread;

/// What stands above the columns.
pub fn head() -> String {
    format!(
        "{:18} {:28} {:>12} {:>21} {:>21} {:>19} {:>9} {:>8} {:>8} {:>8}",
        "log",
        "pipeline",
        "relations",
        "at the time, m",
        "at the end, m",
        "at the end, deg",
        "tracked",
        "x real",
        "x cpu",
        "MB"
    )
}

/// One row.
pub fn line(row: &Row) -> String {
    let meters = |errors: &Option<Errors>| {
        errors.as_ref().map_or("-".to_owned(), |errors| mean_and_std(&errors.translation_m, 1.0))
    };
    let degrees = |errors: &Option<Errors>| {
        let degree = 1.0_f64.to_degrees();
        errors.as_ref().map_or("-".to_owned(), |errors| mean_and_std(&errors.rotation_rad, degree))
    };
    let judged = row.at_the_end.as_ref().or(row.at_the_time.as_ref());
    let used = format!("{} of {}", judged.map_or(0, |errors| errors.n_used), row.n_relations);
    let times = |seconds: Option<f64>| {
        seconds.filter(|s| *s > 0.0).map_or("-".to_owned(), |s| format!("{:.0}", row.log_s / s))
    };
    let megabytes = row.cost.peak_memory_mb.map_or("-".to_owned(), |mb| format!("{mb:.0}"));
    format!(
        "{:18} {:28} {used:>12} {:>21} {:>21} {:>19} {:>7.1} % {:>8} {:>8} {megabytes:>8}",
        row.log,
        row.pipeline,
        meters(&row.at_the_time),
        meters(&row.at_the_end),
        degrees(&row.at_the_end),
        100.0 * row.tracked_share,
        times(Some(row.cost.wall_s)),
        times(row.cost.cpu_s),
    )
}

fn mean_and_std(spread: &Spread, factor: f64) -> String {
    format!("{:.4} +- {:.4}", spread.mean * factor, spread.std * factor)
}
