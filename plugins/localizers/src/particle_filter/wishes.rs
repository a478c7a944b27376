//! Motion that helps a robot that does not know where it is: standing still, it sees the same again and again.

use super::beams::ScanBeams;
use rumbo_core::messages::Wish;

/// Turned at once, radians.
const TURN_RAD: f64 = 0.6;
/// Driven at once, meters.
const AHEAD_M: f64 = 0.5;
/// Free length and half width before the base that driving needs, meters beyond its radius.
const FREE_AHEAD_M: f64 = 1.0;
const FREE_ASIDE_M: f64 = 0.3;

/// Ahead where the scans show free floor, else a turn.
pub fn wish(scans: &[ScanBeams], radius_m: f64) -> Wish {
    let is_clear = !scans.is_empty() && scans.iter().all(|scan| is_clear_ahead(scan, radius_m));
    if is_clear { Wish::MoveBy(AHEAD_M) } else { Wish::TurnBy(TURN_RAD) }
}

/// The scan looks ahead, and nothing is near there.
fn is_clear_ahead(scan: &ScanBeams, radius_m: f64) -> bool {
    let looks_ahead = scan.directions.iter().any(|[x, y]| *x > 0.0 && y.abs() < 0.2);
    let (length_m, aside_m) = (radius_m + FREE_AHEAD_M, radius_m + FREE_ASIDE_M);
    let is_in_the_way = |[x, y]: [f64; 2]| x > 0.0 && x < length_m && y.abs() < aside_m;
    looks_ahead && !scan.end_points(scan.max_range_m).any(is_in_the_way)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scan(bearing_rad: f64, range_m: f64) -> ScanBeams {
        let (sin, cos) = bearing_rad.sin_cos();
        ScanBeams {
            origin: [0.0, 0.0],
            directions: vec![[cos, sin]],
            ranges_m: vec![range_m],
            max_range_m: 10.0,
        }
    }

    #[test]
    fn the_way_ahead_is_taken_only_where_it_was_seen_to_be_free() {
        assert_eq!(wish(&[scan(0.0, 5.0)], 0.2), Wish::MoveBy(AHEAD_M));
        assert_eq!(wish(&[scan(0.0, f64::INFINITY)], 0.2), Wish::MoveBy(AHEAD_M));
        for closed in
            [vec![], vec![scan(0.0, 1.1)], vec![scan(3.0, 5.0)], vec![scan(0.0, 5.0), scan(0.3, 1.0)]]
        {
            assert_eq!(wish(&closed, 0.2), Wish::TurnBy(TURN_RAD), "{closed:?}");
        }
    }
}
