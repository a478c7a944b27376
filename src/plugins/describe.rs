//! One plugin, as text and as JSON.

use super::parameters::{Parameter, description, inline, parameters};
use super::summary;
use crate::terminal::Terminal;
use rumbo_core::registry::{Entry, Manifest, Stage};
use rumbo_core::robot::DriveKind;
use serde_json::{Value, json};
use std::fmt::Write as _;

/// Needs and gifts with the default parameters; none where the plugin cannot be understood without some.
pub fn manifest(entry: &Entry) -> Option<Manifest> {
    entry.source.parse(toml::Table::new()).ok().map(|configured| configured.manifest())
}

/// Needs and gifts in words: what, and which.
pub fn needs_and_gives(manifest: &Manifest) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    let mut add = |what, names: Vec<String>| {
        if !names.is_empty() {
            lines.push((what, names.join(", ")));
        }
    };
    add("reads map layers", manifest.needs_layers.iter().map(|l| l.name().to_owned()).collect());
    add("writes map layers", manifest.gives_layers.iter().map(|l| l.name().to_owned()).collect());
    let group = |kinds: &Vec<rumbo_core::messages::ObservationKind>| {
        kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(" or ")
    };
    add("needs observations", manifest.consumes.iter().map(group).collect());
    add("uses where present", manifest.uses.iter().map(|k| k.name().to_owned()).collect());
    add("makes observations", manifest.produces.iter().map(|k| k.name().to_owned()).collect());
    if manifest.drives.len() < DriveKind::ALL.len() {
        add("steers drives", manifest.drives.iter().map(|d| d.name().to_owned()).collect());
    }
    add("runs by default", manifest.default_rate_hz.map(|hz| format!("{hz} Hz")).into_iter().collect());
    add("runs at most", manifest.max_rate_hz.map(|hz| format!("{hz} Hz")).into_iter().collect());
    if manifest.is_virtual {
        add("takes", vec!["`inputs`: other sensors' observations".into()]);
    }
    if manifest.wishes_motion {
        add("asks for", vec!["motion while it looks for the robot".into()]);
    }
    lines
}

/// A section with every default, ready to be copied.
pub fn example(entry: &Entry) -> String {
    let mut text = match entry.stage {
        Stage::Sensor => "[[sensor]]\nname = \"my_sensor\"\n".to_owned(),
        stage => format!("[{}]\n", stage.section()),
    };
    let _ = writeln!(text, "plugin = \"{}\"", entry.name);
    for (key, value) in entry.source.defaults() {
        let _ = writeln!(text, "{key} = {}", inline(&value));
    }
    text
}

/// For people.
pub fn as_text(entry: &Entry, terminal: &Terminal) -> String {
    let mut text = format!("{} — {}\n", entry.name, entry.summary);
    let _ = writeln!(
        text,
        "section [{}], version {}, from {}",
        entry.stage.section(),
        entry.version,
        entry.origin
    );
    let about = description(entry);
    if !about.is_empty() {
        let _ = writeln!(text, "\n{about}");
    }
    let lines = manifest(entry).map(|manifest| needs_and_gives(&manifest)).unwrap_or_default();
    if !lines.is_empty() {
        text.push('\n');
    }
    for (what, which) in lines {
        let _ = writeln!(text, "{what}: {which}");
    }
    let rows = parameters(entry);
    if !rows.is_empty() {
        text.push_str("\nParameters:\n");
    }
    for row in rows {
        let _ = writeln!(text, "  {} ({}){}", row.key, kind(&row), default(&row));
        for line in row.description.lines() {
            let _ = writeln!(text, "      {}", line.trim());
        }
    }
    let _ = write!(text, "\nExample:\n\n{}", example(entry));
    let _ = terminal;
    text
}

/// What a parameter takes, with its unit.
pub fn kind(row: &Parameter) -> String {
    row.unit.map_or(row.takes.clone(), |unit| format!("{}, {unit}", row.takes))
}

fn default(row: &Parameter) -> String {
    row.default.as_ref().map(|default| format!(" = {default}")).unwrap_or_default()
}

/// For programs.
pub fn as_json(entry: &Entry) -> Value {
    let mut value = summary(entry);
    if let Some(fields) = value.as_object_mut() {
        fields.insert("description".into(), description(entry).into());
        fields.insert("manifest".into(), json!(manifest(entry)));
        fields.insert("parameters".into(), json!(parameters(entry)));
        fields.insert("schema".into(), entry.source.schema());
        fields.insert("example".into(), example(entry).into());
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::registry::Registry;

    #[test]
    fn every_example_is_toml_that_its_plugin_understands() {
        for entry in Registry::linked().unwrap().iter() {
            let document: toml::Table = toml::from_str(&example(entry)).unwrap();
            let section = &document[entry.stage.section()];
            let mut keys = section.as_array().map_or(section, |list| &list[0]).as_table().unwrap().clone();
            assert_eq!(keys.remove("plugin").unwrap().as_str().unwrap(), entry.name);
            keys.remove("name");
            assert!(entry.source.parse(keys).is_ok(), "{}", entry.name);
        }
    }
}
