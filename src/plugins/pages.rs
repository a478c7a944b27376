//! `rumbo plugins docs`: one page for each plugin, made from what the plugins say of themselves.

use super::describe::{example, kind, manifest, needs_and_gives};
use super::parameters::{description, parameters};
use crate::exit::{Exit, Failure};
use crate::terminal::{Terminal, write_file};
use rumbo_core::registry::{Entry, Registry, Stage};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

/// Writes all pages, or with `check` says which ones are not as they would be written.
pub fn write(registry: &Registry, folder: &Path, check: bool, terminal: &Terminal) -> Result<Exit, Failure> {
    let pages = pages(registry);
    let mut stale = Vec::new();
    for (name, text) in &pages {
        let path = folder.join(name);
        if check && std::fs::read_to_string(&path).ok().as_ref() != Some(text) {
            stale.push(format!("{} is not up to date", path.display()));
        } else if !check {
            write_file(&path, text.as_bytes())?;
        }
    }
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if name.ends_with(".md") && !pages.contains_key(&name) {
            stale.push(format!("{} belongs to no plugin; remove it", entry.path().display()));
        }
    }
    stale.iter().for_each(|line| terminal.say(line));
    if !check {
        terminal.say(format!("{} pages in {}", pages.len(), folder.display()));
    } else if !stale.is_empty() {
        terminal.say(format!("write them with `rumbo plugins docs {}`", folder.display()));
        return Ok(Exit::NoSuccess);
    }
    Ok(Exit::Success)
}

/// File names and texts.
fn pages(registry: &Registry) -> BTreeMap<String, String> {
    let mut pages: BTreeMap<String, String> =
        registry.iter().map(|entry| (file_name(entry), page(entry))).collect();
    pages.insert("README.md".into(), index(registry));
    pages
}

fn file_name(entry: &Entry) -> String {
    format!("{}.{}.md", entry.stage.section(), entry.name)
}

fn index(registry: &Registry) -> String {
    let mut text = String::from("# Plugins\n\nWritten by `rumbo plugins docs docs/plugins`.\n");
    for stage in Stage::ALL {
        let mut entries = registry.of_stage(stage).peekable();
        if entries.peek().is_none() {
            continue;
        }
        let _ = write!(text, "\n## `[{}]`\n\n", stage.section());
        for entry in entries {
            let _ = writeln!(text, "- [{}]({}): {}", entry.name, file_name(entry), entry.summary);
        }
    }
    text
}

fn page(entry: &Entry) -> String {
    let mut text = format!("# {}\n\n{}\n", entry.name, sentence(&entry.summary));
    let about = description(entry);
    if !about.is_empty() {
        let _ = write!(text, "\n{about}\n");
    }
    let _ = write!(text, "\nSection `[{}]`, package `{}`.\n", entry.stage.section(), entry.origin);
    let lines = manifest(entry).map(|manifest| needs_and_gives(&manifest)).unwrap_or_default();
    if !lines.is_empty() {
        text.push('\n');
    }
    for (what, which) in lines {
        let _ = writeln!(text, "- {what}: {which}");
    }
    let _ = write!(text, "\n## Example\n\n```toml\n{}```\n", example(entry));
    let rows = parameters(entry);
    if !rows.is_empty() {
        text.push_str("\n## Parameters\n\n| key | takes | default | |\n|---|---|---|---|\n");
    }
    for row in rows {
        let default = row.default.as_ref().map(|default| format!("`{default}`")).unwrap_or_default();
        let words = row.description.split_whitespace().collect::<Vec<_>>().join(" ");
        let cells =
            [format!("`{}`", row.key), kind(&row), default, words].map(|cell| cell.replace('|', "\\|"));
        let _ = writeln!(text, "| {} |", cells.join(" | "));
    }
    text
}

/// The summary with a capital letter and a full stop.
fn sentence(words: &str) -> String {
    let mut letters = words.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().collect::<String>()).unwrap_or_default();
    let stop = if words.ends_with('.') { "" } else { "." };
    format!("{first}{}{stop}", letters.as_str())
}
