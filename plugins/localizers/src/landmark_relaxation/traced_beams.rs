//! Beams of several scans beside what the map lets expect at a pose.

use super::matching::Knowledge;
use super::panorama::reference_from;
use super::sighting::{Beam, Sighting};
use rumbo_core::frames::{Point2, Pose2};
use std::f64::consts::TAU;

/// The beams of one scan, prepared for tracing.
#[derive(Debug, Clone)]
struct Part {
    /// The base at this scan, seen from the base at the newest, by the odometer.
    reference_from_base: Pose2,
    base_from_sensor: Pose2,
    directions: Vec<[f64; 2]>,
    beams: Vec<Beam>,
    reach_m: f64,
}

/// Beams of all scans, from the base at the newest.
#[derive(Debug, Clone)]
pub struct TracedBeams {
    parts: Vec<Part>,
}

/// One beam beside what was expected, in the map's frame.
#[derive(Debug, Clone, Copy)]
pub struct Comparison {
    /// What it says.
    pub beam: Beam,
    /// What the map says: infinite where nothing is within reach, not-a-number where nobody knows, meters.
    pub expected_m: f64,
    /// The farthest that the map says of it and the beams beside it: an edge may lie a little farther, and of a wall that is
    /// grazed a single cell may hide all that lies behind.
    pub farthest_m: f64,
    /// From the scanner.
    pub direction: [f64; 2],
    /// Where it ends.
    pub end: Point2,
    /// The base of its scan.
    pub base: Point2,
    /// Normal of the surface that it was expected to meet, where that is known.
    pub normal: Option<[f64; 2]>,
    /// Which scan, the newest last.
    pub scan: usize,
}

/// The normal is that of the chord between the beams so many beside.
const BESIDE: usize = 2;
/// A longer chord crosses from one surface to another, meters.
const LONGEST_CHORD_M: f64 = 1.0;
/// So does one that the surface leaves by more than this, meters.
const UNEVEN_M: f64 = 0.06;

impl TracedBeams {
    /// About `n_beams` of the beams of these scans, evenly.
    pub fn of(sightings: &[Sighting], n_beams: usize) -> TracedBeams {
        let Some(reference) = sightings.last() else { return TracedBeams { parts: Vec::new() } };
        let part = |sighting: &Sighting| {
            let share = n_beams as f64 * sighting.view_rad() / TAU;
            let every = (sighting.ranges_m.len() as f64 / share.max(1.0)).round().max(1.0) as usize;
            let chosen = || sighting.beams().step_by(every);
            let direction = |(bearing_rad, _): (f64, Beam)| [bearing_rad.cos(), bearing_rad.sin()];
            Part {
                reference_from_base: reference_from(sighting, reference),
                base_from_sensor: sighting.base_from_sensor,
                directions: chosen().map(direction).collect(),
                beams: chosen().map(|(_, beam)| beam).collect(),
                reach_m: sighting.fan.max_range_m,
            }
        };
        TracedBeams { parts: sightings.iter().map(part).collect() }
    }

    /// How many scans there are.
    pub fn n_scans(&self) -> usize {
        self.parts.len()
    }

    /// How far the base turned from each scan to the newest, radians.
    pub fn turns_rad(&self) -> impl Iterator<Item = f64> + '_ {
        self.parts.iter().map(|part| part.reference_from_base.rotation.angle())
    }

    /// All beams beside what is expected at a pose of the newest scan; `turns_rad` corrects the odometer for each of the
    /// scans before.
    pub fn compare(&self, known: &Knowledge, map_from_base: &Pose2, turns_rad: &[f64]) -> Vec<Comparison> {
        let mut comparisons = Vec::new();
        let mut ranges_m = Vec::new();
        for (scan, part) in self.parts.iter().enumerate() {
            let correction = Pose2::rotation(turns_rad.get(scan).copied().unwrap_or(0.0));
            let map_from_scan_base = map_from_base * part.reference_from_base * correction;
            let map_from_sensor = map_from_scan_base * part.base_from_sensor;
            known.scan(&map_from_sensor, &part.directions, part.reach_m, &mut ranges_m);
            let base = map_from_scan_base.translation.vector.into();
            let ends: Vec<Point2> = part.ends(&map_from_sensor, &ranges_m);
            for (idx, (beam, expected_m)) in part.beams.iter().zip(&ranges_m).enumerate() {
                let Some([x, y]) = part.directions.get(idx) else { continue };
                let along = map_from_sensor.rotation * nalgebra::Vector2::new(*x, *y);
                let range_m = if let Beam::Hit(range_m) = beam { *range_m } else { f64::NAN };
                comparisons.push(Comparison {
                    beam: *beam,
                    expected_m: *expected_m,
                    farthest_m: farthest_beside(&ranges_m, idx),
                    direction: [along.x, along.y],
                    end: Point2::from(map_from_sensor.translation.vector + along * range_m),
                    base,
                    normal: normal_at(&ends, idx),
                    scan,
                });
            }
        }
        comparisons
    }
}

impl Part {
    /// Where rays are expected to end, in the map's frame; not-a-number where they do not.
    fn ends(&self, map_from_sensor: &Pose2, ranges_m: &[f64]) -> Vec<Point2> {
        let end = |([x, y], range_m): (&[f64; 2], &f64)| {
            let range_m = if range_m.is_finite() { *range_m } else { f64::NAN };
            map_from_sensor * Point2::new(x * range_m, y * range_m)
        };
        self.directions.iter().zip(ranges_m).map(end).collect()
    }
}

/// Beams so many beside may meet what one meets.
const EDGE_BEAMS: usize = 3;

/// The farthest of a range and its neighbors; infinite where nobody knows one of them.
fn farthest_beside(ranges_m: &[f64], idx: usize) -> f64 {
    let first = idx.saturating_sub(EDGE_BEAMS);
    let beside = ranges_m.iter().take(idx + EDGE_BEAMS + 1).skip(first);
    beside.fold(0.0, |most, range| if range.is_nan() { f64::INFINITY } else { most.max(*range) })
}

/// Normal of the surface between the neighbors of a place, if they lie on one.
fn normal_at(ends: &[Point2], idx: usize) -> Option<[f64; 2]> {
    let (before, here, after) =
        (ends.get(idx.checked_sub(BESIDE)?)?, ends.get(idx)?, ends.get(idx + BESIDE)?);
    let (chord, to_here) = (after - before, here - before);
    let length = chord.norm();
    let uneven = (chord.x * to_here.y - chord.y * to_here.x).abs();
    // Written so that what is not a number has no normal.
    let is_surface = length > 1e-6 && length <= LONGEST_CHORD_M && uneven <= UNEVEN_M * length;
    is_surface.then(|| [-chord.y / length, chord.x / length])
}
