//! What the robot sees all around: scans in several headings, joined.
//!
//! The source takes the landmarks of two scans half a turn apart. That cuts walls at the two seams; so here the scans are
//! joined first, and landmarks taken from the whole. All is seen from the base as it stood at the newest scan.

use super::matching::Knowledge;
use super::sighting::{Beam, Sighting};
use crate::triangulation::correspondence::predicted;
use rumbo_core::frames::{Point2, Pose2, wrap_angle};
use rumbo_kit::landmarks::{BeamFan, Extractor, Landmark, Reading};
use std::f64::consts::TAU;

/// Readings all around the base.
#[derive(Debug, Clone, PartialEq)]
pub struct Panorama {
    readings: Vec<Reading>,
    /// How far the way is known to be free in each direction, meters; zero where nobody looked.
    free_m: Vec<f64>,
}

/// What is seen in one direction.
#[derive(Debug, Clone, Copy, Default)]
struct Bin {
    /// The reading of each of two scans that lies nearest to the middle: how far off it is, and where.
    hits: [Option<(f64, Point2)>; 2],
    free_m: f64,
}

/// Directions of what a map expects.
const N_EXPECTED: usize = 360;
/// Parts of a turn in which something may be hidden.
const N_SECTORS: usize = 60;
/// Two readings of one surface differ by no more than this, meters.
const SAME_SURFACE_M: f64 = 0.08;

/// Where a base stood at one sighting, seen from where it stood at another.
pub fn reference_from(sighting: &Sighting, reference: &Sighting) -> Pose2 {
    reference.odom_from_base.inverse() * sighting.odom_from_base
}

impl Panorama {
    /// Joins sightings in `n_bins` directions, seen from the last of them.
    pub fn of(sightings: &[Sighting], n_bins: usize) -> Panorama {
        let mut bins = vec![Bin::default(); n_bins.max(1)];
        if let Some(reference) = sightings.last() {
            for (idx, sighting) in sightings.iter().enumerate() {
                let reference_from_sensor = reference_from(sighting, reference) * sighting.base_from_sensor;
                // The newest scan is one side, all older ones the other.
                let side = usize::from(idx + 1 < sightings.len());
                add(&mut bins, sighting, &reference_from_sensor, side);
            }
        }
        Panorama {
            readings: bins.iter().map(Bin::reading).collect(),
            free_m: bins.iter().map(Bin::free_m).collect(),
        }
    }

    /// What the map expects to be seen all around from a pose, in single degrees.
    pub fn expected(known: &Knowledge, map_from_base: &Pose2, reach_m: f64) -> Panorama {
        let direction = |k: usize| {
            let (sin, cos) = (TAU * k as f64 / N_EXPECTED as f64).sin_cos();
            [cos, sin]
        };
        let directions: Vec<[f64; 2]> = (0..N_EXPECTED).map(direction).collect();
        let mut ranges_m = Vec::new();
        known.scan(map_from_base, &directions, reach_m, &mut ranges_m);
        let seen = || ranges_m.iter().zip(&directions);
        let reading = |(range_m, [x, y]): (&f64, &[f64; 2])| {
            if range_m.is_finite() {
                Reading { place: [range_m * x, range_m * y], range_m: *range_m }
            } else {
                Reading { place: [0.0; 2], range_m: f64::NAN }
            }
        };
        // Not-a-number, where nobody knows, is the lesser here.
        let free_m = |(range_m, _): (&f64, _)| if range_m.is_nan() { 0.0 } else { range_m.min(reach_m) };
        Panorama { readings: seen().map(reading).collect(), free_m: seen().map(free_m).collect() }
    }

    /// Share of a turn that readings nearer than `near_m` hide from a place in the frame of the base.
    pub fn hidden_share(&self, from: Point2, near_m: f64) -> f64 {
        let mut is_hidden = [false; N_SECTORS];
        for reading in self.readings.iter().filter(|reading| reading.is_valid()) {
            let [dx, dy] = [reading.place[0] - from.x, reading.place[1] - from.y];
            let sector = (dy.atan2(dx).rem_euclid(TAU) / TAU * N_SECTORS as f64) as usize;
            if let Some(is_hidden) = is_hidden.get_mut(sector.min(N_SECTORS - 1)) {
                *is_hidden |= dx.hypot(dy) < near_m;
            }
        }
        is_hidden.iter().filter(|is_hidden| **is_hidden).count() as f64 / N_SECTORS as f64
    }

    /// One reading a direction, counter-clockwise from straight ahead.
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// Directions with a reading.
    pub fn n_readings(&self) -> usize {
        self.readings.iter().filter(|reading| reading.is_valid()).count()
    }

    /// Its landmarks but for corners.
    pub fn landmarks(&self, extractor: &mut Extractor, reach_m: f64) -> Vec<Landmark> {
        let step_rad = TAU / self.readings.len() as f64;
        let landmarks = extractor.extract_circular(self.readings.iter().copied(), step_rad, reach_m);
        landmarks.iter().filter(|landmark| landmark.extent_m().is_some()).copied().collect()
    }

    /// A disc of `radius_m` can go `way_m` in this direction without touching anything that was seen, through what was
    /// seen to be free.
    pub fn is_open(&self, bearing_rad: f64, way_m: f64, radius_m: f64) -> bool {
        let n = self.free_m.len() as f64;
        let bin = (bearing_rad.rem_euclid(TAU) / TAU * n).round() as usize % self.free_m.len();
        let is_seen = self.free_m.get(bin).is_some_and(|free_m| *free_m >= way_m + radius_m);
        let (sin, cos) = bearing_rad.sin_cos();
        let is_in_the_way = |reading: &Reading| {
            let [x, y] = reading.place;
            let (along, aside) = (x * cos + y * sin, y * cos - x * sin);
            reading.is_valid() && along > 0.0 && along < way_m + radius_m && aside.abs() < radius_m
        };
        is_seen && !self.readings.iter().any(is_in_the_way)
    }
}

/// The landmarks of each scan by itself, seen from the base at the last: as in the source. Of beams that are nearer to each
/// other than `step_rad`, the step of the model's rays, only so many are used: jumps of the range along grazed walls depend
/// on it.
pub fn union_of_landmarks(sightings: &[Sighting], extractor: &mut Extractor, step_rad: f64) -> Vec<Landmark> {
    let mut landmarks = Vec::new();
    let Some(reference) = sightings.last() else { return landmarks };
    for sighting in sightings {
        let sensor_from_reference =
            (reference_from(sighting, reference) * sighting.base_from_sensor).inverse();
        let every = (step_rad / sighting.fan.bearing_step_rad.abs()).round().clamp(1.0, 1e3) as usize;
        let bearing_step_rad = sighting.fan.bearing_step_rad * every as f64;
        let fan = BeamFan { bearing_step_rad, ..sighting.fan };
        let found = extractor.extract(&fan, sighting.ranges_m.iter().step_by(every).copied());
        let used = found.iter().filter(|landmark| landmark.extent_m().is_some());
        landmarks.extend(used.map(|landmark| predicted(landmark, &sensor_from_reference)));
    }
    landmarks
}

fn add(bins: &mut [Bin], sighting: &Sighting, reference_from_sensor: &Pose2, side: usize) {
    let n = bins.len() as f64;
    for (bearing_rad, beam) in sighting.beams() {
        let range_m = match beam {
            Beam::Hit(range_m) => range_m,
            Beam::Free => sighting.fan.max_range_m,
            Beam::Silent => continue,
        };
        let (sin, cos) = bearing_rad.sin_cos();
        let place = reference_from_sensor * Point2::new(range_m * cos, range_m * sin);
        let turns = place.y.atan2(place.x).rem_euclid(TAU) / TAU * n;
        let off = wrap_angle((turns - turns.round()) / n * TAU).abs();
        let Some(bin) = bins.get_mut(turns.round() as usize % n as usize) else { continue };
        let distance_m = place.coords.norm();
        if let Beam::Free = beam {
            bin.free_m = bin.free_m.max(distance_m);
            continue;
        }
        let Some(hit) = bin.hits.get_mut(side) else { continue };
        if hit.is_none_or(|(nearest, _)| off < nearest) {
            *hit = Some((off, place));
        }
    }
}

impl Bin {
    fn free_m(&self) -> f64 {
        let reading = self.reading();
        if reading.is_valid() { reading.range_m } else { self.free_m }
    }

    /// Two readings of one surface are averaged; of two surfaces the one nearer to the middle of the bin is taken.
    fn reading(&self) -> Reading {
        let place = match self.hits {
            [Some((_, a)), Some((_, b))] if (a - b).norm() <= SAME_SURFACE_M => nalgebra::center(&a, &b),
            [Some((off_a, a)), Some((off_b, b))] => {
                if off_a <= off_b {
                    a
                } else {
                    b
                }
            }
            [Some((_, place)), None] | [None, Some((_, place))] => place,
            [None, None] => return Reading { place: [0.0; 2], range_m: f64::NAN },
        };
        Reading { place: [place.x, place.y], range_m: place.coords.norm() }
    }
}
