//! Files of marks: where each known mark is, in TOML, with as many `[[mark]]` tables as there are marks.
//!
//! All faults of a file are told at once, each with its line.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use thiserror::Error;
use toml::Spanned;

use crate::small_file::read_text;

/// A mark whose place is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkPlace {
    /// Which one.
    pub identity: u32,
    /// x and y in the map, meters.
    pub position_m: [f64; 2],
    /// Standard deviations of x and y, meters.
    pub deviation_m: [f64; 2],
}

/// Why a file of marks cannot be used.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MarkFileError {
    /// It cannot be read.
    #[error("{}: cannot read the marks: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It is not what it should be.
    #[error("{}", faults.iter().map(|(line, what)| format!("{}:{line}: {what}", path.display())).collect::<Vec<_>>().join("\n"))]
    Faults {
        /// The file.
        path: PathBuf,
        /// Line and sentence of each fault.
        faults: Vec<(usize, String)>,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    #[serde(default)]
    mark: Vec<Spanned<Told>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Told {
    identity: u32,
    x_m: f64,
    y_m: f64,
    #[serde(default)]
    deviation_m: f64,
}

/// No mark lies farther from the origin along an axis, meters.
const FARTHEST_M: f64 = 10_000.0;

/// Reads a file of marks: `identity` (whole number), `x_m`, `y_m` and `deviation_m` (0 if it is not there) of each.
///
/// # Errors
/// [`MarkFileError`] for a file that cannot be read or is wrong anywhere.
pub fn load_marks(path: &Path) -> Result<Vec<MarkPlace>, MarkFileError> {
    let unreadable = |source| MarkFileError::Unreadable { path: path.to_owned(), source };
    let text = read_text(path).map_err(unreadable)?;
    marks_of(&text).map_err(|faults| MarkFileError::Faults { path: path.to_owned(), faults })
}

fn marks_of(text: &str) -> Result<Vec<MarkPlace>, Vec<(usize, String)>> {
    let line_at = |offset: usize| 1 + text.bytes().take(offset).filter(|byte| *byte == b'\n').count();
    let document: Document = toml::from_str(text).map_err(|error| {
        let line = error.span().map_or(1, |span| line_at(span.start));
        vec![(line, error.message().to_owned())]
    })?;
    let (mut faults, mut places, mut lines) = (Vec::new(), Vec::new(), BTreeMap::new());
    for told in &document.mark {
        let line = line_at(told.span().start);
        let Told { identity, x_m, y_m, deviation_m } = *told.get_ref();
        for (key, value) in [("x_m", x_m), ("y_m", y_m)] {
            if !(-FARTHEST_M..=FARTHEST_M).contains(&value) {
                faults.push((
                    line,
                    format!("mark {identity}: {key} is {value}, expected at most {FARTHEST_M} m"),
                ));
            }
        }
        if !(0.0..=FARTHEST_M).contains(&deviation_m) {
            let message =
                format!("mark {identity}: deviation_m is {deviation_m}, expected a length of at least 0");
            faults.push((line, message));
        }
        if let Some(first) = lines.insert(identity, line) {
            faults.push((line, format!("mark {identity} is there twice, first in line {first}")));
        }
        places.push(MarkPlace { identity, position_m: [x_m, y_m], deviation_m: [deviation_m; 2] });
    }
    if document.mark.is_empty() {
        faults.push((
            1,
            "no marks; expected tables [[mark]] with identity, x_m, y_m and deviation_m".to_owned(),
        ));
    }
    if faults.is_empty() { Ok(places) } else { Err(faults) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_read_with_their_deviations() {
        let text = "[[mark]]\nidentity = 7\nx_m = 1.5\ny_m = -2.0\ndeviation_m = 0.01\n[[mark]]\nidentity = 9\nx_m = 0\ny_m = 3\n";
        let place = |identity, position_m, deviation_m| MarkPlace { identity, position_m, deviation_m };
        assert_eq!(
            marks_of(text).unwrap(),
            [place(7, [1.5, -2.0], [0.01; 2]), place(9, [0.0, 3.0], [0.0; 2])]
        );
    }

    #[test]
    fn every_fault_is_told_with_its_line() {
        let text = "# two\n[[mark]]\nidentity = 7\nx_m = nan\ny_m = -2.0\n[[mark]]\nidentity = 7\nx_m = 0.0\ny_m = 3.0\n\
                    deviation_m = -1.0\n";
        let faults = marks_of(text).unwrap_err();
        let told: Vec<String> = faults.iter().map(|(line, what)| format!("{line}: {what}")).collect();
        assert_eq!(
            told,
            [
                "2: mark 7: x_m is NaN, expected at most 10000 m",
                "6: mark 7: deviation_m is -1, expected a length of at least 0",
                "6: mark 7 is there twice, first in line 2"
            ]
        );
    }

    #[test]
    fn what_is_no_file_of_marks_is_said_to_be_none() {
        assert!(marks_of("").unwrap_err()[0].1.contains("no marks"));
        assert_eq!(marks_of("[[mark]]\nidentity = 1\nx_m = 2.0\n").unwrap_err()[0].0, 1);
        let unknown = marks_of("[[mark]]\nidentity = 1\nx_m = 2.0\ny_m = 1.0\nz_m = 3.0\n").unwrap_err();
        assert!(unknown[0].0 == 5 && unknown[0].1.contains("z_m"), "{unknown:?}");
        assert!(load_marks(Path::new("/nowhere/marks.toml")).unwrap_err().to_string().contains("nowhere"));
    }
}
