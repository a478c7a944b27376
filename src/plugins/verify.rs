//! `rumbo plugins verify`: asks plugins for the laws of their stage.

use super::find;
use crate::exit::{Exit, Failure};
use crate::laws::{Options, Outcome, PluginReport, Report, verify_with};
use crate::terminal::Terminal;
use rumbo_core::registry::{Entry, Registry};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;

/// Ask plugins for the laws of their stage
///
/// Every plugin is built from its defaults and asked: does it give the same answer twice, obey, survive nonsense, and see
/// the same in a mirror? docs/verify.md says what each law means. Exit code 1: a law is broken.
#[derive(clap::Args)]
pub struct Args {
    /// Names of plugins (section.name where two sections have one of this name), or plugin files; all that are shipped
    /// where nothing is named
    #[arg(id = "names", value_name = "FILE or NAME")]
    plugins: Vec<String>,
    /// Give a plugin a parameter that it cannot be without, for example --set clearance_m=0.3
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Only what is broken
    #[arg(long)]
    broken: bool,
    /// Print results as JSON
    #[arg(long)]
    json: bool,
}

/// What programs are told.
#[derive(Serialize)]
struct Printed<'r> {
    kept: usize,
    broken: usize,
    not_applicable: usize,
    plugins: &'r [PluginReport],
}

/// Does it.
pub fn run(mut registry: Registry, args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let entries = chosen(&mut registry, &args.plugins)?;
    if args.plugins.is_empty() && !args.sets.is_empty() {
        return Err(Failure::Usage("--set is about one plugin: name it".into()));
    }
    let options = Options { keys: keys(&args.sets)? };
    let show = |plugin: &PluginReport| {
        if !args.json {
            terminal.say(table(plugin, args.broken, terminal));
        }
    };
    let report = verify_with(entries.iter(), &options, show);
    let [kept, broken, not_applicable] = report.tally();
    if args.json {
        terminal.json(&Printed { kept, broken, not_applicable, plugins: &report.plugins })?;
    } else {
        terminal.say(summary(&report, terminal));
    }
    Ok(if report.is_good() { Exit::Success } else { Exit::NoSuccess })
}

fn chosen(registry: &mut Registry, names: &[String]) -> Result<Vec<Arc<Entry>>, Failure> {
    if names.is_empty() {
        return Ok(registry.iter().cloned().collect());
    }
    let mut chosen = Vec::new();
    for name in names {
        if is_file(name) {
            chosen.extend(loaded(registry, Path::new(name))?);
        } else {
            chosen.push(find(registry, name)?.clone());
        }
    }
    Ok(chosen)
}

/// The plugins of a file, which become part of the registry.
fn loaded(registry: &mut Registry, file: &Path) -> Result<Vec<Arc<Entry>>, Failure> {
    let library = registry.load(file, None).map_err(|error| Failure::Usage(error.to_string()))?;
    Ok(library.entries.clone())
}

/// Names of plugins have no separators and no endings of libraries.
fn is_file(word: &str) -> bool {
    let has_separator = word.contains(['/', '\\']);
    let ending = Path::new(word).extension().and_then(|ending| ending.to_str());
    has_separator || ending.is_some_and(|ending| ["so", "dylib", "dll"].contains(&ending))
}

/// `KEY=VALUE` as in a pipeline; a bare word is text.
fn keys(sets: &[String]) -> Result<toml::Table, Failure> {
    let mut keys = toml::Table::new();
    for set in sets {
        let Some((key, value)) = set.split_once('=') else {
            return Err(Failure::Usage(format!("--set {set}: expected KEY=VALUE")));
        };
        let document = format!("value = {value}").parse::<toml::Table>().ok();
        let value = document.and_then(|mut document| document.remove("value"));
        let value = value.unwrap_or_else(|| {
            let (_, text) = set.split_once('=').unwrap_or_default();
            toml::Value::String(text.to_owned())
        });
        keys.insert(key.trim().to_owned(), value);
    }
    Ok(keys)
}

/// One line a law.
fn table(plugin: &PluginReport, only_broken: bool, terminal: &Terminal) -> String {
    let head = terminal.strong(&format!("{}.{}", plugin.stage, plugin.name));
    let origin = terminal.soft(&format!("{} {}", plugin.origin, plugin.version));
    let mut lines = vec![format!("{head}  {origin}")];
    for finding in &plugin.findings {
        let more = |words: &str| if words.is_empty() { String::new() } else { format!("  {words}") };
        match &finding.outcome {
            Outcome::Pass { .. } | Outcome::NotApplicable { .. } if only_broken => {}
            Outcome::Pass { found } => {
                let mark = terminal.good("✓");
                lines.push(format!("  {mark} {}{}", finding.law, terminal.soft(&more(found))));
            }
            Outcome::Fail { found, expected } => {
                lines.push(format!("  {} {}", terminal.bad("✗"), terminal.strong(finding.law)));
                lines.push(format!("      found     {found}"));
                let within = match finding.tolerance {
                    "" => String::new(),
                    tolerance => terminal.soft(&format!("  ({tolerance})")),
                };
                lines.push(format!("      expected  {expected}{within}"));
            }
            Outcome::NotApplicable { why } => {
                let words = format!("– {}{}", finding.law, more(why));
                lines.push(format!("  {}", terminal.soft(&words)));
            }
        }
    }
    lines.join("\n") + "\n"
}

fn summary(report: &Report, terminal: &Terminal) -> String {
    let [kept, broken, not_applicable] = report.tally();
    let n_plugins = report.plugins.len();
    let plugins = if n_plugins == 1 { "1 plugin".to_owned() } else { format!("{n_plugins} plugins") };
    let kept = terminal.good(&format!("{kept} laws kept"));
    let broken_words = format!("{broken} broken");
    let broken = if broken == 0 { broken_words } else { terminal.bad(&broken_words) };
    format!("{plugins}: {kept}, {broken}, {not_applicable} not applicable")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_from_names() {
        for file in ["target/libmine.so", "mine.so", "mine.dylib", "mine.dll", "folder\\mine", "./mine"] {
            assert!(is_file(file), "{file}");
        }
        for name in ["dp", "planner.dp", "lms200"] {
            assert!(!is_file(name), "{name}");
        }
    }

    #[test]
    fn keys_are_read_as_toml_and_bare_words_are_text() {
        let sets = ["gain=0.5", "speeds=[1, 2]", "file=maps/hall.yaml", "on=true"].map(str::to_owned);
        let keys = keys(&sets).unwrap();
        assert_eq!(keys["gain"].as_float(), Some(0.5));
        assert_eq!(keys["speeds"].as_array().map(Vec::len), Some(2));
        assert_eq!(keys["file"].as_str(), Some("maps/hall.yaml"));
        assert_eq!(keys["on"].as_bool(), Some(true));
        assert!(super::keys(&["nothing".to_owned()]).is_err());
    }
}
