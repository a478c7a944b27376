//! Landmarks of a scan all around, whose last reading lies beside the first.
//!
//! Such a scan has to be cut somewhere. Cut in a wall, it would show two shorter ones; so it is cut where nobody knows what
//! is there, else at the largest jump of the range, else at a corner.

use super::super::discontinuities::{Gap, gap_after};
use super::{Extractor, Landmark, LandmarkKind, Reading};

/// Where a scan is cut.
enum Seam {
    /// Before this reading nobody knows.
    Unknown(usize),
    /// Between this reading and the one before it the range jumps.
    Jump(usize),
    /// This reading is a corner.
    Corner(Landmark),
    /// Nothing tells one reading from another: a round room.
    Anywhere,
}

/// Readings of the beginning that are seen again after the end, so that the last jump is judged as all others are.
const N_REPEATED: usize = 3;

impl Extractor {
    /// The landmarks of readings all around, given counter-clockwise and about `step_rad` apart. Walls whose line lies
    /// farther than `reach_m` are not looked for by the Hough transform.
    pub fn extract_circular(
        &mut self,
        readings: impl Iterator<Item = Reading>,
        step_rad: f64,
        reach_m: f64,
    ) -> &[Landmark] {
        self.landmarks.clear();
        self.readings.clear();
        self.readings.extend(readings);
        self.beam_step_rad = step_rad;
        let n = self.readings.len();
        let (start, n_repeated, corner) = match self.seam(reach_m) {
            Seam::Unknown(start) | Seam::Jump(start) => (start, N_REPEATED, None),
            // The wall that ends at the corner needs its last reading.
            Seam::Corner(corner) => (corner.beams[0] as usize, 1, Some(corner)),
            Seam::Anywhere => (0, 0, None),
        };
        self.landmarks.clear();
        self.readings.truncate(n);
        self.readings.rotate_left(start);
        self.readings.extend_from_within(..n_repeated.min(n));
        self.collect(reach_m);
        self.readings.truncate(n);
        self.landmarks.retain(|landmark| (landmark.beams[0] as usize) < n);
        for landmark in &mut self.landmarks {
            landmark.beams = landmark.beams.map(|beam| ((beam as usize + start) % n) as u32);
        }
        self.landmarks.extend(corner);
        self.readings.rotate_right(start);
        &self.landmarks
    }

    /// Leaves repeated readings and landmarks behind.
    fn seam(&mut self, reach_m: f64) -> Seam {
        let n = self.readings.len();
        if let Some(start) = after_longest_gap(&self.readings) {
            return Seam::Unknown(start);
        }
        self.readings.extend_from_within(..N_REPEATED.min(n));
        let mut largest = (0.0, None);
        for idx in 1..self.readings.len().saturating_sub(2) {
            if gap_after(&self.readings, idx, &self.settings) == Gap::Jump {
                let jump_m = (self.readings[idx + 1].range_m - self.readings[idx].range_m).abs();
                if jump_m > largest.0 {
                    largest = (jump_m, Some((idx + 1) % n));
                }
            }
        }
        if let Some(start) = largest.1 {
            return Seam::Jump(start);
        }
        self.readings.truncate(n);
        self.collect(reach_m);
        let is_corner = |landmark: &&Landmark| matches!(landmark.kind, LandmarkKind::Corner { .. });
        self.landmarks.iter().find(is_corner).map_or(Seam::Anywhere, |corner| Seam::Corner(*corner))
    }
}

/// The first reading after the longest run of beams without one, of several the first; none where all beams have a reading
/// or none has.
fn after_longest_gap(readings: &[Reading]) -> Option<usize> {
    let n = readings.len();
    let is_valid = |idx: usize| readings.get(idx % n.max(1)).is_some_and(Reading::is_valid);
    let mut longest = (0, None);
    let mut n_missing = 0;
    let first = (0..n).find(|idx| is_valid(*idx))?;
    for idx in first..=first + n {
        if !is_valid(idx) {
            n_missing += 1;
            continue;
        }
        if n_missing > longest.0 {
            longest = (n_missing, Some(idx % n));
        }
        n_missing = 0;
    }
    longest.1
}
