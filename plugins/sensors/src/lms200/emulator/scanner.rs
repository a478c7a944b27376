//! The measuring part: ranges into values.

use rumbo_core::time::{Span, Time};

use super::Ranges;
use crate::lms200::protocol::{Configuration, CountUnit, MeasuringMode, Variant};

/// Turns of the mirror in a second.
const MIRROR_HZ: u64 = 75;

/// How long so many turns take.
pub(super) fn time_of_turns(n_turns: u64) -> Span {
    Span((n_turns * 1_000_000_000 / MIRROR_HZ) as i64)
}

/// Turns that are complete after this time.
pub(super) fn turns_in(span: Span) -> u64 {
    // A turn ends at the nanosecond below its exact end.
    (u64::try_from(span.0).unwrap_or(0) + 1) * MIRROR_HZ / 1_000_000_000
}

pub(super) struct Scanner {
    pub ranges: Ranges,
}

impl Scanner {
    /// Values of a scan, from right to left; the partial scan of this number when there is one.
    pub fn words(
        &mut self,
        variant: Variant,
        partial: Option<u8>,
        configuration: &Configuration,
        at: Time,
    ) -> Vec<u16> {
        let (unit, mode) = units(configuration);
        let step_deg = if partial.is_some() { 1.0 } else { f64::from(variant.resolution_centideg) / 100.0 };
        let first_deg = 0.25 * f64::from(partial.unwrap_or(0)) - f64::from(variant.field_deg) / 2.0;
        let n_values = match partial {
            None => variant.n_values(),
            // A shifted partial scan has no room for the last value.
            Some(number) => usize::from(variant.field_deg) + usize::from(number == 0),
        };
        (0..n_values)
            .map(|idx| {
                let bearing_rad = (first_deg + step_deg * idx as f64).to_radians();
                let seen = (self.ranges)(bearing_rad, at);
                let count = seen.and_then(|(range_m, _)| count_of(range_m, unit));
                mode.word(count, seen.map_or(0, |(_, level)| level_flags(mode, level)))
            })
            .collect()
    }

    /// Mean over scans that end here, one scan apart, without flags; a value that one scan does not have has no mean.
    pub fn mean_words(
        &mut self,
        variant: Variant,
        n_scans: u8,
        configuration: &Configuration,
        at: Time,
    ) -> Vec<u16> {
        let (unit, mode) = units(configuration);
        (0..variant.n_values())
            .map(|idx| {
                let bearing_deg = f64::from(variant.resolution_centideg) / 100.0 * idx as f64
                    - f64::from(variant.field_deg) / 2.0;
                let sum_m = (0..n_scans).try_fold(0.0, |sum_m, scan| {
                    let ago = time_of_turns(u64::from(variant.n_turns()) * u64::from(scan));
                    (self.ranges)(bearing_deg.to_radians(), at - ago).map(|(range_m, _)| sum_m + range_m)
                });
                let mean_m = sum_m.map(|sum_m| sum_m / f64::from(n_scans.max(1)));
                mode.word(mean_m.and_then(|mean_m| count_of(mean_m, unit)), 0)
            })
            .collect()
    }
}

/// Unit and measuring mode in force.
pub(super) fn units(configuration: &Configuration) -> (CountUnit, MeasuringMode) {
    (
        configuration.unit().unwrap_or(CountUnit::Centimeters),
        configuration.measuring_mode().unwrap_or(MeasuringMode::FieldsAbDazzle),
    )
}

/// The nearest count, half away from zero; none where 16 bits do not suffice.
fn count_of(range_m: f64, unit: CountUnit) -> Option<u16> {
    let count = (range_m * unit.per_meter()).round();
    (0.0..=f64::from(u16::MAX)).contains(&count).then_some(count as u16)
}

/// The level in as many bits as the mode has.
fn level_flags(mode: MeasuringMode, level: u8) -> u8 {
    match mode {
        MeasuringMode::Reflector8 => level & 0b111,
        MeasuringMode::Reflector4 => level >> 1 & 0b11,
        MeasuringMode::Reflector2 => level >> 2 & 0b1,
        _ => 0,
    }
}
