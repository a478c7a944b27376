//! The rigid motion between paired points, in closed form.

use nalgebra::Vector2;
use rumbo_core::frames::Pose2;

/// The motion that takes the first of each pair nearest to the second, in the sense of weighted least squares: the turn is
/// `atan2(sum w (ax by - ay bx), sum w (ax bx + ay by))` of the centered points. None without points, or where they say
/// nothing about the turn.
pub fn align(pairs: impl Iterator<Item = (Vector2<f64>, Vector2<f64>, f64)> + Clone) -> Option<Pose2> {
    let (mut from, mut to, mut total) = (Vector2::zeros(), Vector2::zeros(), 0.0);
    for (p, q, weight) in pairs.clone() {
        from += p * weight;
        to += q * weight;
        total += weight;
    }
    if total <= 0.0 || !f64::is_finite(total) {
        return None;
    }
    let (from, to) = (from / total, to / total);
    let (mut sine, mut cosine) = (0.0, 0.0);
    for (p, q, weight) in pairs {
        let (a, b) = (p - from, q - to);
        sine += weight * a.perp(&b);
        cosine += weight * a.dot(&b);
    }
    let size = sine.hypot(cosine);
    if !(size > 0.0 && size.is_finite()) {
        return None;
    }
    let turn = nalgebra::UnitComplex::new(sine.atan2(cosine));
    Some(Pose2::from_parts((to - turn * from).into(), turn))
}
