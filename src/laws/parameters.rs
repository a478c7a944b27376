//! Laws of every plugin: what it says of its parameters and of itself is true.

use super::law::{Law, Trouble, Verdict, expect};
use super::ranges::{each_property, has_type, limits};
use super::subject::Subject;
use crate::plugins::parameters::parameters;
use rumbo_core::registry::{Entry, ParseFault, Stage};
use serde_json::Value;

/// Before a stage is built.
pub const LAWS: &[Law] = &[
    Law::new("its summary and every parameter are documented", documented),
    Law::new("its defaults are valid and read back as they were", defaults_are_valid),
    Law::new("a key that it does not know is refused", unknown_is_refused),
    Law::new("numbers that are not finite, and values of another type, are refused", nonsense_is_refused),
    Law::new("values outside the ranges of its schema are refused", ranges_are_kept),
    Law::new("what it declares fits its stage", manifest_fits),
];

/// Asked by the verification itself, which keeps what the answer needs.
pub const BUILDS: &Law = &Law::new("it can be built from its defaults", |_| Ok(String::new()));

fn documented(subject: &Subject) -> Verdict {
    let entry = &subject.entry;
    let summary = entry.summary.trim();
    expect(
        !summary.is_empty() && !summary.ends_with('.') && !summary.contains('\n'),
        || format!("the summary is {summary:?}"),
        "one line without a full stop",
    )?;
    let rows = parameters(entry);
    let bare: Vec<&str> =
        rows.iter().filter(|row| row.description.trim().is_empty()).map(|row| row.key.as_str()).collect();
    let found = || format!("no description of {}", bare.join(", "));
    expect(bare.is_empty(), found, "what each parameter does, in words")?;
    Ok(if rows.len() == 1 { "1 parameter".into() } else { format!("{} parameters", rows.len()) })
}

fn defaults_are_valid(subject: &Subject) -> Verdict {
    let entry = &subject.entry;
    let defaults = entry.source.defaults();
    let again = entry.source.parse(defaults.clone()).map_err(|fault| {
        let found = format!("the default of {} is refused: {}", fault.path, fault.message);
        Trouble::broken(found, "defaults that the plugin takes")
    })?;
    let found = || format!("{} came back as {}", one_line(&defaults), one_line(&again.parameters()));
    expect(again.parameters() == defaults, found, "the same values")?;
    let empty = |key: &str| defaults.get(key).and_then(toml::Value::as_str).is_some_and(str::is_empty);
    let known = |key: &str| defaults.contains_key(key) && !empty(key);
    // A key without a default must be given: that it is missing is no fault of the defaults.
    let faults = again.check();
    let fault = faults.iter().find(|fault| {
        let key = fault.path.split(['.', '[']).next().unwrap_or_default();
        key.is_empty() || known(key)
    });
    if let Some(fault) = fault {
        let found = format!("the default of {} {}", fault.path, fault.message);
        return Err(Trouble::broken(found, "defaults that the plugin takes"));
    }
    let schema = entry.source.schema();
    let mut outside = Vec::new();
    each_property(&schema, |key, property| {
        if let Some(number) = defaults.get(key).and_then(number_of)
            && let Some(limit) = limits(property).into_iter().find(|limit| !limit.allows(number))
        {
            outside.push(format!("the default of {key} is {number}, its schema says {}", limit.words()));
        }
    });
    expect(outside.is_empty(), || outside.join("; "), "defaults inside their own ranges")?;
    Ok(String::new())
}

fn unknown_is_refused(subject: &Subject) -> Verdict {
    const UNKNOWN: &str = "no_plugin_has_this_key";
    let entry = &subject.entry;
    let schema = entry.source.schema();
    let is_closed = schema.get("additionalProperties") == Some(&Value::Bool(false));
    expect(is_closed, || "its schema allows them".into(), "`additionalProperties: false`")?;
    let taken = takes(entry, UNKNOWN, toml::Value::Integer(1));
    expect(!taken, || format!("{UNKNOWN} = 1 is taken"), "an error that names the key")?;
    Ok(String::new())
}

fn nonsense_is_refused(subject: &Subject) -> Verdict {
    let entry = &subject.entry;
    let schema = entry.source.schema();
    let mut keys: Vec<(String, Option<toml::Value>)> =
        entry.source.defaults().into_iter().map(|(key, value)| (key, Some(value))).collect();
    // Numbers without a default.
    each_property(&schema, |key, property| {
        if has_type(property, "number") && !keys.iter().any(|(known, _)| known == key) {
            keys.push((key.to_owned(), None));
        }
    });
    let mut n_tried = 0;
    for (key, default) in keys {
        for (place, value) in variants(default.as_ref()) {
            n_tried += 1;
            let shown = value.to_string();
            let taken = takes(entry, &key, value);
            expect(!taken, || format!("{key}{place} = {shown} is taken"), "an error that names the key")?;
        }
    }
    Ok(format!("values tried: {n_tried}"))
}

/// The default with one of its numbers made impossible, or with another type, and where.
fn variants(default: Option<&toml::Value>) -> Vec<(String, toml::Value)> {
    let not_finite = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY].map(toml::Value::Float);
    let here = |values: &[toml::Value]| values.iter().map(|v| (String::new(), v.clone())).collect();
    match default {
        None => here(&not_finite),
        Some(toml::Value::Float(_)) => {
            let mut all: Vec<_> = here(&not_finite);
            all.push((String::new(), toml::Value::String("text".into())));
            all
        }
        Some(toml::Value::Integer(_) | toml::Value::Boolean(_)) => {
            here(&[toml::Value::String("text".into()), toml::Value::Float(f64::NAN)])
        }
        Some(toml::Value::String(_)) => here(&[toml::Value::Integer(1)]),
        Some(toml::Value::Array(items)) => {
            let inside = items.iter().enumerate().filter(|(_, item)| item.is_float()).map(|(k, _)| {
                let mut items = items.clone();
                if let Some(item) = items.get_mut(k) {
                    *item = toml::Value::Float(f64::NAN);
                }
                (format!("[{k}]"), toml::Value::Array(items))
            });
            inside.collect()
        }
        Some(toml::Value::Table(table)) => {
            let inside = table.iter().flat_map(|(key, value)| {
                variants(Some(value)).into_iter().map(move |(place, bad)| {
                    let mut table = table.clone();
                    table.insert(key.clone(), bad);
                    (format!(".{key}{place}"), toml::Value::Table(table))
                })
            });
            inside.collect()
        }
        Some(toml::Value::Datetime(_)) => Vec::new(),
    }
}

fn ranges_are_kept(subject: &Subject) -> Verdict {
    let entry = &subject.entry;
    let schema = entry.source.schema();
    let mut taken = Vec::new();
    let mut n_tried = 0;
    each_property(&schema, |key, property| {
        for limit in limits(property) {
            let outside = limit.outside();
            let value = if has_type(property, "integer") {
                toml::Value::Integer(outside as i64)
            } else {
                toml::Value::Float(outside)
            };
            n_tried += 1;
            if takes(entry, key, value) {
                taken.push(format!("{key} = {outside} is taken where its schema says {}", limit.words()));
            }
        }
    });
    if n_tried == 0 {
        return Err(Trouble::not_applicable("its schema names no range"));
    }
    expect(taken.is_empty(), || taken.join("; "), "an error that names the key")?;
    Ok(format!("values tried: {n_tried}"))
}

fn manifest_fits(subject: &Subject) -> Verdict {
    let stage = subject.entry.stage;
    let manifest = subject.manifest();
    let rates = [("default_rate_hz", manifest.default_rate_hz), ("max_rate_hz", manifest.max_rate_hz)];
    for (name, rate) in rates {
        let found = || format!("{name} is {rate:?}");
        expect(rate.is_none_or(|hz| hz > 0.0 && hz.is_finite()), found, "a finite number above zero")?;
    }
    expect(!manifest.drives.is_empty(), || "it steers no drive".into(), "at least one drive")?;
    if let [Some(usual), Some(most)] = rates.map(|(_, rate)| rate) {
        let found = || format!("it runs at {usual} Hz by default and at {most} Hz at most");
        expect(usual <= most, found, "a default that it can do")?;
    }
    let (what, is_there) = match stage {
        Stage::Sensor => ("observations that it makes", !manifest.produces.is_empty()),
        Stage::MapBuilder | Stage::Slam => ("layers that it gives", !manifest.gives_layers.is_empty()),
        _ => return Ok(String::new()),
    };
    expect(is_there, || "none are declared".into(), what)?;
    Ok(String::new())
}

/// The plugin takes its defaults with this one value in place of its own.
fn takes(entry: &Entry, key: &str, value: toml::Value) -> bool {
    // Of a key that must be given too nothing is known, so that only what is said of this key counts.
    let is_about = |path: &str| path.is_empty() || path.starts_with(key);
    let keys = toml::Table::from_iter([(key.to_owned(), value)]);
    match entry.source.parse(keys) {
        Err(ParseFault { .. }) => false,
        Ok(configured) => {
            let context = rumbo_core::stages::BuildContext {
                dry_run: true,
                ..rumbo_core::stages::BuildContext::bare("parameters")
            };
            let is_refused = configured.check().iter().any(|fault| is_about(&fault.path))
                || configured.build(&context).is_err_and(|fault| is_about(&fault.path));
            !is_refused
        }
    }
}

fn number_of(value: &toml::Value) -> Option<f64> {
    value.as_float().or_else(|| value.as_integer().map(|number| number as f64))
}

fn one_line(table: &toml::Table) -> String {
    table.to_string().trim().replace('\n', ", ")
}
