//! As many readings as wanted, evenly along what is seen, so that near walls do not outweigh the others.

use rumbo_core::messages::LaserScan;

/// Between two readings farther apart than this there is a gap and no wall, meters.
const GAP_M: f64 = 0.3;

/// Calls `drop` with each reading that is one too many. Along walls of the length L in all, the first reading beyond each
/// L / `max_points` is kept.
pub fn thin(scan: &LaserScan, max_points: usize, mut drop: impl FnMut(usize)) {
    let n_hits = readings(scan).count();
    if n_hits <= max_points || max_points == 0 {
        return;
    }
    let steps_m = || readings(scan).scan(None, |last, (idx, at)| Some((idx, step_m(last, at))));
    let length_m: f64 = steps_m().map(|(_, step_m)| step_m).sum();
    let spacing_m = length_m / max_points as f64;
    let (mut way_m, mut n_kept) = (0.0, 0usize);
    for (idx, step_m) in steps_m() {
        way_m += step_m;
        // All in one point: one reading of it says everything.
        if n_kept < max_points && way_m >= spacing_m * n_kept as f64 && (n_kept == 0 || step_m > 0.0) {
            n_kept = ((way_m / spacing_m) as usize + 1).clamp(n_kept + 1, max_points);
        } else {
            drop(idx);
        }
    }
}

fn readings(scan: &LaserScan) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
    scan.ranges_m.iter().enumerate().filter(|(_, range_m)| range_m.is_finite()).map(|(idx, range_m)| {
        let (sine, cosine) = scan.bearing_rad(idx).sin_cos();
        (idx, [f64::from(*range_m) * cosine, f64::from(*range_m) * sine])
    })
}

fn step_m(last: &mut Option<[f64; 2]>, at: [f64; 2]) -> f64 {
    let before = last.replace(at);
    before.map_or(0.0, |[x, y]| (at[0] - x).hypot(at[1] - y).min(GAP_M))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A wall 1 m to the left and one 10 m to the right, parallel to the way.
    fn corridor() -> LaserScan {
        let step = 1f64.to_radians();
        let ranges = (-70..=70).map(|k| (1.0 / (step * f64::from(k)).cos()) as f32);
        let far = (110..=250).map(|k| (10.0 / (step * f64::from(k)).cos().abs()) as f32);
        let gap = std::iter::repeat_n(f32::NAN, 39);
        LaserScan {
            first_bearing_rad: -70.0 * step,
            bearing_step_rad: step,
            max_range_m: 80.0,
            ranges_m: ranges.chain(gap).chain(far).collect::<Vec<f32>>().into(),
            ..LaserScan::default()
        }
    }

    fn kept(scan: &LaserScan, max_points: usize) -> Vec<usize> {
        let mut dropped = Vec::new();
        thin(scan, max_points, |idx| dropped.push(idx));
        (0..scan.ranges_m.len()).filter(|i| scan.ranges_m[*i].is_finite() && !dropped.contains(i)).collect()
    }

    #[test]
    fn never_more_than_asked_for_and_all_where_there_are_no_more() {
        let scan = corridor();
        let n_all = scan.ranges_m.iter().filter(|range_m| range_m.is_finite()).count();
        for max_points in [1, 2, 7, 50, 100, 281] {
            let n = kept(&scan, max_points).len();
            assert!(n <= max_points && n * 2 > max_points.min(140), "{n} of {max_points}");
        }
        assert_eq!((kept(&scan, n_all).len(), kept(&scan, 0).len()), (n_all, n_all));
    }

    #[test]
    fn near_walls_get_the_share_of_their_length_and_not_of_their_beams() {
        let scan = corridor();
        let near = kept(&scan, 40).into_iter().filter(|idx| *idx <= 140).count();
        // Near: 5.5 m of wall; far: 141 beams with 0.17 m to 0.3 m between them, some 32 m.
        assert!((4..=8).contains(&near), "{near} of 40 points on the near wall, which has half of all beams");
        // Along the near wall they are even: at most two spacings apart.
        let scan = LaserScan { ranges_m: scan.ranges_m[..141].to_vec().into(), ..scan };
        let at = |idx: usize| (scan.bearing_rad(idx)).tan();
        let along: Vec<f64> = kept(&scan, 20).into_iter().map(at).collect();
        let spacing = 2.0 * 70f64.to_radians().tan() / 20.0;
        assert!(along.windows(2).all(|w| w[1] - w[0] < 2.0 * spacing && w[1] - w[0] > 0.4 * spacing));
    }

    #[test]
    fn readings_in_one_point_are_one() {
        let scan = LaserScan {
            bearing_step_rad: 0.0,
            max_range_m: 8.0,
            ranges_m: vec![2.0f32; 9].into(),
            ..LaserScan::default()
        };
        assert_eq!(kept(&scan, 3), [0]);
    }
}
