//! Where two messages of one layout begin to differ: the field, and both values.

use super::cdr::{CdrError, CdrReader};
use super::layout::Layout;
use std::collections::BTreeMap;
use std::fmt;

/// One number or text inside a message.
#[derive(Debug, Clone, PartialEq)]
enum Leaf {
    Whole(i128),
    /// By its bits: not-a-number equals itself, and zero differs from minus zero.
    Single(u32),
    Double(u64),
    Text(String),
}

impl fmt::Display for Leaf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Leaf::Whole(value) => value.fmt(f),
            Leaf::Single(bits) if f32::from_bits(*bits).is_nan() => write!(f, "NaN ({bits:#010x})"),
            Leaf::Single(bits) => write!(f, "{:?}", f32::from_bits(*bits)),
            Leaf::Double(bits) if f64::from_bits(*bits).is_nan() => write!(f, "NaN ({bits:#018x})"),
            Leaf::Double(bits) => write!(f, "{:?}", f64::from_bits(*bits)),
            Leaf::Text(text) => write!(f, "{text:?}"),
        }
    }
}

/// The first field in which two messages differ.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FieldDifference {
    /// The field, such as `ranges_m[17]`.
    pub field: String,
    /// What the first message holds.
    pub first: String,
    /// What the second holds.
    pub second: String,
}

/// The first field in which two messages differ; none where they are the same bytes.
pub fn first_difference(layout: &Layout, first: &[u8], second: &[u8]) -> Option<FieldDifference> {
    if first == second {
        return None;
    }
    let leaves = |message| leaves(layout, message).unwrap_or_default();
    let (a, b) = (leaves(first), leaves(second));
    let shown = |leaves: &[(String, Leaf)], idx: usize| {
        leaves.get(idx).map_or("nothing".to_owned(), |(_, leaf)| leaf.to_string())
    };
    let idx = (0..a.len().max(b.len())).find(|idx| a.get(*idx) != b.get(*idx));
    let Some(idx) = idx else {
        // The same values in other bytes: padding, or a message that cannot be read.
        let (first, second) = (format!("{} bytes", first.len()), format!("{} bytes", second.len()));
        return Some(FieldDifference { field: "bytes".to_owned(), first, second });
    };
    let field = a.get(idx).or(b.get(idx)).map(|(field, _)| field.clone()).unwrap_or_default();
    Some(FieldDifference { field, first: shown(&a, idx), second: shown(&b, idx) })
}

/// All values of a message with the names of their fields.
fn leaves(layout: &Layout, message: &[u8]) -> Result<Vec<(String, Leaf)>, CdrError> {
    let kinds = kinds(layout);
    let mut walk = Walk { kinds: &kinds, reader: CdrReader::new(message)?, leaves: Vec::new() };
    walk.kind("", "", 0)?;
    Ok(walk.leaves)
}

/// Fields as pairs of type and name.
type Fields<'a> = Vec<(&'a str, &'a str)>;

/// The fields of each kind in a layout; those of the message itself under the empty name.
fn kinds(layout: &Layout) -> BTreeMap<&str, Fields<'_>> {
    let mut kinds = BTreeMap::new();
    let mut name = "";
    for line in layout.text.lines() {
        if let Some(next) = line.strip_prefix("MSG: ") {
            name = next;
        } else if let Some(field) = line.split_once(' ') {
            kinds.entry(name).or_insert_with(Vec::new).push(field);
        }
    }
    kinds
}

struct Walk<'a> {
    kinds: &'a BTreeMap<&'a str, Fields<'a>>,
    reader: CdrReader<'a>,
    leaves: Vec<(String, Leaf)>,
}

impl Walk<'_> {
    /// Layouts of our own are three kinds deep at most.
    const DEEPEST: usize = 8;

    fn kind(&mut self, kind: &str, path: &str, depth: usize) -> Result<(), CdrError> {
        let kinds = self.kinds;
        let fields = kinds.get(kind).filter(|_| depth < Self::DEEPEST);
        let unknown =
            || CdrError::Value { field: "layout", found: kind.to_owned(), expected: "a kind of this layout" };
        for (kind, name) in fields.ok_or_else(unknown)? {
            let path = if path.is_empty() { (*name).to_owned() } else { format!("{path}.{name}") };
            self.field(kind, &path, depth)?;
        }
        Ok(())
    }

    fn field(&mut self, kind: &str, path: &str, depth: usize) -> Result<(), CdrError> {
        let Some((item, len)) = kind.strip_suffix(']').and_then(|kind| kind.split_once('[')) else {
            return self.one(kind, path, depth);
        };
        let len = match len.parse() {
            Ok(len) => len,
            Err(_) => {
                let len = self.reader.length(1)?;
                self.leaves.push((format!("{path}.length"), Leaf::Whole(len as i128)));
                len
            }
        };
        (0..len).try_for_each(|idx| self.one(item, &format!("{path}[{idx}]"), depth))
    }

    fn one(&mut self, kind: &str, path: &str, depth: usize) -> Result<(), CdrError> {
        let reader = &mut self.reader;
        let leaf = match kind {
            "bool" | "uint8" => Leaf::Whole(reader.u8()?.into()),
            "uint16" => Leaf::Whole(reader.u16()?.into()),
            "uint32" => Leaf::Whole(reader.u32()?.into()),
            "int32" => Leaf::Whole(reader.i32()?.into()),
            "uint64" => Leaf::Whole(reader.u64()?.into()),
            "int64" => Leaf::Whole(reader.i64()?.into()),
            "float32" => Leaf::Single(reader.f32()?.to_bits()),
            "float64" => Leaf::Double(reader.f64()?.to_bits()),
            "string" => Leaf::Text(reader.text()?),
            nested => return self.kind(nested, path, depth + 1),
        };
        self.leaves.push((path.to_owned(), leaf));
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::cdr::CdrWriter;
    use super::super::layout::PATH;
    use super::*;

    fn path(yaw: Option<f64>, second: [f64; 2]) -> Vec<u8> {
        let mut cdr = CdrWriter::default();
        cdr.begin().u64(1);
        cdr.f64s(&[2.0]);
        cdr.length(2);
        for position in [[0.0, 0.5], second] {
            cdr.array(&position);
            cdr.f64s(yaw.as_slice());
        }
        cdr.bytes().to_vec()
    }

    #[test]
    fn the_first_field_that_differs_is_named_with_both_values() {
        let told = |a: &[u8], b: &[u8]| first_difference(&PATH, a, b).map(|d| (d.field, d.first, d.second));
        let same = path(None, [1.0, 2.0]);
        assert_eq!(told(&same, &same), None);
        let moved = path(None, [1.0, -0.0]);
        let expected = ("points[1].position[1]".to_owned(), "2.0".to_owned(), "-0.0".to_owned());
        assert_eq!(told(&same, &moved), Some(expected));
        let turned = path(Some(f64::NAN), [1.0, 2.0]);
        assert_eq!(told(&same, &turned).unwrap().0, "points[0].yaw_rad.length");
        let bits = f64::from_bits(f64::NAN.to_bits() + 1);
        let (_, first, second) = told(&turned, &path(Some(bits), [1.0, 2.0])).unwrap();
        assert_eq!(
            (first.as_str(), second.as_str()),
            ("NaN (0x7ff8000000000000)", "NaN (0x7ff8000000000001)")
        );
        assert_eq!(told(&same, &same[..20]).unwrap().0, "number", "a message that cannot be read");
    }
}
