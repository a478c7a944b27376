//! Fields of sentences, by the letter of the standard: Rust's own numbers would let `nan`, `1e2` and signs through.

use super::Refusal;

/// Which of the two angles of a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// `ddmm.mmmm` with N or S.
    Latitude,
    /// `dddmm.mmmm` with E or W.
    Longitude,
}

impl Axis {
    fn name(self) -> &'static str {
        match self {
            Axis::Latitude => "latitude",
            Axis::Longitude => "longitude",
        }
    }

    fn n_digits(self) -> usize {
        match self {
            Axis::Latitude => 2,
            Axis::Longitude => 3,
        }
    }

    fn most_deg(self) -> f64 {
        match self {
            Axis::Latitude => 90.0,
            Axis::Longitude => 180.0,
        }
    }

    fn sign(self, hemisphere: &str) -> Option<f64> {
        match (self, hemisphere) {
            (Axis::Latitude, "N") | (Axis::Longitude, "E") => Some(1.0),
            (Axis::Latitude, "S") | (Axis::Longitude, "W") => Some(-1.0),
            _ => None,
        }
    }
}

/// Degrees of an angle written as degrees and minutes, negative for S and W.
pub fn degrees(axis: Axis, angle: &str, hemisphere: &str) -> Result<f64, Refusal> {
    let malformed = || Refusal::Field { field: axis.name() };
    let (whole, minutes) = angle.split_at_checked(axis.n_digits()).ok_or_else(malformed)?;
    let has_minutes = minutes.split('.').next().is_some_and(|digits| digits.len() == 2);
    let (whole_deg, minutes) = (decimal(whole), decimal(minutes));
    let (Some(whole_deg), Some(minutes), true) = (whole_deg, minutes, has_minutes) else {
        return Err(malformed());
    };
    let sign = axis.sign(hemisphere).ok_or(Refusal::Field { field: "hemisphere" })?;
    if minutes >= 60.0 {
        return Err(Refusal::Range { field: "minutes" });
    }
    let angle_deg = whole_deg + minutes / 60.0;
    if angle_deg > axis.most_deg() {
        return Err(Refusal::Range { field: axis.name() });
    }
    Ok(sign * angle_deg)
}

/// Seconds of the day of `hhmmss.sss`; a leap second is one.
pub fn utc_s(text: &str) -> Result<f64, Refusal> {
    let malformed = || Refusal::Field { field: "time" };
    let (hours, rest) = text.split_at_checked(2).ok_or_else(malformed)?;
    let (minutes, seconds) = rest.split_at_checked(2).ok_or_else(malformed)?;
    let has_seconds = seconds.split('.').next().is_some_and(|digits| digits.len() == 2);
    let (Some(hours), Some(minutes), Some(seconds), true) =
        (decimal(hours), decimal(minutes), decimal(seconds), has_seconds)
    else {
        return Err(malformed());
    };
    if hours >= 24.0 || minutes >= 60.0 || seconds >= 61.0 {
        return Err(Refusal::Range { field: "time" });
    }
    Ok(hours * 3600.0 + minutes * 60.0 + seconds)
}

/// Digits with at most one point among or after them: no sign, no exponent, no words.
pub(super) fn decimal(text: &str) -> Option<f64> {
    let begins_with_digit = text.bytes().next().is_some_and(|byte| byte.is_ascii_digit());
    let n_points = text.bytes().filter(|byte| *byte == b'.').count();
    let is_decimal = text.bytes().all(|byte| byte.is_ascii_digit() || byte == b'.');
    (begins_with_digit && is_decimal && n_points <= 1).then(|| text.parse().ok()).flatten()
}

/// A decimal that may be negative.
pub(super) fn signed_decimal(text: &str) -> Option<f64> {
    text.strip_prefix('-').map_or_else(|| decimal(text), |rest| decimal(rest).map(|value| -value))
}

/// What an empty field is: nothing; else what `read` makes of it, or the fault of this field.
pub(super) fn optional<T>(
    text: &str,
    field: &'static str,
    read: impl FnOnce(&str) -> Option<T>,
) -> Result<Option<T>, Refusal> {
    if text.is_empty() {
        return Ok(None);
    }
    read(text).map(Some).ok_or(Refusal::Field { field })
}
