//! Reads one table of a spanned TOML document, collecting faults instead of stopping at the first.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::WorldFault;

/// Faults found so far, and the text they are in.
pub(super) struct Faults<'t> {
    text: &'t str,
    pub found: Vec<WorldFault>,
}

impl<'t> Faults<'t> {
    pub fn new(text: &'t str) -> Self {
        Self { text, found: Vec::new() }
    }

    pub fn add(&mut self, span: Range<usize>, key: String, message: String) {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() + 1;
        self.found.push(WorldFault { line, column, key, message, span });
    }
}

/// What a number must satisfy.
#[derive(Clone, Copy)]
pub(super) enum Must {
    BeFinite,
    BePositive,
    NotBeNegative,
}

impl Must {
    fn refuses(self, number: f64) -> Option<&'static str> {
        let (fine, expected) = match self {
            Self::BeFinite => (true, "a finite number"),
            Self::BePositive => (number > 0.0, "a finite number above 0"),
            Self::NotBeNegative => (number >= 0.0, "a finite number, 0 or more"),
        };
        (!(fine && number.is_finite())).then_some(expected)
    }
}

/// One table, such as the third `[[wall]]`.
pub(super) struct Section<'a, 'i, 't> {
    table: &'a DeTable<'i>,
    span: Range<usize>,
    path: String,
    known: Vec<&'static str>,
    faults: &'a mut Faults<'t>,
}

impl<'a, 'i, 't> Section<'a, 'i, 't> {
    pub fn new(table: &'a DeTable<'i>, span: Range<usize>, path: String, faults: &'a mut Faults<'t>) -> Self {
        Self { table, span, path, known: Vec::new(), faults }
    }

    fn key_path(&self, key: &str) -> String {
        if self.path.is_empty() { key.to_string() } else { format!("{}.{key}", self.path) }
    }

    /// The value of a key, which from now on is a known key of this table.
    fn value(&mut self, key: &'static str) -> Option<&'a Spanned<DeValue<'i>>> {
        self.known.push(key);
        self.table.get(key)
    }

    pub fn fault(&mut self, key: &'static str, message: String) {
        let span = self.table.get(key).map_or(self.span.clone(), Spanned::span);
        self.faults.add(span, self.key_path(key), message);
    }

    fn wrong_type(&mut self, key: &'static str, value: &DeValue<'i>, expected: &str) {
        self.fault(key, format!("found {}, expected {expected}", described(value)));
    }

    pub fn missing(&mut self, key: &'static str, expected: &str) {
        self.fault(key, format!("missing; expected {expected}"));
    }

    pub fn number(&mut self, key: &'static str, must: Must) -> Option<f64> {
        let value = self.value(key)?.get_ref();
        let Some(number) = as_number(value) else {
            self.wrong_type(key, value, "a number");
            return None;
        };
        if let Some(expected) = must.refuses(number) {
            self.fault(key, format!("is {number}, expected {expected}"));
            return None;
        }
        Some(number)
    }

    /// A number that must be there.
    pub fn needed_number(&mut self, key: &'static str, must: Must, expected: &str) -> Option<f64> {
        if self.table.get(key).is_none() {
            self.known.push(key);
            self.missing(key, expected);
            return None;
        }
        self.number(key, must)
    }

    /// A whole number that must be there.
    pub fn whole_number(&mut self, key: &'static str) -> Option<u32> {
        let Some(value) = self.value(key).map(Spanned::get_ref) else {
            self.missing(key, "a whole number");
            return None;
        };
        let number = as_number(value).filter(|n| n.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(n));
        if number.is_none() {
            self.wrong_type(key, value, "a whole number from 0 to 4294967295");
        }
        number.map(|number| number as u32)
    }

    pub fn text(&mut self, key: &'static str) -> Option<String> {
        let value = self.value(key)?.get_ref();
        let text = value.as_str().map(str::to_string);
        if text.is_none() {
            self.wrong_type(key, value, "text in quotes");
        }
        text
    }

    pub fn flag(&mut self, key: &'static str) -> Option<bool> {
        let value = self.value(key)?.get_ref();
        let flag = value.as_bool();
        if flag.is_none() {
            self.wrong_type(key, value, "true or false");
        }
        flag
    }

    /// One of a few words; the default when the key is absent.
    pub fn word<T: Copy>(&mut self, key: &'static str, words: &[(&str, T)], default: T) -> T {
        let Some(text) = self.text(key) else { return default };
        if let Some((_, meaning)) = words.iter().find(|(word, _)| *word == text) {
            return *meaning;
        }
        let list = words.iter().map(|(word, _)| format!("\"{word}\"")).collect::<Vec<_>>().join(" or ");
        self.fault(key, format!("is \"{text}\", expected {list}"));
        default
    }

    /// A list of exactly `N` finite numbers; its absence is a fault when `required`.
    pub fn numbers<const N: usize>(&mut self, key: &'static str, required: bool) -> Option<[f64; N]> {
        let expected = format!("a list of {N} finite numbers");
        let Some(value) = self.value(key).map(Spanned::get_ref) else {
            if required {
                self.missing(key, &expected);
            }
            return None;
        };
        let numbers = numbers_of(value);
        if numbers.is_none() {
            self.wrong_type(key, value, &expected);
        }
        numbers
    }

    /// A list of points.
    pub fn points(&mut self, key: &'static str) -> Vec<[f64; 2]> {
        let expected = "a list of points [[x, y], ...]";
        let Some(value) = self.value(key).map(Spanned::get_ref) else {
            self.missing(key, expected);
            return Vec::new();
        };
        let points = value.as_array().map(|list| list.iter().map(|p| numbers_of(p.get_ref())).collect());
        match points {
            Some(Some(points)) => points,
            _ => {
                self.wrong_type(key, value, expected);
                Vec::new()
            }
        }
    }

    /// Calls `read` for each table of an array of tables such as `[[wall]]`.
    pub fn tables(&mut self, key: &'static str, mut read: impl FnMut(&mut Section<'_, 'i, 't>)) {
        let Some(value) = self.value(key) else { return };
        let Some(list) = value.get_ref().as_array() else {
            return self.wrong_type(key, value.get_ref(), &format!("tables [[{key}]]"));
        };
        for (idx, item) in list.iter().enumerate() {
            let Some(table) = item.get_ref().as_table() else {
                self.wrong_type(key, item.get_ref(), &format!("tables [[{key}]]"));
                continue;
            };
            let mut section =
                Section::new(table, item.span(), self.key_path(&format!("{key}[{idx}]")), self.faults);
            read(&mut section);
            section.finish();
        }
    }

    /// Reports the keys nobody asked for.
    pub fn finish(self) {
        for (key, _) in self.table.iter().filter(|(key, _)| !self.known.contains(&key.get_ref().as_ref())) {
            let name = key.get_ref().as_ref();
            let nearest = self.known.iter().map(|known| (strsim::jaro_winkler(name, known), known));
            let message = match nearest.max_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((likeness, nearest)) if likeness > 0.8 => {
                    format!("unknown key, did you mean {nearest}?")
                }
                _ => format!("unknown key, expected one of {}", self.known.join(", ")),
            };
            self.faults.add(key.span(), self.key_path(name), message);
        }
    }
}

/// No place of a world lies farther from its origin along an axis, meters.
const FARTHEST_M: f64 = 10_000.0;

fn numbers_of<const N: usize>(value: &DeValue<'_>) -> Option<[f64; N]> {
    let list = value.as_array()?;
    let numbers: Option<Vec<f64>> = list
        .iter()
        .map(|item| as_number(item.get_ref()).filter(|number| number.abs() <= FARTHEST_M))
        .collect();
    numbers?.try_into().ok()
}

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|number| number as f64)
        }
        _ => None,
    }
}

fn described(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("\"{text}\""),
        DeValue::Integer(number) => number.as_str().to_string(),
        DeValue::Float(number) => number.as_str().to_string(),
        DeValue::Boolean(flag) => flag.to_string(),
        DeValue::Array(list)
            if list.iter().any(|item| as_number(item.get_ref()).is_some_and(|n| !n.is_finite())) =>
        {
            "a list with a number that is not finite".to_string()
        }
        DeValue::Array(list)
            if list.iter().any(|item| as_number(item.get_ref()).is_some_and(|n| n.abs() > FARTHEST_M)) =>
        {
            format!("a list with a number beyond {FARTHEST_M}")
        }
        DeValue::Array(list) => format!("a list of {}", list.len()),
        other => format!("a {}", other.type_str()),
    }
}
