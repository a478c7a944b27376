//! Noise on landmarks, for experiments: S. Hernández Alamilla (2005), sections 8.3.1 and 8.5.1.

use super::Landmark;
use rand::{Rng, RngExt};
use rumbo_core::frames::wrap_angle;

/// Noise on a share of the landmarks, uniform in distance and bearing; extents stay as they were.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LandmarkNoise {
    /// Each landmark has noise with this probability; both parts at once.
    pub share: f64,
    /// Largest error of the distance, meters.
    pub distance_m: f64,
    /// Largest error of the bearing, radians.
    pub bearing_rad: f64,
}

impl LandmarkNoise {
    /// Disturbs what `rng` chooses. The same numbers are drawn whatever the landmarks are, three for each.
    pub fn disturb(&self, landmarks: &mut [Landmark], rng: &mut impl Rng) {
        for landmark in landmarks {
            let is_chosen = rng.random::<f64>() < self.share;
            let [by_m, by_rad] =
                [self.distance_m, self.bearing_rad].map(|most| most * (2.0 * rng.random::<f64>() - 1.0));
            if is_chosen {
                landmark.distance_m = (landmark.distance_m + by_m).max(0.0);
                landmark.bearing_rad = wrap_angle(landmark.bearing_rad + by_rad);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{LandmarkKind, Side};
    use super::*;
    use rumbo_core::rng::stream;

    #[test]
    fn a_share_of_the_landmarks_is_disturbed_within_bounds_and_their_extents_are_not() {
        let kind = LandmarkKind::Discontinuity { hidden: Side::Left, jump_m: 1.0, spacing_m: 0.02 };
        let clean = Landmark { distance_m: 2.0, bearing_rad: 3.1, kind, beams: [0, 1] };
        let mut landmarks = vec![clean; 10_000];
        let noise = LandmarkNoise { share: 0.2, distance_m: 0.02, bearing_rad: 5f64.to_radians() };
        noise.disturb(&mut landmarks, &mut stream(1, "noise"));
        let changed: Vec<&Landmark> = landmarks.iter().filter(|landmark| **landmark != clean).collect();
        assert!((1_900..2_100).contains(&changed.len()), "{}", changed.len());
        let turn = |landmark: &Landmark| wrap_angle(landmark.bearing_rad - 3.1);
        assert!(changed.iter().all(|l| (l.distance_m - 2.0).abs() <= 0.02 && turn(l).abs() <= 0.0873));
        assert!(changed.iter().all(|l| l.kind == kind && l.bearing_rad.abs() <= std::f64::consts::PI));
        assert!(changed.iter().any(|l| l.bearing_rad < 0.0) && changed.iter().any(|l| turn(l) < -0.08));
    }
}
