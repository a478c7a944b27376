//! GGA: a fix, or that there is none.

use super::Refusal;
use super::fields::{Axis, decimal, degrees, optional, signed_decimal, utc_s};

/// What a GGA sentence says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gga {
    /// The receiver knows where it is.
    Fix(Fix),
    /// It does not.
    NoFix {
        /// Seconds of the day, where it knows these.
        utc_s: Option<f64>,
    },
}

/// Where the receiver is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Seconds of the day.
    pub utc_s: Option<f64>,
    /// WGS-84, north positive.
    pub latitude_deg: f64,
    /// WGS-84, east positive.
    pub longitude_deg: f64,
    /// 1 single, 2 differential, others as receivers have them; never 0.
    pub quality: u32,
    /// Satellites in use.
    pub satellites: Option<u32>,
    /// Horizontal dilution of precision.
    pub hdop: Option<f64>,
    /// Over the geoid.
    pub altitude_m: Option<f64>,
    /// The geoid over the ellipsoid.
    pub geoid_separation_m: Option<f64>,
}

impl Fix {
    /// The fields of a GGA sentence after talker and type, by position: time, latitude, N or S, longitude, E or W,
    /// quality, satellites, dilution, altitude, M, geoid, M, age of corrections, station.
    pub fn of_fields<'a>(fields: impl Iterator<Item = &'a str>) -> Result<Gga, Refusal> {
        let fields: Vec<&str> = fields.collect();
        let [time, latitude, ns, longitude, ew, quality, satellites, hdop, rest @ ..] = fields.as_slice()
        else {
            return Err(Refusal::FieldCount { found: fields.len() });
        };
        let [altitude, altitude_unit, geoid, geoid_unit, age, _station] = rest else {
            return Err(Refusal::FieldCount { found: fields.len() });
        };
        let utc_s = if time.is_empty() { None } else { Some(utc_s(time)?) };
        let quality = whole(quality).ok_or(Refusal::Field { field: "quality" })?;
        for unit in [altitude_unit, geoid_unit] {
            if !matches!(*unit, "M" | "") {
                return Err(Refusal::Field { field: "unit" });
            }
        }
        optional(age, "age of corrections", decimal)?;
        let satellites = optional(satellites, "satellites", whole)?;
        let hdop = optional(hdop, "dilution", decimal)?;
        let altitude_m = optional(altitude, "altitude", signed_decimal)?;
        let geoid_separation_m = optional(geoid, "geoid separation", signed_decimal)?;
        // Whatever numbers it may still send: without a fix they are old ones.
        if quality == 0 || latitude.is_empty() || longitude.is_empty() {
            return Ok(Gga::NoFix { utc_s });
        }
        let latitude_deg = degrees(Axis::Latitude, latitude, ns)?;
        let longitude_deg = degrees(Axis::Longitude, longitude, ew)?;
        Ok(Gga::Fix(Fix {
            utc_s,
            latitude_deg,
            longitude_deg,
            quality,
            satellites,
            hdop,
            altitude_m,
            geoid_separation_m,
        }))
    }
}

fn whole(text: &str) -> Option<u32> {
    let is_whole = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    is_whole.then(|| text.parse().ok()).flatten()
}
