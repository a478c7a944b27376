//! Sets of pairs that fit together against all sets there are.

use super::super::association::associate;
use super::super::sighting::Viewpoint;
use super::{seen, sure};
use crate::line_filter::*;
use crate::lines::SensedLine;
use nalgebra::{Matrix2, Matrix5, Vector5};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// Walls as long as the gates can see.
fn walls(n: usize) -> Vec<Wall> {
    vec![Wall { ends_m: [[-1e3, -1e3], [1e3, 1e3]] }; n]
}

/// Squared distance of all pairs of a set together, by the update itself.
fn distance2(state: &State, lines: &[SensedLine], set: &[(usize, usize)]) -> f64 {
    let rows: Vec<Row> = set
        .iter()
        .flat_map(|(line, wall)| {
            let predicted = PredictedLine::new(&state.robot, &Mount::default(), state.walls[*wall]);
            predicted.rows(state.column_of(*wall), &lines[*line])
        })
        .collect();
    if rows.is_empty() { 0.0 } else { Update::new(state, &rows).unwrap().distance2() }
}

/// Chi square of 2 n degrees of freedom is beyond this with the probability `e^-4.5` (n from 0): solved by bisection.
const LIMITS: [f64; 5] = [0.0, 9.0, 13.034385532, 16.545057133, 19.802661244];

/// The largest set within the limits, and its distance: every line with every wall that passes alone, or with none.
fn best_of_all(state: &State, lines: &[SensedLine], gates: &Gates) -> (usize, f64) {
    let mut sets: Vec<Vec<(usize, usize)>> = vec![vec![]];
    for line in 0..lines.len() {
        let with = |set: &Vec<(usize, usize)>, wall: usize| {
            let mut more = set.clone();
            more.push((line, wall));
            more
        };
        let is_single = |wall: usize| {
            let z = PredictedLine::new(&state.robot, &Mount::default(), state.walls[wall])
                .innovation(&lines[line]);
            let is_near = z[0].abs() <= gates.distance_m && z[1].abs() <= gates.normal_rad;
            is_near && distance2(state, lines, &[(line, wall)]) <= gates.distance2
        };
        let fitting: Vec<usize> = (0..state.walls.len()).filter(|wall| is_single(*wall)).collect();
        let grown: Vec<_> =
            sets.iter().flat_map(|set| fitting.iter().map(move |wall| with(set, *wall))).collect();
        sets.extend(grown);
    }
    let passing = sets.iter().filter_map(|set| {
        let d2 = distance2(state, lines, set);
        (d2 <= LIMITS[set.len()]).then_some((set.len(), d2))
    });
    passing.max_by(|a, b| a.0.cmp(&b.0).then(b.1.total_cmp(&a.1))).unwrap()
}

#[test]
fn the_search_finds_the_best_of_all_sets() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(17);
    let gates = Gates { joint: true, ..Gates::default() };
    let mut n_differs = 0;
    for _ in 0..300 {
        let spread = Matrix5::from_diagonal(&Vector5::new(0.04, 0.04, 0.003, 0.1, 0.1));
        let mut state = State::new(Vector5::zeros(), &spread);
        for _ in 0..6 {
            let line = [3.0 + rng.random_range(0.0..0.8), [0.0, 1.6][rng.random_range(0..2usize)]];
            state.add_known(line, &(Matrix2::identity() * 1e-4));
        }
        let lines: Vec<SensedLine> = (0..4)
            .map(|_| {
                let [rho, phi] = state.walls[rng.random_range(0..6usize)];
                seen(rho + rng.random_range(-0.3..0.3), phi + rng.random_range(-0.05..0.05), [-1.0, 1.0])
            })
            .collect();
        let view = Viewpoint::new(&state.robot, &Mount::default());
        let found = associate(&state, &walls(6), &view, &lines, &gates);
        let set: Vec<(usize, usize)> = found.iter().map(|pair| (pair.seen, pair.wall)).collect();
        let (n_best, d2_best) = best_of_all(&state, &lines, &gates);
        assert_eq!(set.len(), n_best);
        assert!((distance2(&state, &lines, &set) - d2_best).abs() < 1e-9 * d2_best.max(1.0));
        let nearest = associate(&state, &walls(6), &view, &lines, &Gates::default());
        n_differs += usize::from(nearest != found);
    }
    assert!(n_differs > 30, "the nearest walls are another answer: {n_differs}");
}

#[test]
fn a_robot_that_is_off_finds_the_right_one_of_two_near_walls() {
    let (robot, _) = sure();
    let mut state = State::new(robot, &Matrix5::from_diagonal(&Vector5::new(0.04, 1e-4, 1e-6, 0.1, 0.1)));
    // Two walls ahead, 30 cm apart, and one behind; the robot is in truth 20 cm farther back than it thinks.
    for line in [[5.0, 0.0], [5.3, 0.0], [3.0, std::f64::consts::PI]] {
        state.add_known(line, &(Matrix2::identity() * 1e-6));
    }
    let lines = [
        seen(5.2, 0.0, [-1.0, 1.0]),
        seen(5.5, 0.0, [-1.0, 1.0]),
        seen(2.8, std::f64::consts::PI, [-1.0, 1.0]),
    ];
    let view = Viewpoint::new(&state.robot, &Mount::default());
    let paired = |joint| -> Vec<usize> {
        let gates = Gates { joint, ..Gates::default() };
        associate(&state, &walls(3), &view, &lines, &gates).iter().map(|found| found.wall).collect()
    };
    assert_eq!(paired(false), [1, 1, 2], "the nearest is the wrong one");
    assert_eq!(paired(true), [0, 1, 2]);
}
