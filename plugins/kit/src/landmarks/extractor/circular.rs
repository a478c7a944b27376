//! Landmarks of a scan all around, whose last reading lies beside the first.
//!
//! Such a scan has to be cut somewhere. Cut in a wall, it would show two shorter ones; so it is cut where nobody knows what
//! is there, else at the largest jump of the range, else at the farthest reading, which is a corner of what is around.

use super::super::discontinuities::{Gap, gap_after};
use super::{Extractor, Landmark, LandmarkKind, Reading, apart};

/// Where a scan is cut.
enum Seam {
    /// Before this reading nobody knows.
    Unknown(usize),
    /// Between this reading and the one before it the range jumps.
    Jump(usize),
    /// This reading is the farthest.
    Corner(usize),
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
        let (start, n_repeated) = match self.seam() {
            Seam::Unknown(start) | Seam::Jump(start) => (start, N_REPEATED),
            // The wall that ends at the corner needs its last reading.
            Seam::Corner(start) => (start, 1),
        };
        self.readings.rotate_left(start);
        self.readings.extend_from_within(..n_repeated.min(n));
        self.collect(reach_m);
        if n_repeated == 1 {
            self.add_corner_at_seam();
        }
        self.readings.truncate(n);
        self.landmarks.retain(|landmark| (landmark.beams[0] as usize) < n);
        for landmark in &mut self.landmarks {
            landmark.beams = landmark.beams.map(|beam| ((beam as usize + start) % n) as u32);
        }
        self.readings.rotate_right(start);
        &self.landmarks
    }

    fn seam(&mut self) -> Seam {
        let n = self.readings.len();
        if let Some(start) = after_longest_gap(&self.readings) {
            return Seam::Unknown(start);
        }
        self.readings.extend_from_within(..N_REPEATED.min(n));
        let mut largest = (0.0, None);
        for (idx, pair) in self.readings.windows(2).enumerate().take(n + 1).skip(1) {
            if gap_after(&self.readings, idx, &self.settings) == Gap::Jump {
                let jump_m = (pair[1].range_m - pair[0].range_m).abs();
                if jump_m > largest.0 {
                    largest = (jump_m, Some((idx + 1) % n));
                }
            }
        }
        self.readings.truncate(n);
        largest.1.map_or_else(|| Seam::Corner(farthest(&self.readings)), Seam::Jump)
    }

    /// An outline that has a corner anywhere has one at its farthest point.
    fn add_corner_at_seam(&mut self) {
        let is_corner = |landmark: &Landmark| matches!(landmark.kind, LandmarkKind::Corner { .. });
        let [corner, after, .., before, _] = self.readings.as_slice() else { return };
        if !self.landmarks.iter().any(is_corner) {
            return;
        }
        let spacing_m = apart(before, corner).max(apart(corner, after));
        self.landmarks.push(Landmark {
            distance_m: corner.range_m,
            bearing_rad: Self::bearing_rad(corner),
            kind: LandmarkKind::Corner { spacing_m },
            beams: [0; 2],
        });
    }
}

/// The farthest reading, of several the first; the first of all without readings.
fn farthest(readings: &[Reading]) -> usize {
    let mut farthest = (f64::NEG_INFINITY, 0);
    for (idx, reading) in readings.iter().enumerate() {
        if reading.range_m > farthest.0 {
            farthest = (reading.range_m, idx);
        }
    }
    farthest.1
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
