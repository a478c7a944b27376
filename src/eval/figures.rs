//! Tables of figures for people.

use crate::terminal::Terminal;
use rumbo_kit::spread::Spread;

/// A title and what belongs to it.
pub fn lines(title: &str, rows: &[(&str, String)], terminal: &Terminal) {
    terminal.say(terminal.strong(title));
    let width = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    for (name, value) in rows {
        terminal.say(format!("  {}  {value}", terminal.soft(&format!("{name:width$}"))));
    }
}

/// Sets of errors, one a line.
pub fn spreads(rows: &[(&str, &str, f64, Spread)], terminal: &Terminal) {
    let head = format!(
        "  {:22} {:>8} {:>10} {:>10} {:>10} {:>10} {:>10} {:>10}",
        "", "n", "rmse", "mean", "median", "std", "min", "max"
    );
    terminal.say(terminal.soft(&head));
    for (name, unit, factor, spread) in rows {
        let Spread { n, rmse, mean, median, std, min, max } = *spread;
        let values = [rmse, mean, median, std, min, max].map(|value| format!("{:>10.6}", value * factor));
        terminal.say(format!("  {:22} {n:>8} {}", format!("{name}, {unit}"), values.join(" ")));
    }
}
