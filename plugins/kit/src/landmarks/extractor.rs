//! From a scan to its landmarks, in one pass and in memory that is kept.

mod circular;

use super::corners::straight_pieces;
use super::discontinuities::{Gap, gap_after};
use super::hough::Hough;
use super::least_squares::{Line, fitted, unevenness_m, unit_covariance};
use super::readings::{Reading, way};
use super::{Landmark, LandmarkKind, LandmarkSettings, Side, WallFit};
use rumbo_core::frames::wrap_angle;

/// Beams of a planar scan. A negative step goes clockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamFan {
    /// Bearing of the first beam, radians.
    pub first_bearing_rad: f64,
    /// From one beam to the next, radians.
    pub bearing_step_rad: f64,
    /// Shorter ranges are no readings, meters.
    pub min_range_m: f64,
    /// Ranges from here on are no readings: nothing was met, meters.
    pub max_range_m: f64,
}

/// Finds landmarks in scans.
#[derive(Debug, Clone)]
pub struct Extractor {
    settings: LandmarkSettings,
    /// Bearings that `directions` were computed for.
    fan: Option<[f64; 2]>,
    /// From one beam to the next, radians.
    beam_step_rad: f64,
    directions: Vec<[f64; 2]>,
    readings: Vec<Reading>,
    pending: Vec<[usize; 2]>,
    hough: Hough,
    landmarks: Vec<Landmark>,
}

impl Extractor {
    /// An extractor with these thresholds.
    pub fn new(settings: LandmarkSettings) -> Extractor {
        Extractor {
            settings,
            fan: None,
            beam_step_rad: 0.0,
            directions: Vec::new(),
            readings: Vec::new(),
            pending: Vec::new(),
            hough: Hough::new(),
            landmarks: Vec::new(),
        }
    }

    /// The landmarks of a scan, from the right to the left. Ranges that are no numbers, and those outside the device's
    /// reach, are beams without a reading.
    pub fn extract(&mut self, fan: &BeamFan, ranges_m: impl Iterator<Item = f64>) -> &[Landmark] {
        self.landmarks.clear();
        self.readings.clear();
        if !(fan.first_bearing_rad.is_finite() && fan.bearing_step_rad.is_finite()) {
            return &self.landmarks;
        }
        self.place_readings(fan, ranges_m);
        self.beam_step_rad = fan.bearing_step_rad.abs();
        self.collect(fan.max_range_m);
        &self.landmarks
    }

    /// The landmarks of the readings that are in place.
    fn collect(&mut self, reach_m: f64) {
        let mut first = 0;
        for idx in 0..self.readings.len() {
            let gap = gap_after(&self.readings, idx, &self.settings);
            if gap == Gap::None {
                continue;
            }
            self.add_straight_pieces([first, idx], reach_m);
            if gap == Gap::Jump {
                self.add_discontinuity(idx);
            }
            first = idx + 1;
        }
    }

    /// What the last scan looked like.
    pub fn readings(&self) -> &[Reading] {
        &self.readings
    }

    /// Room in each of its memories.
    #[cfg(test)]
    pub(super) fn capacities(&self) -> [usize; 4] {
        [
            self.directions.capacity(),
            self.readings.capacity(),
            self.pending.capacity(),
            self.landmarks.capacity(),
        ]
    }

    /// Places of all readings, counter-clockwise.
    fn place_readings(&mut self, fan: &BeamFan, ranges_m: impl Iterator<Item = f64>) {
        let bearings = [fan.first_bearing_rad, fan.bearing_step_rad];
        if self.fan != Some(bearings) {
            self.fan = Some(bearings);
            self.directions.clear();
        }
        let reach = fan.min_range_m.max(f64::MIN_POSITIVE)..fan.max_range_m;
        for (idx, range_m) in ranges_m.enumerate() {
            if self.directions.len() <= idx {
                let (sin, cos) = (bearings[0] + bearings[1] * idx as f64).sin_cos();
                self.directions.push([cos, sin]);
            }
            let direction = self.directions.get(idx).filter(|_| reach.contains(&range_m));
            self.readings.push(direction.map_or(Reading::NONE, |along| Reading::along(*along, range_m)));
        }
        if fan.bearing_step_rad < 0.0 {
            self.readings.reverse();
        }
    }

    fn bearing_rad(reading: &Reading) -> f64 {
        wrap_angle(reading.place[1].atan2(reading.place[0]))
    }

    /// The nearer of two readings is the edge; what it belongs to hides what lies behind it.
    fn add_discontinuity(&mut self, idx: usize) {
        let Some([right, left]) = self.readings.get(idx..idx + 2) else { return };
        let beside = if right.range_m > left.range_m { Some(idx + 2) } else { idx.checked_sub(1) };
        let (edge, hidden) =
            if right.range_m > left.range_m { (left, Side::Left) } else { (right, Side::Right) };
        let jump_m = (right.range_m - left.range_m).abs();
        let beam_m = edge.range_m * self.beam_step_rad;
        let next = beside.and_then(|idx| self.readings.get(idx)).filter(|reading| reading.is_valid());
        let spacing_m = next.map_or(beam_m, |reading| apart(edge, reading).min(jump_m)).max(beam_m);
        self.landmarks.push(Landmark {
            distance_m: edge.range_m,
            bearing_rad: Self::bearing_rad(edge),
            kind: LandmarkKind::Discontinuity { hidden, jump_m, spacing_m },
            beams: [idx as u32, idx as u32 + 1],
        });
    }

    fn add_straight_pieces(&mut self, [first, last]: [usize; 2], reach_m: f64) {
        let Self { settings, readings, pending, hough, landmarks, .. } = self;
        let corner_m = settings.corner_m;
        straight_pieces(readings, [first, last], corner_m, pending, |piece, [from, to]| {
            if let Some(wall) = wall_of(piece, settings, hough, reach_m) {
                landmarks.push(Landmark { beams: [from as u32, to as u32], ..wall });
            }
            let [.., before, corner] = piece else { return };
            if to == last {
                return;
            }
            let after = readings.get(to + 1).map_or(0.0, |after| apart(corner, after));
            landmarks.push(Landmark {
                distance_m: corner.range_m,
                bearing_rad: Self::bearing_rad(corner),
                kind: LandmarkKind::Corner { spacing_m: apart(before, corner).max(after) },
                beams: [to as u32; 2],
            });
        });
    }
}

fn apart(a: &Reading, b: &Reading) -> f64 {
    let [x, y] = way(a, b);
    x.hypot(y)
}

/// The wall that a straight piece is, if it is long enough and has enough readings.
fn wall_of(
    piece: &[Reading],
    settings: &LandmarkSettings,
    hough: &mut Hough,
    reach_m: f64,
) -> Option<Landmark> {
    let [first, inner @ .., last] = piece else { return None };
    let length_m = apart(first, last);
    if length_m <= settings.wall_m || inner.len() < settings.least_readings.max(2) {
        return None;
    }
    // Both ends may belong to the next wall: the fit leaves them out, the transform counts them as the source does.
    let line = match settings.wall_fit {
        WallFit::Tls => fitted(inner, settings.unevenness_m()),
        WallFit::Hough => {
            let strongest = hough.strongest(piece, reach_m)?;
            Line { distance_m: strongest.distance_m, bearing_rad: strongest.bearing_rad }
        }
    };
    let unit_covariance = unit_covariance(inner, &line);
    let unevenness_m = unevenness_m(inner, &line);
    Some(Landmark {
        distance_m: line.distance_m,
        bearing_rad: wrap_angle(line.bearing_rad),
        kind: LandmarkKind::Wall { length_m, unit_covariance, unevenness_m },
        beams: [0; 2],
    })
}
