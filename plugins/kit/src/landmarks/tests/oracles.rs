//! Slow exact twins.

use super::corners::straight_pieces;
use super::hough::Hough;
use super::least_squares::{Line, fitted, unit_covariance};
use super::*;

/// A noisy straight piece of wall.
fn noisy_wall(rng: &mut Xoshiro256PlusPlus, deviation: f64) -> (Vec<Reading>, Line) {
    let line = Line { distance_m: rng.random_range(0.4..4.0), bearing_rad: rng.random_range(-PI..PI) };
    let (from, to) = (rng.random_range(-1.2..-0.3_f64), rng.random_range(-0.2..1.2_f64));
    let n = rng.random_range(12..80);
    let reading = |k: i32, rng: &mut Xoshiro256PlusPlus| {
        let off = from + (to - from) * f64::from(k) / f64::from(n);
        Reading::at(line.bearing_rad + off, line.distance_m / off.cos() + deviation * normal(rng))
    };
    ((0..=n).map(|k| reading(k, rng)).collect(), line)
}

#[test]
fn the_window_of_directions_holds_the_maximum_of_the_whole_accumulator() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(51);
    for _ in 0..60 {
        let (readings, _) = noisy_wall(&mut rng, 0.005);
        let mut most = (0, 0.0, [0.0; 2], 0.0);
        for k in 0..1440 {
            let angle = (-180.0 + 0.25 * f64::from(k)).to_radians();
            let mut votes = vec![0; 2000];
            for reading in &readings {
                let distance = reading.place[0] * angle.cos() + reading.place[1] * angle.sin();
                if (0.0..=12.0).contains(&distance) {
                    votes[(distance * 100.0).round() as usize] += 1;
                }
            }
            for (cell, n) in votes.into_iter().enumerate().filter(|(_, n)| *n > 0) {
                if n > most.0 {
                    most = (n, 0.0, [0.0; 2], 0.0);
                }
                if n == most.0 {
                    let [c, s] = most.2;
                    most =
                        (n, most.1 + cell as f64 / 100.0, [c + angle.cos(), s + angle.sin()], most.3 + 1.0);
                }
            }
        }
        let found = Hough::new().strongest(&readings, 12.0).unwrap();
        assert_eq!(found.n_votes, most.0);
        assert!((found.distance_m - most.1 / most.3).abs() < 1e-9);
        assert!((found.bearing_rad - most.2[1].atan2(most.2[0])).abs() < 1e-9);
    }
}

#[test]
fn no_line_has_a_smaller_sum_of_squares_than_the_fitted_one() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(52);
    for _ in 0..100 {
        let (readings, _) = noisy_wall(&mut rng, 0.01);
        let cost = |distance: f64, bearing: f64| -> f64 {
            let (sin, cos) = bearing.sin_cos();
            readings.iter().map(|r| (r.place[0] * cos + r.place[1] * sin - distance).powi(2)).sum()
        };
        let line = fitted(&readings, 1.0);
        let least = cost(line.distance_m, line.bearing_rad);
        for (far, turn) in [(1e-4, 0.0), (-1e-4, 0.0), (0.0, 1e-4), (0.0, -1e-4), (1e-4, 1e-4), (-1e-4, 1e-4)]
        {
            assert!(cost(line.distance_m + far, line.bearing_rad + turn) > least);
        }
    }
}

#[test]
fn the_covariance_of_a_wall_is_that_of_many_noisy_fits() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(53);
    let (deviation, n) = (0.01, 4000);
    for (distance, from, to) in [(1.0, -0.8, 0.9), (2.5, 0.2, 1.1), (0.7, -1.2, -0.4)] {
        let line = Line { distance_m: distance, bearing_rad: 2.9 };
        let exact = |k: i32| from + (to - from) * f64::from(k) / 40.0;
        let mut sums = [0.0; 3];
        let mut claimed = [0.0; 3];
        for _ in 0..n {
            let readings: Vec<Reading> = (0..=40)
                .map(|k| {
                    Reading::at(2.9 + exact(k), distance / exact(k).cos() + deviation * normal(&mut rng))
                })
                .collect();
            let found = fitted(&readings, 1.0);
            let (far, turn) = (
                found.distance_m - line.distance_m,
                rumbo_core::frames::wrap_angle(found.bearing_rad - line.bearing_rad),
            );
            for (sum, product) in sums.iter_mut().zip([far * far, far * turn, turn * turn]) {
                *sum += product / f64::from(n);
            }
            claimed = unit_covariance(&readings, &found).map(|v| v * deviation * deviation);
        }
        let scale = (sums[0] * sums[2]).sqrt();
        for (found, size) in [(0, sums[0]), (1, scale), (2, sums[2])] {
            assert!((sums[found] - claimed[found]).abs() < 0.1 * size, "{found}: {sums:?} {claimed:?}");
        }
    }
}

/// The recursion as it is told.
fn pieces_by_recursion(readings: &[Reading], [from, to]: [usize; 2], limit: f64) -> Vec<[usize; 2]> {
    let ([ax, ay], [bx, by]) = (readings[from].place, readings[to].place);
    let distance = |k: usize| {
        let [x, y] = readings[k].place;
        let length = (bx - ax).hypot(by - ay);
        if length == 0.0 {
            (x - ax).hypot(y - ay)
        } else {
            ((bx - ax) * (y - ay) - (by - ay) * (x - ax)).abs() / length
        }
    };
    let farthest = (from + 1..to).fold(None, |best: Option<usize>, k| match best {
        Some(b) if distance(b) >= distance(k) => Some(b),
        _ => Some(k),
    });
    match farthest.filter(|k| distance(*k) > limit) {
        None => vec![[from, to]],
        Some(k) => {
            let mut all = pieces_by_recursion(readings, [from, k], limit);
            all.extend(pieces_by_recursion(readings, [k, to], limit));
            all
        }
    }
}

#[test]
fn pieces_are_those_of_the_recursion() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(54);
    for n in [1, 2, 3, 20, 200] {
        let mut range = 2.0;
        let readings: Vec<Reading> = (0..n)
            .map(|k| {
                range += rng.random_range(-0.15..0.15_f64);
                range = range.clamp(0.5, 6.0);
                Reading::at(0.01 * f64::from(k), range)
            })
            .collect();
        let ends = [0, readings.len() - 1];
        let mut found = Vec::new();
        straight_pieces(&readings, ends, 0.15, &mut Vec::new(), |piece, [from, to]| {
            assert_eq!(piece, &readings[from..=to]);
            found.push([from, to]);
        });
        assert_eq!(found, pieces_by_recursion(&readings, ends, 0.15));
    }
    // Both ends in one place: the distance from it counts.
    let there_and_back: Vec<Reading> = [1.0, 1.1, 1.2, 1.1, 1.0].map(|r| Reading::at(0.0, r)).to_vec();
    assert_eq!(pieces_by_recursion(&there_and_back, [0, 4], 0.15).len(), 2);
    let mut n = 0;
    straight_pieces(&there_and_back, [0, 4], 0.15, &mut Vec::new(), |_, _| n += 1);
    assert_eq!(n, 2);
}
