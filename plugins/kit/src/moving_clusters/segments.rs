//! Segments of a scan: hits next to each other that nothing static explains.

use super::MoverTuning;
use rumbo_core::frames::{Point2, Pose2};
use rumbo_core::messages::LaserScan;

/// A piece of something, such as a leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Segment {
    /// The middle of what is behind these hits, if it is round.
    pub middle: Point2,
    /// A track has it.
    pub is_taken: bool,
}

/// Two hits next to each other are of one piece up to this distance, meters, and so many times their spacing.
const GAP_M: f64 = 0.10;
const GAP_SPACINGS: f64 = 2.0;
/// One hit may be noise.
const LEAST_HITS: u32 = 2;
/// Of a disc one sees a half, with beams that are spread evenly over its width: their hits are on average π/4 of its radius
/// before its middle.
const BEHIND: f64 = std::f64::consts::FRAC_PI_8;

/// Hits that belong together so far.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: Point2,
    last: Point2,
    sum: nalgebra::Vector2<f64>,
    n_hits: u32,
    extent_m: f64,
}

/// All segments that may be people.
pub fn segments(
    scan: &LaserScan,
    frame_from_sensor: &Pose2,
    tuning: &MoverTuning,
    is_static: impl Fn(Point2) -> bool,
    out: &mut Vec<Segment>,
) {
    out.clear();
    let eye = Point2::from(frame_from_sensor.translation.vector);
    let mut run: Option<Run> = None;
    let mut end = |run: Option<Run>| {
        out.extend(run.filter(|run| run.n_hits >= LEAST_HITS && run.extent_m <= tuning.widest_m).map(
            |run| {
                let seen = Point2::from(run.sum / f64::from(run.n_hits));
                let away = (seen - eye).normalize();
                Segment { middle: seen + away * (BEHIND * run.extent_m), is_taken: false }
            },
        ));
    };
    for (bearing_rad, range_m) in scan.hits() {
        let hit = frame_from_sensor * Point2::new(range_m * bearing_rad.cos(), range_m * bearing_rad.sin());
        if range_m <= 0.0 || range_m > tuning.reach_m || is_static(hit) {
            continue;
        }
        let gap_m = GAP_M + GAP_SPACINGS * range_m * scan.bearing_step_rad.abs();
        match run.as_mut().filter(|run| (hit - run.last).norm() <= gap_m) {
            Some(run) => {
                run.last = hit;
                run.sum += hit.coords;
                run.n_hits += 1;
                run.extent_m = run.extent_m.max((hit - run.first).norm());
            }
            None => {
                let fresh = Run { first: hit, last: hit, sum: hit.coords, n_hits: 1, extent_m: 0.0 };
                end(run.replace(fresh));
            }
        }
    }
    end(run);
}

#[cfg(test)]
mod tests {
    use super::*;
    use rumbo_core::boundary::Buffer;
    use rumbo_core::frames::pose2;

    fn scan(ranges: &[f32]) -> LaserScan {
        LaserScan {
            first_bearing_rad: -0.5,
            bearing_step_rad: 0.01,
            min_range_m: 0.05,
            max_range_m: 8.0,
            ranges_m: Buffer::from(ranges),
            ..LaserScan::default()
        }
    }

    fn middles(scan: &LaserScan, is_static: impl Fn(Point2) -> bool) -> Vec<Point2> {
        let mut out = Vec::new();
        segments(scan, &pose2(0.0, 0.0, 0.0), &MoverTuning::default(), is_static, &mut out);
        out.iter().map(|segment| segment.middle).collect()
    }

    #[test]
    fn two_legs_before_a_wall_are_two_segments_and_the_wall_is_too_wide() {
        let mut ranges = [4.0f32; 101];
        ranges[40..46].fill(2.0);
        ranges[60..66].fill(2.1);
        ranges[80] = 1.0;
        let found = middles(&scan(&ranges), |_| false);
        // What is left of the wall between them is narrow enough to be somebody.
        let near: Vec<&Point2> = found.iter().filter(|p| p.coords.norm() < 2.5).collect();
        assert_eq!(near.len(), 2, "{found:?}");
        let bearing = |p: &Point2| p.y.atan2(p.x);
        assert!((bearing(near[0]) - (-0.5 + 0.425)).abs() < 1e-3 && (bearing(near[1]) - 0.125).abs() < 1e-3);
        assert!(near[0].coords.norm() > 2.0 && near[0].coords.norm() < 2.06);
        let explained = middles(&scan(&ranges), |p| p.coords.norm() > 3.0);
        assert_eq!(explained.len(), 2);
    }

    #[test]
    fn scans_without_a_number_have_no_segments() {
        assert_eq!(middles(&scan(&[]), |_| false), []);
        assert_eq!(middles(&scan(&[f32::NAN; 50]), |_| false), []);
        assert_eq!(middles(&scan(&[f32::INFINITY; 50]), |_| false), []);
        assert_eq!(middles(&scan(&[0.0; 50]), |_| false), []);
    }

    /// The middle of a disc of which a fine scanner sees one half is where the disc is.
    #[test]
    fn the_middle_of_a_disc_is_found_from_its_front() {
        let (distance_m, radius_m) = (3.0f64, 0.25f64);
        let ranges: Vec<f32> = (0..101)
            .map(|k| {
                let bearing = -0.5 + 0.01 * f64::from(k);
                let off = distance_m * bearing.sin();
                let half = radius_m.powi(2) - off.powi(2);
                if half < 0.0 { f32::INFINITY } else { (distance_m * bearing.cos() - half.sqrt()) as f32 }
            })
            .collect();
        let found = middles(&scan(&ranges), |_| false);
        assert_eq!(found.len(), 1);
        assert!((found[0] - Point2::new(distance_m, 0.0)).norm() < 0.05, "{found:?}");
    }
}
