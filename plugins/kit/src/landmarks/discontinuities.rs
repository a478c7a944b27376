//! Jumps of the range. Hernández Alamilla (2005), section 4.4.1.

use super::LandmarkSettings;
use super::readings::{Reading, cross, way};

/// What lies between a reading and the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Gap {
    /// The same surface.
    None,
    /// A jump of the range.
    Jump,
    /// A beam without a reading: nobody knows.
    Unknown,
}

/// What parts reading `idx` from the next.
pub(super) fn gap_after(readings: &[Reading], idx: usize, settings: &LandmarkSettings) -> Gap {
    let (Some(here), Some(next)) = (readings.get(idx), readings.get(idx + 1)) else { return Gap::Unknown };
    if !(here.is_valid() && next.is_valid()) {
        return Gap::Unknown;
    }
    if (next.range_m - here.range_m).abs() <= settings.discontinuity_m {
        return Gap::None;
    }
    let is_one_wall = settings.spares_grazed_walls
        && (goes_on(readings, [idx.checked_sub(1), Some(idx), Some(idx + 1)], settings)
            || goes_on(readings, [Some(idx + 2), Some(idx + 1), Some(idx)], settings));
    if is_one_wall { Gap::None } else { Gap::Jump }
}

/// A wall whose line passes nearer to the sensor than this cannot be seen: the robot would stand in it. Readings on such a
/// line lie one behind the other along one beam, meters.
const LEAST_WALL_DISTANCE_M: f64 = 0.15;
/// Steps between readings along a wall grow slowly, even where beams graze it; one that is longer than this many times
/// the step before says nothing about its line.
const MOST_GROWTH: f64 = 4.0;

/// At grazing incidence neighboring readings of one flat wall differ by more than a discontinuity does: the third reading
/// lies on the line through the first two. This is not in the source.
fn goes_on(readings: &[Reading], idxs: [Option<usize>; 3], settings: &LandmarkSettings) -> bool {
    let [Some(a), Some(b), Some(c)] = idxs.map(|idx| readings.get(idx?).filter(|r| r.is_valid())) else {
        return false;
    };
    let (step, on) = (way(a, b), way(a, c));
    let length = step[0].hypot(step[1]);
    let last = way(b, c);
    let is_even = last[0].hypot(last[1]) <= MOST_GROWTH * length;
    let is_on_line = cross(step, on).abs() <= settings.unevenness_m() * length;
    let is_apart = cross(step, a.place).abs() >= LEAST_WALL_DISTANCE_M * length;
    length > 0.0 && is_even && is_on_line && is_apart
}
