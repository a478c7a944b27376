//! Ranges that schemas state.

use crate::plugins::parameters::resolve;
use serde_json::Value;

/// One end of a range.
pub struct Limit {
    value: f64,
    is_lower: bool,
    is_open: bool,
}

impl Limit {
    /// The number lies inside.
    pub fn allows(&self, number: f64) -> bool {
        let room = if self.is_lower { number - self.value } else { self.value - number };
        if self.is_open { room > 0.0 } else { room >= 0.0 }
    }

    /// A number just beyond.
    pub fn outside(&self) -> f64 {
        if self.is_lower { self.value - 1.0 } else { self.value + 1.0 }
    }

    /// For reports.
    pub fn words(&self) -> String {
        let sign = match (self.is_lower, self.is_open) {
            (true, true) => "above",
            (true, false) => "at least",
            (false, true) => "below",
            (false, false) => "at most",
        };
        format!("{sign} {}", self.value)
    }
}

/// The ends of a parameter's range, as its schema has them.
pub fn limits(property: &Value) -> Vec<Limit> {
    [
        ("minimum", true, false),
        ("exclusiveMinimum", true, true),
        ("maximum", false, false),
        ("exclusiveMaximum", false, true),
    ]
    .into_iter()
    .filter_map(|(word, is_lower, is_open)| {
        property.get(word).and_then(Value::as_f64).map(|value| Limit { value, is_lower, is_open })
    })
    .collect()
}

/// Looks at every parameter of a schema.
pub fn each_property(schema: &Value, mut look: impl FnMut(&str, &Value)) {
    let properties = schema.get("properties").and_then(Value::as_object);
    for (key, property) in properties.into_iter().flatten() {
        look(key, resolve(schema, property));
    }
}

/// The parameter takes values of this JSON type.
pub fn has_type(property: &Value, name: &str) -> bool {
    match property.get("type") {
        Some(Value::String(kind)) => kind == name,
        Some(Value::Array(kinds)) => kinds.iter().any(|kind| kind == name),
        _ => false,
    }
}
