use super::warehouse::groups;
use crate::potential::{Group, NotFinite, Obstacles, Piece};
use nalgebra::Point2;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Nearest distance of each obstacle within reach, by trying all pieces in small steps' stead: the closed form of the
/// distance to a piece by its ends and its foot.
fn brute_force(groups: &[Group], at: Point2<f64>, reach_m: f64) -> Vec<(u32, f64)> {
    let of = |piece: &Piece| {
        let along = piece.to - piece.from;
        let to_ends = (at - piece.from).norm().min((at - piece.to).norm());
        let (foot, length) = ((at - piece.from).dot(&along), along.norm());
        let is_beside = foot > 0.0 && foot < length * length;
        let to_line = along.perp(&(at - piece.from)).abs() / length;
        (if is_beside { to_line } else { to_ends }) - piece.radius_m
    };
    let nearest = |pieces: &Group| pieces.iter().map(of).fold(f64::INFINITY, f64::min);
    let all = (0..).zip(groups.iter().map(nearest));
    all.filter(|(_, distance_m)| *distance_m <= reach_m).collect()
}

#[test]
fn every_obstacle_within_reach_is_found_with_its_distance() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
    for round in 0..60 {
        let span = [3.0, 40.0, 4000.0][round % 3];
        let n_groups = rng.random_range(1..40);
        let mut point = |span: f64| Point2::new(rng.random_range(-span..span), rng.random_range(-span..span));
        let mut groups = Vec::new();
        for k in 0..n_groups {
            let (middle, radius_m) = (point(span), if k % 5 == 0 { 0.4 } else { 0.0 });
            let piece = |offset: Point2<f64>, other: Point2<f64>| Piece {
                from: middle + offset.coords,
                to: middle + other.coords,
                radius_m,
            };
            let length = [0.0, 1.0, span][k % 3];
            groups.push(
                (0..=k % 4)
                    .map(|_| piece(point(1.0), if length == 0.0 { Point2::origin() } else { point(length) }))
                    .collect(),
            );
        }
        let reach_m = [0.5, 2.0, 7.0][round / 3 % 3];
        let obstacles = Obstacles::new(&groups, reach_m).unwrap();
        for _ in 0..200 {
            let at = point(1.2 * span);
            let mut found = Vec::new();
            obstacles.near(at, |nearest| found.push((nearest.group, nearest.distance_m)));
            let expected = brute_force(&groups, at, reach_m);
            assert_eq!(found.len(), expected.len(), "{at}: {found:?} {expected:?}");
            for (found, expected) in found.iter().zip(&expected) {
                assert!(found.0 == expected.0 && (found.1 - expected.1).abs() < 1e-9 * span.max(1.0));
            }
        }
    }
}

/// FC-A10: memory is linear, also where all pieces are long.
#[test]
fn an_index_of_many_pieces_is_linear() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(13);
    for length_m in [0.1, 10.0, 1000.0] {
        let mut point = |middle: Point2<f64>, span: f64| {
            middle + nalgebra::Vector2::new(rng.random_range(-span..span), rng.random_range(-span..span))
        };
        let groups: Vec<Group> = (0..100_000)
            .map(|_| {
                let from = point(Point2::origin(), 1000.0);
                vec![Piece::between(from, point(from, length_m))]
            })
            .collect();
        let obstacles = Obstacles::new(&groups, 2.0).unwrap();
        assert_eq!(obstacles.n_pieces(), 100_000);
        assert!(
            obstacles.n_index_entries() <= 50 * 100_000,
            "{} for {length_m} m",
            obstacles.n_index_entries()
        );
        let at = point(Point2::origin(), 900.0);
        let nearest = brute_force(&groups, at, 2.0).iter().map(|(_, d)| *d).fold(f64::INFINITY, f64::min);
        let found = obstacles.clearance_m(at);
        assert!(found == nearest || (found - nearest).abs() < 1e-9, "{found} {nearest}");
    }
}

#[test]
fn numbers_that_are_not_finite_are_named_and_nothing_is_near_nothing() {
    let mut spoiled = groups();
    spoiled[7][2].to.y = f64::NAN;
    assert_eq!(Obstacles::new(&spoiled, 2.0).err(), Some(NotFinite { group: 7 }));
    spoiled[7][2].to.y = 1e200;
    assert_eq!(Obstacles::new(&spoiled, 2.0).err(), Some(NotFinite { group: 7 }));
    let empty = Obstacles::new(&[], 2.0).unwrap();
    assert_eq!(empty.clearance_m(Point2::origin()), f64::INFINITY);
    assert_eq!(empty.bounds(), None);
    let warehouse = Obstacles::new(&groups(), 2.0).unwrap();
    assert_eq!(warehouse.bounds(), Some((Point2::origin(), Point2::new(40.0, 30.0))));
    for odd in [f64::NAN, f64::INFINITY, -1e300] {
        assert_eq!(warehouse.clearance_m(Point2::new(odd, 3.0)), f64::INFINITY);
    }
}

#[test]
fn a_way_is_clear_where_brute_force_along_it_says_so() {
    let obstacles = Obstacles::new(&groups(), 2.0).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(14);
    let (mut n_clear, mut n_close) = (0, 0);
    for _ in 0..2000 {
        let mut point = || Point2::new(rng.random_range(0.5..39.5), rng.random_range(0.5..29.5));
        let (a, b) = (point(), point());
        let n_steps = ((b - a).norm() / 0.001) as usize + 1;
        let along = |k: usize| a + (b - a) * (k as f64 / n_steps as f64);
        let least = (0..=n_steps).map(|k| obstacles.clearance_m(along(k))).fold(f64::INFINITY, f64::min);
        let is_clear = obstacles.is_clear(a, b, 0.3);
        if (0.3..0.315).contains(&least) {
            n_close += 1;
        } else {
            assert_eq!(is_clear, least > 0.3, "{a} {b} {least}");
            n_clear += usize::from(is_clear);
        }
    }
    assert!(n_clear > 200 && n_close < 60, "{n_clear} {n_close}");
    assert!(!obstacles.is_clear(Point2::new(f64::NAN, 1.0), Point2::new(3.0, 3.0), 0.3));
}
