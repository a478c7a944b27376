//! How what a camera makes of a mark differs from the mark.

use rand::RngExt as _;
use rand_distr::{Distribution, StandardNormal};
use rumbo_core::frames::wrap_angle;
use rumbo_core::messages::Mark;
use rumbo_core::rng::Rng;

/// Errors of a camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarkNoise {
    /// Standard deviation of the range, meters.
    pub range_m: f64,
    /// Part of it that grows with the range, meters per meter.
    pub range_share: f64,
    /// Standard deviation of the bearing, radians.
    pub bearing_rad: f64,
    /// Share of marks that are overlooked.
    pub miss: f64,
    /// Share of marks that are taken for another one.
    pub wrong_identity: f64,
    /// Share of marks that are seen, but not told apart.
    pub unknown_identity: f64,
}

impl MarkNoise {
    /// What the camera says of a mark; nothing where it is overlooked. Every mark takes as many random numbers, so that
    /// a share that changes leaves the errors of all others as they are.
    pub fn read(&self, exact: &Mark, rng: &mut Rng) -> Option<Mark> {
        let [range_error, bearing_error]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(rng));
        let [miss, which, side]: [f64; 3] = std::array::from_fn(|_| rng.random());
        if miss < self.miss {
            return None;
        }
        let identity = if which < self.wrong_identity {
            exact.identity.map(|identity| neighbor(identity, side < 0.5))
        } else {
            exact.identity.filter(|_| which >= self.wrong_identity + self.unknown_identity)
        };
        let deviation_m = self.range_m + self.range_share * exact.range_m;
        Some(Mark {
            identity,
            range_m: (exact.range_m + range_error * deviation_m).max(0.0),
            bearing_rad: wrap_angle(exact.bearing_rad + bearing_error * self.bearing_rad),
        })
    }
}

/// A code that is misread: the number below or above.
fn neighbor(identity: u32, is_below: bool) -> u32 {
    let (below, above) = (identity.checked_sub(1), identity.checked_add(1));
    let (first, second) = if is_below { (below, above) } else { (above, below) };
    first.or(second).unwrap_or(identity)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXACT: Mark = Mark { identity: Some(7), range_m: 5.0, bearing_rad: 0.3 };

    #[test]
    fn readings_have_the_deviations_and_shares_asked_for() {
        let noise = MarkNoise {
            range_m: 0.05,
            range_share: 0.01,
            bearing_rad: 0.02,
            miss: 0.1,
            wrong_identity: 0.05,
            unknown_identity: 0.2,
        };
        let (mut rng, n) = (rumbo_core::rng::stream(1, "camera"), 40_000);
        let read: Vec<Mark> = (0..n).filter_map(|_| noise.read(&EXACT, &mut rng)).collect();
        let n_read = read.len() as f64;
        let share = |n: usize, of: f64| n as f64 / of;
        assert!((share(read.len(), f64::from(n)) - 0.9).abs() < 0.008);
        let count = |is_it: fn(&Mark) -> bool| read.iter().filter(|mark| is_it(mark)).count();
        assert!((share(count(|mark| mark.identity.is_none()), n_read) - 0.2).abs() < 0.011);
        assert!((share(count(|mark| mark.identity == Some(6)), n_read) - 0.025).abs() < 0.005);
        assert!((share(count(|mark| mark.identity == Some(8)), n_read) - 0.025).abs() < 0.005);
        let deviation =
            |of: fn(&Mark) -> f64| (read.iter().map(|mark| of(mark).powi(2)).sum::<f64>() / n_read).sqrt();
        assert!((deviation(|mark| mark.range_m - 5.0) / 0.1 - 1.0).abs() < 0.02);
        assert!((deviation(|mark| mark.bearing_rad - 0.3) / 0.02 - 1.0).abs() < 0.02);
    }

    #[test]
    fn a_range_is_never_below_zero_and_the_ends_of_numbers_have_one_neighbor() {
        let rough = MarkNoise {
            range_m: 10.0,
            range_share: 0.0,
            bearing_rad: 9.0,
            miss: 0.0,
            wrong_identity: 1.0,
            unknown_identity: 0.0,
        };
        let mut rng = rumbo_core::rng::stream(1, "camera");
        for identity in [0, u32::MAX] {
            for _ in 0..200 {
                let mark = rough.read(&Mark { identity: Some(identity), ..EXACT }, &mut rng).unwrap();
                assert_eq!(mark.identity, Some(if identity == 0 { 1 } else { u32::MAX - 1 }));
                assert!(mark.range_m >= 0.0 && mark.bearing_rad.abs() <= std::f64::consts::PI);
            }
        }
    }
}
