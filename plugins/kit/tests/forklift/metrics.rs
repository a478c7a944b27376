//! How far a map is from the hall.

use super::Hall;
use rumbo_core::frames::wrap_angle;
use rumbo_core::map::Line;

fn angle_of(line: &Line) -> f64 {
    (line.to[1] - line.from[1]).atan2(line.to[0] - line.from[0])
}

/// Distance of a wall's middle from the true line that it belongs to, meters: of those within 30 degrees the one with the
/// smallest sum of distance and gap along the line.
fn offset_m(wall: &Line, hall: &Hall) -> f64 {
    let middle = [(wall.from[0] + wall.to[0]) / 2.0, (wall.from[1] + wall.to[1]) / 2.0];
    let against = |line: &Line| {
        let (dx, dy) = (line.to[0] - line.from[0], line.to[1] - line.from[1]);
        let length = dx.hypot(dy);
        let along = |[x, y]: [f64; 2]| ((x - line.from[0]) * dx + (y - line.from[1]) * dy) / length;
        let across = ((middle[0] - line.from[0]) * dy - (middle[1] - line.from[1]) * dx).abs() / length;
        let (one, other) = (along(wall.from), along(wall.to));
        let gap = (one.min(other) - length).max(-one.max(other)).max(0.0);
        (across + gap, across)
    };
    let near = hall.lines.iter().filter(|line| {
        let turn = wrap_angle(angle_of(line) - angle_of(wall)).abs();
        turn < 30f64.to_radians() || turn > 150f64.to_radians()
    });
    near.map(against).min_by(|a, b| a.0.total_cmp(&b.0)).map_or(f64::NAN, |(_, across)| across)
}

/// Root of the mean square over all walls, meters.
pub fn map_offset_m(walls: &[Line], hall: &Hall) -> f64 {
    let sum: f64 = walls.iter().map(|wall| offset_m(wall, hall).powi(2)).sum();
    (sum / walls.len() as f64).sqrt()
}
