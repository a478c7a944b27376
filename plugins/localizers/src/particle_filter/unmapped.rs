//! Beams that end at people and things which the map does not show.
//!
//! The distance filter of Fox, Burgard, Thrun, *Markov Localization for Mobile Robots in Dynamic Environments* (1999),
//! section 4: a followed robot leaves out what is nearer than the map lets expect. Whatever is not on the map makes beams
//! shorter, never longer, so beams that are too long stay and tell a robot that was carried away. Differs from the paper:
//! the expected pose decides for all particles, with a tolerance in place of a probability. A likelihood field would pull
//! the robot toward a wall to explain somebody who stands before it.

use super::beams::ScanBeams;
use super::terrain::{Terrain, slack_m};
use rumbo_core::frames::{Point2, Pose2};

/// The scans without beams that end in sight of the robot on bare floor.
pub fn without_unmapped(scans: &[ScanBeams], terrain: &Terrain, map_from_base: &Pose2) -> Vec<ScanBeams> {
    scans.iter().map(|scan| of_one(scan, terrain, map_from_base)).collect()
}

fn of_one(scan: &ScanBeams, terrain: &Terrain, map_from_base: &Pose2) -> ScanBeams {
    let sensor = map_from_base * Point2::from(scan.origin);
    let is_unmapped = |direction: [f64; 2], range_m: f64| {
        if range_m >= scan.max_range_m {
            return false;
        }
        let ahead = map_from_base.rotation * nalgebra::Vector2::from(direction);
        let end = sensor + ahead * range_m;
        // Behind a wall it is no person but a wrong place.
        terrain.is_bare(end) && !terrain.is_blocked(sensor, end + ahead * slack_m(range_m))
    };
    let beams = scan.directions.iter().copied().zip(scan.ranges_m.iter().copied());
    let (directions, ranges_m) =
        beams.filter(|(direction, range_m)| !is_unmapped(*direction, *range_m)).unzip();
    ScanBeams { directions, ranges_m, ..*scan }
}

#[cfg(test)]
mod tests {
    use super::super::terrain::tests::room_with;
    use super::*;
    use rumbo_core::frames::pose2;

    /// Ranges that are left of four beams, ahead, to the left, back and to the right, in a room of 4 m by 4 m with a wall
    /// across it, 1 m from its top.
    fn left(ranges_m: [f64; 4], at: [f64; 3]) -> Vec<f64> {
        let directions = vec![[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]];
        let scan =
            ScanBeams { origin: [0.0, 0.0], directions, ranges_m: ranges_m.to_vec(), max_range_m: 8.0 };
        let [x, y, yaw] = at;
        let scans = without_unmapped(&[scan], &room_with(|_, row| row == 30), &pose2(x, y, yaw));
        assert_eq!(scans[0].directions.len(), scans[0].ranges_m.len());
        scans[0].ranges_m.clone()
    }

    #[test]
    fn only_beams_that_end_in_sight_on_bare_floor_are_left_out() {
        let here = [2.0, 1.0, 0.0];
        assert_eq!(left([1.9, 2.0, 1.9, 0.9], here), [1.9, 2.0, 1.9, 0.9]);
        assert_eq!(left([0.6, 1.2, 1.2, 0.9], here), [0.9], "people before the walls");
        assert_eq!(left([1.5, 1.6, 1.6, 0.6], here), [1.5, 1.6, 1.6, 0.6], "known to some centimeters");
        assert_eq!(left([f64::INFINITY, 8.0, 1.9, 0.9], here), [f64::INFINITY, 8.0, 1.9, 0.9]);
        let turned = [1.0, 1.0, std::f64::consts::FRAC_PI_2];
        assert_eq!(left([2.0, 0.9, 0.9, 0.6], turned), [2.0, 0.9, 0.9]);
    }

    #[test]
    fn beams_that_are_too_long_stay_and_tell_of_a_wrong_place() {
        let here = [2.0, 1.0, 0.0];
        assert_eq!(left([3.0, 2.0, 2.5, 0.9], here), [3.0, 2.0, 2.5, 0.9], "off the map");
        assert_eq!(left([1.9, 2.5, 1.9, 0.9], here), [1.9, 2.5, 1.9, 0.9], "bare floor behind a wall");
    }
}
