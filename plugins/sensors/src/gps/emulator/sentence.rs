//! Sentences as a receiver writes them.

use rumbo_core::time::Time;

use crate::gps::nmea::{Axis, checksum};

/// A place on earth.
pub(super) struct Place {
    pub latitude_deg: f64,
    pub longitude_deg: f64,
    pub height_m: f64,
}

/// The receiver was switched on at noon, seconds of the day.
const SWITCHED_ON_S: f64 = 43_200.0;
const SECONDS_A_DAY: f64 = 86_400.0;
/// How high the map lies.
const GROUND_M: f64 = 830.0;
/// Minutes have four decimals.
const STEPS_A_DEGREE: u64 = 60 * 10_000;

/// GGA, GSA and RMC of a moment; a receiver without a place says so.
pub(super) fn lines(at: Time, place: Option<&Place>) -> [String; 3] {
    let time = time_of_day(at);
    let Some(place) = place else {
        return [
            whole(&format!("GPGGA,{time},,,,,0,00,,,M,,M,,0000")),
            whole("GPGSA,A,1,,,,,,,,,,,,,,,"),
            whole(&format!("GPRMC,{time},V,,,,,,,241115,,,N")),
        ];
    };
    let latitude = angle(Axis::Latitude, place.latitude_deg);
    let longitude = angle(Axis::Longitude, place.longitude_deg);
    let altitude_m = GROUND_M + place.height_m;
    [
        whole(&format!("GPGGA,{time},{latitude},{longitude},1,05,1.4,{altitude_m:.1},M,-4.3,M,,0000")),
        whole("GPGSA,A,3,15,12,24,06,25,,,,,,,,2.4,1.4,1.9"),
        whole(&format!("GPRMC,{time},A,{latitude},{longitude},0.00,,241115,,,A")),
    ]
}

fn whole(body: &str) -> String {
    format!("${body}*{:02X}\r\n", checksum(body.as_bytes()))
}

fn time_of_day(at: Time) -> String {
    // Rounded once, so that 59.9996 s is the next minute and not 60.000.
    let milliseconds = (((SWITCHED_ON_S + at.as_secs()).rem_euclid(SECONDS_A_DAY)) * 1000.0).round() as u64;
    let milliseconds = milliseconds % (SECONDS_A_DAY as u64 * 1000);
    let seconds = milliseconds / 1000;
    let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
    format!("{hours:02}{minutes:02}{:02}.{:03}", seconds % 60, milliseconds % 1000)
}

/// Degrees and minutes, with the hemisphere's letter.
fn angle(axis: Axis, degrees: f64) -> String {
    let steps = (degrees.abs() * STEPS_A_DEGREE as f64).round() as u64;
    let (whole, minutes) = (steps / STEPS_A_DEGREE, (steps % STEPS_A_DEGREE) as f64 / 10_000.0);
    match axis {
        Axis::Latitude => format!("{whole:02}{minutes:07.4},{}", if degrees < 0.0 { 'S' } else { 'N' }),
        Axis::Longitude => format!("{whole:03}{minutes:07.4},{}", if degrees < 0.0 { 'W' } else { 'E' }),
    }
}
