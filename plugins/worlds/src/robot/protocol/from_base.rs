//! What the base says.

use std::fmt;

use rumbo_core::robot::DriveKind;
use rumbo_core::stages::WheelMotion;

use super::fields::{BadLine, Fields, millionths, twist_text};
use super::{BaseIdentity, BumperGeometry, SonarGeometry, SonarReading, WheelReport};

/// No ring has more transducers: a line of more would be too long.
const MOST_SONARS: u32 = 64;
/// No ring has more bumpers: they are bits of one number.
const MOST_BUMPERS: u32 = 64;

/// How the base is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BaseStatus {
    /// The base's own clock, milliseconds.
    pub at_ms: u32,
    /// Voltage of the battery, millivolts.
    pub battery_mv: u32,
    /// The battery is nearly empty.
    pub is_battery_low: bool,
    /// The emergency stop is pressed: no motor runs.
    pub is_emergency: bool,
    /// The base has stopped because no command came.
    pub is_watchdog: bool,
    /// Number of the line with the newest command.
    pub last_command: u16,
}

/// A line of the base.
#[derive(Debug, Clone, PartialEq)]
pub enum FromBase {
    /// Who is there: the first answer to a hello.
    Base(BaseIdentity),
    /// Its sonars: the second answer.
    Sonars(SonarGeometry),
    /// Its bumpers: the third answer.
    Bumpers(BumperGeometry),
    /// The hello had another version than this one, which is the base's.
    No {
        /// The version of the base.
        version: u16,
    },
    /// How far the wheels have turned.
    Wheels(WheelReport),
    /// What the sonars say, in the order of the ring.
    Ranges {
        /// The base's own clock, milliseconds.
        at_ms: u32,
        /// One for each sonar.
        readings: Vec<SonarReading>,
    },
    /// Which bumpers are pressed: one bit each.
    Touch {
        /// The base's own clock, milliseconds.
        at_ms: u32,
        /// Bit k is bumper k.
        pressed: u64,
    },
    /// How the base is.
    State(BaseStatus),
    /// It has stopped and is silent from now on.
    Bye,
}

impl fmt::Display for FromBase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Base(base) => {
                let BaseIdentity { version, boot, drive, track_m, watchdog_s, name } = base;
                let (drive, track) = (drive.name().to_uppercase(), millionths(*track_m));
                write!(f, "BASE {version} {boot} {drive} {track} {} {name}", (watchdog_s * 1e3).round())
            }
            Self::Sonars(ring) => write!(
                f,
                "SONARS {} {} {} {} {} {} {}",
                ring.n_sonars,
                millionths(ring.first_bearing_rad),
                millionths(ring.bearing_step_rad),
                millionths(ring.cone_rad),
                millionths(ring.ring_radius_m),
                millionths(ring.min_range_m),
                millionths(ring.max_range_m),
            ),
            Self::Bumpers(ring) => write!(
                f,
                "BUMPERS {} {} {}",
                ring.n_bumpers,
                millionths(ring.first_bearing_rad),
                millionths(ring.bearing_step_rad)
            ),
            Self::No { version } => write!(f, "NO {version}"),
            Self::Wheels(report) => write_wheels(f, report),
            Self::Ranges { at_ms, readings } => {
                write!(f, "RANGES {at_ms}")?;
                readings.iter().try_for_each(|reading| match reading {
                    SonarReading::Echo(range_mm) => write!(f, " {range_mm}"),
                    SonarReading::Nothing => f.write_str(" -"),
                    SonarReading::Lost => f.write_str(" X"),
                })
            }
            Self::Touch { at_ms, pressed } => write!(f, "TOUCH {at_ms} {pressed:X}"),
            Self::State(status) => {
                let BaseStatus { at_ms, battery_mv, last_command, .. } = status;
                let [low, emergency, watchdog] =
                    [status.is_battery_low, status.is_emergency, status.is_watchdog].map(u8::from);
                write!(f, "STATE {at_ms} {battery_mv} {low} {emergency} {watchdog} {last_command}")
            }
            Self::Bye => f.write_str("BYE"),
        }
    }
}

fn write_wheels(f: &mut fmt::Formatter<'_>, report: &WheelReport) -> fmt::Result {
    let WheelReport { at_ms, wheels } = report;
    let [first_m, second_m, ..] = wheels.rolled_m;
    let numbers = [first_m, second_m, wheels.turned_rad, wheels.steering_rad].map(millionths);
    let [first, second, turned, steering] = numbers;
    write!(f, "WHEELS {at_ms} {first} {second} {turned} {steering} {}", twist_text(&wheels.twist))
}

const A_TIME: &str = "a time in ms";
const AN_ANGLE: &str = "an angle in urad";
const A_LENGTH: &str = "a length in um";

impl FromBase {
    /// What the text of a line means.
    pub fn parse(text: &str) -> Result<Self, BadLine> {
        let (word, rest) = Fields::of(text);
        match word {
            "BASE" => identity(Fields::new("BASE", rest)),
            "SONARS" => sonars(Fields::new("SONARS", rest)),
            "BUMPERS" => bumpers(Fields::new("BUMPERS", rest)),
            "NO" => {
                let mut fields = Fields::new("NO", rest);
                let read = Self::No { version: fields.number("a version")? };
                fields.end().map(|()| read)
            }
            "WHEELS" => wheels(Fields::new("WHEELS", rest)),
            "RANGES" => {
                let at_ms = Fields::new("RANGES", rest.clone()).number(A_TIME)?;
                let readings = rest.skip(1).map(reading).collect::<Result<Vec<_>, _>>()?;
                let fits = readings.len() <= MOST_SONARS as usize;
                if fits { Ok(Self::Ranges { at_ms, readings }) } else { Err(BadLine::Count("RANGES")) }
            }
            "TOUCH" => touch(Fields::new("TOUCH", rest)),
            "STATE" => state(Fields::new("STATE", rest)),
            "BYE" => Fields::new("BYE", rest).end().map(|()| Self::Bye),
            other => Err(BadLine::Unknown(other.to_owned())),
        }
    }
}

fn identity(mut fields: Fields<'_>) -> Result<FromBase, BadLine> {
    let (version, boot) = (fields.number("a version")?, fields.number("a number")?);
    let field = fields.text()?;
    let drive = DriveKind::ALL.iter().find(|kind| kind.name().eq_ignore_ascii_case(field)).copied();
    let expected = "DIFFERENTIAL, TRICYCLE or OMNIDIRECTIONAL";
    let drive = drive.ok_or_else(|| BadLine::Field { word: "BASE", field: field.to_owned(), expected })?;
    let track_m = fields.length(A_LENGTH)?;
    let watchdog_s = f64::from(fields.number::<u32>(A_TIME)?) / 1e3;
    let name = fields.text()?.to_owned();
    fields.end()?;
    Ok(FromBase::Base(BaseIdentity { version, boot, drive, track_m, watchdog_s, name }))
}

fn sonars(mut fields: Fields<'_>) -> Result<FromBase, BadLine> {
    let ring = SonarGeometry {
        n_sonars: fields.at_most(MOST_SONARS, "at most 64 sonars")?,
        first_bearing_rad: fields.length(AN_ANGLE)?,
        bearing_step_rad: fields.length(AN_ANGLE)?,
        cone_rad: fields.length(AN_ANGLE)?,
        ring_radius_m: fields.length(A_LENGTH)?,
        min_range_m: fields.length(A_LENGTH)?,
        max_range_m: fields.length(A_LENGTH)?,
    };
    fields.end().map(|()| FromBase::Sonars(ring))
}

fn bumpers(mut fields: Fields<'_>) -> Result<FromBase, BadLine> {
    let ring = BumperGeometry {
        n_bumpers: fields.at_most(MOST_BUMPERS, "at most 64 bumpers")?,
        first_bearing_rad: fields.length(AN_ANGLE)?,
        bearing_step_rad: fields.length(AN_ANGLE)?,
    };
    fields.end().map(|()| FromBase::Bumpers(ring))
}

fn wheels(mut fields: Fields<'_>) -> Result<FromBase, BadLine> {
    let at_ms = fields.number(A_TIME)?;
    let wheels = WheelMotion {
        rolled_m: [fields.length(A_LENGTH)?, fields.length(A_LENGTH)?, 0.0, 0.0],
        n_wheels: 2,
        turned_rad: fields.length(AN_ANGLE)?,
        steering_rad: fields.length(AN_ANGLE)?,
        twist: fields.twist()?,
    };
    fields.end().map(|()| FromBase::Wheels(WheelReport { at_ms, wheels }))
}

fn reading(field: &str) -> Result<SonarReading, BadLine> {
    let expected = "a range in mm, - or X";
    match field {
        "-" => Ok(SonarReading::Nothing),
        "X" => Ok(SonarReading::Lost),
        _ => field.parse().map(SonarReading::Echo).map_err(|_| BadLine::Field {
            word: "RANGES",
            field: field.to_owned(),
            expected,
        }),
    }
}

fn touch(mut fields: Fields<'_>) -> Result<FromBase, BadLine> {
    let (at_ms, field) = (fields.number(A_TIME)?, fields.text()?);
    let expected = "bits in hexadecimal";
    let wrong = |_| BadLine::Field { word: "TOUCH", field: field.to_owned(), expected };
    let pressed = u64::from_str_radix(field, 16).map_err(wrong)?;
    fields.end().map(|()| FromBase::Touch { at_ms, pressed })
}

fn state(mut fields: Fields<'_>) -> Result<FromBase, BadLine> {
    let status = BaseStatus {
        at_ms: fields.number(A_TIME)?,
        battery_mv: fields.number("a voltage in mV")?,
        is_battery_low: fields.flag()?,
        is_emergency: fields.flag()?,
        is_watchdog: fields.flag()?,
        last_command: fields.number("the number of a line")?,
    };
    fields.end().map(|()| FromBase::State(status))
}
