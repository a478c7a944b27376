//! The last words of a run.

use crate::outcome::Outcome;
use crate::record::EventRecord;
use crate::report::figures;
use crate::terminal::Terminal;
use crate::usage::peak_memory_mb;
use std::path::PathBuf;

/// The figures in aligned plain words, what to try next, and the files that were written.
pub fn summary(
    outcome: &Outcome,
    events: &[EventRecord],
    written: &[(&str, PathBuf)],
    terminal: &Terminal,
) -> String {
    let reason = outcome.reason.to_string().replace('_', " ");
    let reason = if outcome.is_success() { terminal.good(&reason) } else { terminal.bad(&reason) };
    let mut lines = vec![format!("{}: {reason}", terminal.strong(&outcome.pipeline))];
    lines.extend(outcome.detail.iter().map(|detail| format!("  {detail}")));
    lines.extend(notices(events, terminal));
    let figures = figures(outcome);
    let memory = peak_memory_mb().map(|mb| ("peak memory", format!("{mb:.0} MB"), false));
    let files = written.iter().map(|(name, path)| (*name, path.display().to_string(), false));
    let rows: Vec<(&str, String, bool)> = figures
        .into_iter()
        .filter(|figure| figure.name != "result")
        .map(|figure| (figure.name, figure.value, figure.is_trouble))
        .chain(memory)
        .chain(files)
        .collect();
    let width = rows.iter().map(|(name, ..)| name.len()).max().unwrap_or(0);
    for (name, value, is_trouble) in rows {
        let value = if is_trouble { terminal.bad(&value) } else { value };
        lines.push(format!("  {}  {value}", terminal.soft(&format!("{name:width$}"))));
    }
    lines.extend(outcome.hint().map(|hint| format!("{} {hint}", terminal.strong("try:"))));
    lines.join("\n")
}

/// What the world itself had to tell.
pub fn notices<'a>(events: &'a [EventRecord], terminal: &'a Terminal) -> impl Iterator<Item = String> + 'a {
    let notices = events.iter().filter(|event| event.is_notice);
    notices.map(|event| format!("  {} {}", terminal.bad("note:"), event.text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::test_record;

    #[test]
    fn values_stand_below_each_other_and_failure_comes_with_advice() {
        let mut outcome = test_record().outcome.unwrap();
        outcome.reason = rumbo_core::engine::EndReason::Unreachable;
        outcome.arrived = false;
        outcome.detail = Some("the door is closed".into());
        let text = summary(&outcome, &[], &[("report", "out/a.html".into())], &Terminal::new(Some(false)));
        assert!(text.contains("unreachable") && text.contains("the door is closed") && text.contains("try:"));
        let column =
            |part: &str| text.lines().find(|line| line.contains(part)).and_then(|l| l.find(part)).unwrap();
        assert_eq!(column("3.00 m"), column("out/a.html"));
    }
}
