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
