//! One position and heading from many estimates. Hernández Alamilla (2005), sections 5.3.5 and 5.4.

use super::correspondence::Relation;
use rumbo_core::frames::wrap_angle;

/// Weight of the odometry among estimates by pairs (equation 5.25).
pub const ODOMETRY_WEIGHT: f64 = 0.5;

/// An estimate with its weight.
pub type Weighted = ([f64; 2], f64);

/// The weighted mean (equations 5.25 to 5.27). None without weight.
pub fn weighted_mean(estimates: &[Weighted]) -> Option<[f64; 2]> {
    let total: f64 = estimates.iter().map(|(_, weight)| weight).sum();
    let sum = |axis: usize| estimates.iter().map(|(place, weight)| weight * place[axis]).sum::<f64>();
    (total > 0.0).then(|| [sum(0) / total, sum(1) / total])
}

/// Drops estimates farther than `within_m` from the median of each coordinate. This is not in the source.
pub fn drop_far(estimates: &mut Vec<Weighted>, within_m: f64) {
    let median_of = |axis: usize| median(estimates.iter().map(|(place, _)| place[axis]).collect());
    let middle = [median_of(0), median_of(1)];
    estimates.retain(|(place, _)| (place[0] - middle[0]).hypot(place[1] - middle[1]) <= within_m);
}

/// The middle value, or the mean of the two in the middle; zero of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let at = |idx: usize| values.get(idx).copied().unwrap_or_default();
    match values.len() {
        0 => 0.0,
        n if n % 2 == 1 => at(n / 2),
        n => (at(n / 2 - 1) + at(n / 2)) / 2.0,
    }
}

/// By how much the robot turned, from each relation: the bearing at which the landmark would be seen from the new position
/// with the old heading, less the one at which it is seen (equation 5.28, whose printed sign is the opposite one).
pub fn turns(relations: &[Relation], [x, y]: [f64; 2]) -> Vec<f64> {
    let turn = |relation: &Relation| {
        let expected = if relation.known.is_wall() {
            relation.known.bearing_rad
        } else {
            let [mark_x, mark_y] = relation.known.position();
            (mark_y - y).atan2(mark_x - x)
        };
        wrap_angle(expected - relation.seen.bearing_rad)
    };
    relations.iter().map(turn).collect()
}

/// The mean of angles by their sines and cosines: the plain mean of the source (equation 5.29) fails at the half turn.
/// None of none.
pub fn circular_mean(angles_rad: &[f64]) -> Option<f64> {
    let sum = |of: fn(f64) -> f64| angles_rad.iter().map(|angle| of(*angle)).sum::<f64>();
    (!angles_rad.is_empty()).then(|| sum(f64::sin).atan2(sum(f64::cos)))
}
