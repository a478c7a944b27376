//! The summary on the terminal: figures downwards, alternatives across.

use super::by_world::Spread;
use super::figures::FIGURES;
use super::pareto::OBJECTIVES_IN_WORDS;
use super::statistics::Interval;
use super::summary::{Difference, Estimate, Standing, Summary};
use crate::terminal::Terminal;
use rumbo_core::engine::Part;
use std::fmt::Write as _;

/// Alternatives side by side that a usual window has room for.
const N_ACROSS: usize = 4;
const NAME_WIDTH: usize = 28;
const WIDTH: usize = 23;

/// Everything that people are shown.
pub fn table(summary: &Summary, terminal: &Terminal) -> String {
    let mut text = String::new();
    let names: Vec<String> = (0..summary.alternatives.len()).map(letter).collect();
    for (letter, standing) in names.iter().zip(&summary.alternatives) {
        let mark = if standing.is_pareto && names.len() > 1 { "  (Pareto)" } else { "" };
        let _ = writeln!(text, "{}  {}{}", terminal.strong(letter), standing.name, terminal.good(mark));
        if let Some(trouble) = &standing.trouble {
            let _ = writeln!(text, "   {} {trouble}", terminal.bad("did not drive:"));
        }
    }
    for (letters, group) in names.chunks(N_ACROSS).zip(summary.alternatives.chunks(N_ACROSS)) {
        text.push('\n');
        rows(&mut text, letters, group);
    }
    for (world, lines) in &summary.by_world {
        for (nth, letters) in names.chunks(N_ACROSS).enumerate() {
            text.push('\n');
            row(&mut text, world, letters.iter().cloned());
            let standings = || summary.alternatives.iter().skip(nth * N_ACROSS).take(N_ACROSS);
            row(
                &mut text,
                "success, %",
                standings().map(|s| success(s.success_by_world.get(world).copied())),
            );
            for line in lines {
                let cells = || line.cells.iter().skip(nth * N_ACROSS).take(N_ACROSS);
                let mean = |cell: &Option<Spread>| cell.map_or("-".into(), |cell| cell.mean_in_words());
                let spread = |cell: &Option<Spread>| cell.map_or("-".into(), |cell| cell.spread_in_words());
                row(&mut text, &line.title, cells().map(mean));
                row(&mut text, "  median / 95 % / worst", cells().map(spread));
            }
        }
    }
    let against_first = summary.differences.iter().take(summary.alternatives.len().saturating_sub(1));
    let changes: Vec<&Difference> = against_first.collect();
    for (letters, group) in names.get(1..).unwrap_or_default().chunks(N_ACROSS).zip(changes.chunks(N_ACROSS))
    {
        let heads: Vec<String> = letters.iter().map(|letter| format!("{letter} - A")).collect();
        text.push_str("\npaired differences\n");
        differences(&mut text, &heads, group);
    }
    let _ = writeln!(text, "\nmeans with 95 % intervals; Pareto over {OBJECTIVES_IN_WORDS}");
    text
}

/// `A` to `Z`, then `A1` and so on.
pub fn letter(idx: usize) -> String {
    let letter = char::from(b'A' + (idx % 26) as u8);
    if idx < 26 { letter.to_string() } else { format!("{letter}{}", idx / 26) }
}

fn rows(text: &mut String, letters: &[String], group: &[Standing]) {
    row(text, "", letters.iter().cloned());
    row(text, "runs", group.iter().map(|s| s.n.to_string()));
    row(text, "success, %", group.iter().map(|s| success(s.success)));
    for world in worlds(group) {
        let cell = |s: &Standing| success(s.success_by_world.get(world).copied());
        row(text, &format!("  in {world}"), group.iter().map(cell));
    }
    let touched = |s: &Standing| s.n_with_contact.map_or("-".into(), |n| n.to_string());
    row(text, "runs with contact", group.iter().map(touched));
    for figure in &FIGURES {
        let cell = |standing: &Standing| shown(standing.figures.get(figure.key), |v| figure.show(v));
        row(text, &titled(figure.name, figure.unit), group.iter().map(cell));
    }
    let common = |s: &Standing| s.common_time_s.map_or("-".into(), |time_s| format!("{time_s:.1}"));
    row(text, "time where all arrived, s", group.iter().map(common));
    for part in Part::ALL {
        let cell = |s: &Standing| {
            s.cpu_s.get(part.name()).map_or("-".into(), |v| format!("{:.1}", v.interval.value * 1e3))
        };
        row(text, &format!("CPU {}, ms", part.name().replace('_', " ")), group.iter().map(cell));
    }
    let mut ends: Vec<&String> = group.iter().flat_map(|s| s.ends.keys()).collect();
    ends.sort();
    ends.dedup();
    for end in ends.into_iter().filter(|end| *end != "arrived") {
        let cell = |s: &Standing| s.ends.get(end).copied().unwrap_or(0).to_string();
        row(text, &format!("ended: {}", end.replace('_', " ")), group.iter().map(cell));
    }
}

/// Names of the worlds, where there are several.
pub fn worlds(standings: &[Standing]) -> impl Iterator<Item = &String> {
    let first = standings.iter().take(1).flat_map(|standing| standing.success_by_world.keys());
    let several = standings.iter().any(|standing| standing.success_by_world.len() > 1);
    first.filter(move |_| several)
}

fn differences(text: &mut String, heads: &[String], group: &[&Difference]) {
    row(text, "", heads.iter().cloned());
    let percent = |v: f64| format!("{:+.1}", v * 100.0);
    row(text, "success, %", group.iter().map(|d| shown(d.success.as_ref(), percent)));
    for figure in &FIGURES {
        let signed = |v: f64| format!("{:+.*}", figure.digits, v * figure.scale);
        let cell = |d: &&Difference| shown(d.figures.get(figure.key), signed);
        row(text, &titled(figure.name, figure.unit), group.iter().map(cell));
    }
}

fn row(text: &mut String, name: &str, cells: impl Iterator<Item = String>) {
    let _ = write!(text, "{name:NAME_WIDTH$}");
    for cell in cells {
        let _ = write!(text, " {cell:>WIDTH$}");
    }
    text.push('\n');
}

/// `time to goal, s`.
pub fn titled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name}, {unit}") }
}

/// A share in percent, with its interval.
pub fn success(interval: Option<Interval>) -> String {
    let percent = |v: f64| format!("{:.0}", v * 100.0);
    interval.map_or("-".into(), |i| format!("{} [{}, {}]", percent(i.value), percent(i.low), percent(i.high)))
}

/// A mean with its interval.
pub fn shown(estimate: Option<&Estimate>, show: impl Fn(f64) -> String) -> String {
    let with = |Interval { value, low, high }| format!("{} [{}, {}]", show(value), show(low), show(high));
    estimate.map_or("-".into(), |estimate| with(estimate.interval))
}
