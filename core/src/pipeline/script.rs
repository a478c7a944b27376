//! A scripted drive: what the robot shall do at which time, from a file.

use crate::frames::Twist;
use crate::time::Span;
use csv::{ReaderBuilder, StringRecord, Trim};
use std::fmt;
use std::path::Path;

/// Velocities with the time from which each holds until the next; the drive ends with the last.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Script {
    /// Since the start of the drive, each later than the one before.
    rows: Vec<(Span, Twist)>,
}

/// Everything that is wrong with a script, as far as it is told.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ScriptError(Vec<String>);

impl fmt::Display for ScriptError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.join("; "))
    }
}

impl std::error::Error for ScriptError {}

/// Faults of one file that are told; more of the same help nobody.
const MOST_FAULTS: usize = 10;
/// A file with more rows than this is no drive: three hours at a hundred a second.
const MOST_ROWS: usize = 1_000_000;
/// The columns; the last may be absent.
const COLUMNS: [&str; 4] = ["t_s", "forward_m_s", "turn_deg_s", "left_m_s"];
/// Beyond this a number is none that a robot drives or lives through.
const MOST: f64 = 1e6;

impl Script {
    /// Reads a table with the columns `t_s`, `forward_m_s`, `turn_deg_s` and, for robots that can, `left_m_s`; lines that
    /// begin with `#` are left out.
    pub fn read(path: &Path) -> Result<Script, ScriptError> {
        let file = std::fs::File::open(path)
            .map_err(|error| ScriptError(vec![format!("cannot read {}: {error}", path.display())]))?;
        Script::parse(file, &path.display().to_string())
    }

    /// As [`read`](Self::read), of a text; `name` is shown in messages.
    pub fn parse(text: impl std::io::Read, name: &str) -> Result<Script, ScriptError> {
        let mut reader =
            ReaderBuilder::new().trim(Trim::All).comment(Some(b'#')).flexible(true).from_reader(text);
        let mut faults = Vec::new();
        let places = match reader.headers() {
            Ok(header) => columns(header, name, &mut faults),
            Err(error) => return Err(ScriptError(vec![format!("{name}: {error}")])),
        };
        let mut rows: Vec<(Span, Twist)> = Vec::new();
        for record in reader.records() {
            if !faults.is_empty() && (rows.is_empty() || faults.len() >= MOST_FAULTS) {
                break;
            }
            match record {
                Ok(record) => {
                    let line = record.position().map_or(0, |position| position.line());
                    match row(&record, &places, rows.last().map(|(at, _)| *at)) {
                        Ok(row) => rows.push(row),
                        Err(fault) => faults.push(format!("{name}:{line}: {fault}")),
                    }
                }
                Err(error) => {
                    faults.push(format!("{name}: {error}"));
                    break;
                }
            }
            if rows.len() > MOST_ROWS {
                faults.push(format!("{name}: has more than {MOST_ROWS} rows"));
                break;
            }
        }
        if faults.is_empty() && rows.len() < 2 {
            let n = rows.len();
            faults.push(format!(
                "{name}: has {n} rows, expected two at least: a velocity and the time it ends"
            ));
        }
        if faults.is_empty() { Ok(Script { rows }) } else { Err(ScriptError(faults)) }
    }

    /// The velocity so long after the start; none when the drive is over.
    pub fn at(&self, since_start: Span) -> Option<Twist> {
        let n_begun = self.rows.partition_point(|(at, _)| *at <= since_start);
        if n_begun == self.rows.len() {
            return None;
        }
        Some(
            n_begun
                .checked_sub(1)
                .and_then(|idx| self.rows.get(idx))
                .map_or(Twist::ZERO, |(_, twist)| *twist),
        )
    }

    /// How long it takes.
    pub fn length(&self) -> Span {
        self.rows.last().map_or(Span::ZERO, |(at, _)| *at)
    }
}

/// Where each column is.
fn columns(header: &StringRecord, name: &str, faults: &mut Vec<String>) -> [Option<usize>; 4] {
    let places = COLUMNS.map(|column| header.iter().position(|found| found == column));
    let missing = COLUMNS.iter().zip(&places).take(3).filter(|(_, place)| place.is_none());
    faults.extend(missing.map(|(column, _)| {
        format!(
            "{name}:1: has no column {column}; expected {}, and left_m_s where it is needed",
            COLUMNS[..3].join(",")
        )
    }));
    let unknown = header.iter().filter(|found| !COLUMNS.contains(found));
    faults.extend(unknown.map(|found| format!("{name}:1: has an unknown column `{found}`")));
    places
}

fn row(
    record: &StringRecord,
    places: &[Option<usize>; 4],
    before: Option<Span>,
) -> Result<(Span, Twist), String> {
    let mut numbers = [0.0; 4];
    for ((number, place), column) in numbers.iter_mut().zip(places).zip(COLUMNS) {
        let Some(place) = place else { continue };
        let text = record.get(*place).ok_or_else(|| format!("ends before {column}"))?;
        let is_sound = |number: &f64| number.abs() <= MOST;
        *number = text.parse().ok().filter(is_sound).ok_or_else(|| {
            format!("{column} is `{text}`, expected a number between -{MOST:e} and {MOST:e}")
        })?;
    }
    let [t_s, forward_m_s, turn_deg_s, left_m_s] = numbers;
    let at = Span::from_secs(t_s);
    if t_s < 0.0 || before.is_some_and(|before| at <= before) {
        let least =
            before.map_or("0 or later".to_owned(), |before| format!("later than {}", before.as_secs()));
        return Err(format!("t_s is {t_s}, expected {least}"));
    }
    Ok((at, Twist { forward_m_s, left_m_s, turn_rad_s: turn_deg_s.to_radians() }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Script, String> {
        Script::parse(text.as_bytes(), "drive.csv").map_err(|error| error.to_string())
    }

    #[test]
    fn each_velocity_holds_until_the_next_and_the_last_ends_the_drive() {
        let text = "# a curve\nt_s, forward_m_s, turn_deg_s\n0.5,0.2,0\n2,0.1,90\n3,0,0\n";
        let script = parse(text).unwrap();
        let at = |seconds: f64| script.at(Span::from_secs(seconds));
        assert_eq!(at(0.2), Some(Twist::ZERO));
        assert_eq!(at(0.5), Some(Twist::new(0.2, 0.0)));
        assert_eq!(at(2.999), Some(Twist::new(0.1, std::f64::consts::FRAC_PI_2)));
        assert_eq!((at(3.0), script.length()), (None, Span::from_secs(3.0)));
    }

    #[test]
    fn columns_may_come_in_any_order_and_sideways_is_optional() {
        let script = parse("turn_deg_s,t_s,left_m_s,forward_m_s\n0,0,0.3,0.1\n0,1,0,0\n").unwrap();
        let twist = Twist { forward_m_s: 0.1, left_m_s: 0.3, turn_rad_s: 0.0 };
        assert_eq!(script.at(Span::ZERO), Some(twist));
    }

    #[test]
    fn every_fault_has_its_line() {
        let header = "t_s,forward_m_s,turn_deg_s\n";
        let faults = |rows: &str| parse(&format!("{header}{rows}")).unwrap_err();
        assert_eq!(
            faults("0,0.1,0\n1,fast,0\n0,0.1,0\n2,NaN,0\n3,0.1\n"),
            "drive.csv:3: forward_m_s is `fast`, expected a number between -1e6 and 1e6; \
             drive.csv:4: t_s is 0, expected later than 0; \
             drive.csv:5: forward_m_s is `NaN`, expected a number between -1e6 and 1e6; \
             drive.csv:6: ends before turn_deg_s"
        );
        assert_eq!(faults("-1,0,0\n"), "drive.csv:2: t_s is -1, expected 0 or later");
        assert!(faults("0,1e300,0\n").contains("1e300"));
        assert!(faults("").contains("has 0 rows") && faults("0,1,0\n").contains("has 1 rows"));
        let unknown = parse("t,forward_m_s,turn_deg_s\n0,0,0\n").unwrap_err();
        assert!(unknown.contains("no column t_s") && unknown.contains("unknown column `t`"), "{unknown}");
        assert!(Script::parse(&b"t_s,forward_m_s,turn_deg_s\n\xff\xfe,0,0\n"[..], "d").is_err());
    }
}
