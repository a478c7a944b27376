//! Gaps between obstacles: directions in which the robot fits through.

use rumbo_core::frames::Point2;

/// Directions are tried in steps of this, degrees.
const STEP_DEG: f64 = 3.0;

/// How much room the robot wants.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Room {
    /// Half of the width of the way, meters.
    pub half_width_m: f64,
    /// Gaps are searched this far to both sides, radians.
    pub max_detour_rad: f64,
}

/// The direction nearest to `wanted_rad` in which the way is free for `length_m`, seen from the robot; `hits` are in the
/// base frame. None where there is no gap. Where there is one on both sides alike, the wider one is taken.
pub fn direction(hits: &[Point2], wanted_rad: f64, length_m: f64, room: &Room) -> Option<f64> {
    let is_open = |off_rad: f64| free_m(hits, wanted_rad + off_rad, room.half_width_m) >= length_m;
    if is_open(0.0) {
        return Some(wanted_rad);
    }
    let step_rad = STEP_DEG.to_radians();
    let n_steps = (room.max_detour_rad / step_rad) as u32;
    let off_rad = (1..=n_steps).find_map(|step| {
        let off_rad = f64::from(step) * step_rad;
        match (is_open(off_rad), is_open(-off_rad)) {
            (false, false) => None,
            (true, false) => Some(off_rad),
            (false, true) => Some(-off_rad),
            (true, true) => {
                let width = |side: f64| {
                    (step..=n_steps).take_while(|step| is_open(side * f64::from(*step) * step_rad)).count()
                };
                Some(if width(1.0) >= width(-1.0) { off_rad } else { -off_rad })
            }
        }
    });
    off_rad.map(|off_rad| wanted_rad + off_rad)
}

/// How far the robot's middle can go in a direction before something is beside it, meters.
pub fn free_m(hits: &[Point2], direction_rad: f64, half_width_m: f64) -> f64 {
    let (sin, cos) = direction_rad.sin_cos();
    let way = |hit: &Point2| {
        let (ahead_m, beside_m) = (cos * hit.x + sin * hit.y, cos * hit.y - sin * hit.x);
        // What is behind, or passes by, is no obstacle.
        let is_on_the_way = ahead_m > 0.0 && beside_m.abs() < half_width_m;
        is_on_the_way.then(|| (ahead_m - (half_width_m.powi(2) - beside_m.powi(2)).max(0.0).sqrt()).max(0.0))
    };
    hits.iter().filter_map(way).fold(f64::INFINITY, f64::min)
}

/// From the robot's middle to the nearest hit, meters.
pub fn nearest_m(hits: &[Point2]) -> f64 {
    hits.iter().map(|hit| hit.coords.norm()).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: Room = Room { half_width_m: 0.3, max_detour_rad: 1.6 };

    /// A wall across the way, 1 m ahead, from one side to the other.
    fn wall(from_y: f64, to_y: f64) -> Vec<Point2> {
        let n = ((to_y - from_y) / 0.02) as u32;
        (0..=n).map(|k| Point2::new(1.0, from_y + 0.02 * f64::from(k))).collect()
    }

    #[test]
    fn an_open_way_is_taken_exactly_as_wanted() {
        assert_eq!(direction(&[], 0.123, 2.0, &ROOM), Some(0.123));
        assert_eq!(direction(&wall(-2.0, 2.0), 0.0, 0.6, &ROOM), Some(0.0), "the wall is behind the point");
    }

    #[test]
    fn the_nearer_end_of_a_wall_is_passed_on_both_sides() {
        for side in [1.0, -1.0] {
            let (from, to) = if side > 0.0 { (-2.0, 0.2) } else { (-0.2, 2.0) };
            let found = direction(&wall(from, to), 0.0, 1.2, &ROOM).unwrap() * side;
            // The end of the wall is 11 degrees off; the half width asks for as much as 17 degrees more.
            assert!(found.to_degrees() > 25.0 && found.to_degrees() < 33.0, "{found}");
        }
    }

    #[test]
    fn a_gap_that_is_too_narrow_is_none() {
        let mut hits = wall(-2.0, -0.25);
        hits.extend(wall(0.25, 2.0));
        let narrow = Room { max_detour_rad: 0.3, ..ROOM };
        assert_eq!(direction(&hits, 0.0, 1.5, &narrow), None);
        assert_eq!(direction(&hits, 0.0, 1.5, &Room { half_width_m: 0.24, ..narrow }), Some(0.0));
    }

    #[test]
    fn a_way_ends_where_the_robot_would_touch() {
        assert!((free_m(&[Point2::new(1.0, 0.0)], 0.0, 0.3) - 0.7).abs() < 1e-12);
        assert_eq!(free_m(&[Point2::new(1.0, 0.3)], 0.0, 0.3), f64::INFINITY);
        assert_eq!(free_m(&[Point2::new(-0.2, 0.0)], 0.0, 0.3), f64::INFINITY);
        assert!((nearest_m(&[Point2::new(0.3, 0.4)]) - 0.5).abs() < 1e-12);
    }
}
