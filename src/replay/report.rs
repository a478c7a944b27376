//! What a replay tells people and programs.

use super::comparison::Compared;
use super::difference::Difference;
use super::figures::Figures;
use super::world::Follow;
use crate::terminal::Terminal;
use rumbo_core::engine::RunEnd;
use serde::Serialize;
use std::path::Path;

/// What a replay found.
#[derive(Debug, Serialize)]
pub struct Report {
    recording: String,
    /// Something else was run than what was recorded.
    is_changed: bool,
    /// Every message has the same bytes.
    is_same: bool,
    steps: u64,
    messages: u64,
    /// Where each stage first said something else, earliest first.
    differences: Vec<Difference>,
    figures: Figures,
    recorded_end: Option<String>,
    replayed_end: String,
    /// What is wrong with the file; it was replayed up to there.
    damage: Option<String>,
    notes: Vec<String>,
}

impl Report {
    /// Of what was found.
    pub fn new(
        recording: &Path,
        follow: Follow,
        notes: Vec<String>,
        compared: Compared,
        end: &RunEnd,
    ) -> Report {
        Report {
            recording: recording.display().to_string(),
            is_changed: follow == Follow::Times,
            is_same: compared.differences.is_empty(),
            steps: compared.n_steps,
            messages: compared.n_messages,
            differences: compared.differences,
            figures: compared.figures,
            recorded_end: compared.recorded_end.map(|(reason, _)| reason),
            replayed_end: end.reason.to_string(),
            damage: compared.damage,
            notes,
        }
    }

    /// The same bytes, or a change that was asked for.
    pub fn is_good(&self) -> bool {
        self.is_same || self.is_changed
    }

    /// For people.
    pub fn text(&self, terminal: &Terminal) -> String {
        let verdict = match (self.is_same, self.is_changed) {
            (true, _) => terminal.good("the same bytes"),
            (false, true) => terminal.strong("other than recorded, as asked"),
            (false, false) => terminal.bad("differs"),
        };
        let (steps, messages) = (self.steps, self.messages);
        let mut lines = vec![format!("{}: {verdict} ({steps} steps, {messages} messages)", self.recording)];
        lines.extend(self.notes.iter().chain(&self.damage).map(|note| format!("  note: {note}")));
        if self.is_same {
            return lines.join("\n");
        }
        let mut words = ["first: ", "then:  "].into_iter();
        for difference in &self.differences {
            lines.push(format!("  {}{difference}", words.next().unwrap_or("       ")));
        }
        lines.extend(self.figures());
        lines.join("\n")
    }

    fn figures(&self) -> Vec<String> {
        let figures = &self.figures;
        let (mean, max) = (figures.position_difference_mean_m, figures.position_difference_max_m);
        let mut lines = vec![format!(
            "  position differs by {mean:.3} m in the mean, {max:.3} m at most, over {} estimates",
            figures.n_estimates
        )];
        let meters = |length: Option<f64>| length.map_or("none".to_owned(), |m| format!("{m:.2} m"));
        let [first, second] = figures.first_path_m;
        let [n_first, n_second] = figures.n_paths;
        lines.push(format!(
            "  first path {} -> {}; paths {n_first} -> {n_second}",
            meters(first),
            meters(second)
        ));
        let events = figures.events.iter().filter(|(_, [first, second])| first != second);
        let events: Vec<String> =
            events.map(|(kind, [first, second])| format!("{kind} {first} -> {second}")).collect();
        if !events.is_empty() {
            lines.push(format!("  events: {}", events.join(", ")));
        }
        let recorded = self.recorded_end.as_deref().unwrap_or("unknown");
        lines.push(format!("  end: {recorded} -> {}", self.replayed_end));
        lines
    }
}
