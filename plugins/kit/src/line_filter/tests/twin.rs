//! The update with few columns against the textbook's full matrices, and its limits.

use super::alike;
use crate::line_filter::*;
use nalgebra::{DMatrix, DVector, Matrix2, Matrix5, SMatrix, Vector5};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

/// A state with a random covariance.
fn random_state(n_walls: usize, rng: &mut Xoshiro256PlusPlus) -> State {
    let size = ROBOT + 2 * n_walls;
    let mut draw = |_, _| rng.random_range(-1.0..1.0);
    let root = DMatrix::from_fn(size, size, &mut draw);
    let covariance = &root * root.transpose() * 1e-3 + DMatrix::identity(size, size) * 1e-4;
    let mut state = State::new(Vector5::from_fn(|_, _| draw(0, 0)), &Matrix5::zeros());
    state.walls = (0..n_walls).map(|_| [5.0 * draw(0, 0), 3.0 * draw(0, 0)]).collect();
    state.covariance.grow(2 * n_walls);
    state.covariance.view_mut().copy_from(&covariance);
    state
}

/// Two rows for each of some walls, with correlated noise.
fn random_rows(n_walls: usize, n_seen: usize, rng: &mut Xoshiro256PlusPlus) -> Vec<Row> {
    let mut rows = Vec::new();
    for _ in 0..n_seen {
        let column = ROBOT + 2 * rng.random_range(0..n_walls);
        let mut weights = |columns: [usize; 5]| columns.map(|at| (at, rng.random_range(-2.0..2.0)));
        let [one, other] = [weights([0, 1, 2, column, column + 1]), weights([0, 1, 2, column, column + 1])];
        let one = Row::new(&one, rng.random_range(-0.1..0.1), 2e-3);
        rows.push(one.correlated(5e-4));
        rows.push(Row::new(&other, rng.random_range(-0.1..0.1), 1e-3));
    }
    rows
}

/// H, R and z in full.
fn full(rows: &[Row], size: usize) -> (DMatrix<f64>, DMatrix<f64>, DVector<f64>) {
    let (mut h, mut r) = (DMatrix::zeros(rows.len(), size), DMatrix::zeros(rows.len(), rows.len()));
    for (k, row) in rows.iter().enumerate() {
        row.entries().for_each(|(at, weight)| h[(k, at)] += weight);
        r[(k, k)] = row.variance;
        if row.covariance_with_next != 0.0 {
            (r[(k, k + 1)], r[(k + 1, k)]) = (row.covariance_with_next, row.covariance_with_next);
        }
    }
    (h, r, DVector::from_iterator(rows.len(), rows.iter().map(|row| row.innovation)))
}

fn stacked(state: &State) -> DVector<f64> {
    DVector::from_iterator(
        state.covariance.size(),
        state.robot.iter().chain(state.walls.iter().flatten()).copied(),
    )
}

#[test]
fn an_update_is_that_of_full_matrices_in_both_forms() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(21);
    for (n_walls, n_seen) in [(1, 1), (3, 2), (20, 7), (40, 20), (95, 20)] {
        for is_known in [false, true] {
            let mut state = random_state(n_walls, &mut rng);
            let rows = random_rows(n_walls, n_seen, &mut rng);
            let (before, p) = (stacked(&state), state.covariance.view().into_owned());
            let (h, r, z) = full(&rows, p.nrows());
            let s = &h * &p * h.transpose() + &r;
            let mut k = &p * h.transpose() * s.clone().try_inverse().unwrap();
            if is_known {
                k.rows_mut(ROBOT, 2 * n_walls).fill(0.0);
            }
            let keep = DMatrix::identity(p.nrows(), p.nrows()) - &k * &h;
            let joseph = &keep * &p * keep.transpose() + &k * r * k.transpose();
            let update = Update::new(&state, &rows).unwrap();
            let distance2 = z.dot(&(s.try_inverse().unwrap() * &z));
            assert!((update.distance2() - distance2).abs() < 1e-9 * distance2);
            update.fuse(&mut state, &rows, is_known);
            let found = state.covariance.view().into_owned();
            alike(&found, &joseph, 1e-12, "Joseph's form");
            alike(&found, &found.transpose(), 0.0, "symmetric to the bit");
            if !is_known {
                alike(&found, &(&keep * &p), 1e-12, "the short form");
            }
            let moved = before + &k * &z;
            let off: Vec<f64> = stacked(&state).iter().zip(moved.iter()).map(|(a, b)| a - b).collect();
            let turns = off.iter().map(|off| off / std::f64::consts::TAU);
            assert!(
                off.iter()
                    .zip(turns)
                    .all(|(off, turns)| off.abs() < 1e-12 || (turns - turns.round()).abs() < 1e-12)
            );
        }
    }
}

#[test]
fn a_known_map_keeps_its_covariance_and_the_robot_stays_as_unsure_as_the_map() {
    let mut state = State::new(Vector5::zeros(), &(Matrix5::identity() * 0.04));
    // One wall ahead that is known to 10 cm, seen a thousand times to 1 cm.
    state.add_known([5.0, 0.0], &Matrix2::new(0.01, 0.0, 0.0, 1e-9));
    for _ in 0..1000 {
        let rows = [Row::new(&[(0, -1.0), (5, 1.0)], 0.0, 1e-4)];
        Update::new(&state, &rows).unwrap().fuse(&mut state, &rows, true);
    }
    let p = state.covariance.view();
    assert_eq!(p[(5, 5)], 0.01, "the map is not corrected");
    // 1 / (1 / 0.04 + 1 / 0.01): no number of looks makes the place surer than the map and the start together.
    assert!((p[(0, 0)] - 0.008).abs() < 1e-4, "{}", p[(0, 0)]);
}

#[test]
fn what_is_no_covariance_or_no_number_is_refused_and_changes_nothing() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let state = random_state(3, &mut rng);
    for (innovation, variance) in [(f64::NAN, 1e-3), (f64::INFINITY, 1e-3), (0.0, -1e3), (0.0, f64::NAN)] {
        let rows = [Row::new(&[(0, 1.0)], innovation, variance)];
        assert_eq!(Update::new(&state, &rows).unwrap_err(), NotPositiveDefinite, "{innovation} {variance}");
    }
}

#[test]
fn walls_come_and_go_at_any_place() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(9);
    let mut state = random_state(5, &mut rng);
    let before = state.clone();
    state.swap_remove(1);
    // The last wall took its place; everything else is as it was.
    let order = [0usize, 4, 2, 3];
    assert_eq!(state.walls, order.map(|wall| before.walls[wall]));
    for (one, from) in order.into_iter().enumerate() {
        assert_eq!(state.robot_with(one), before.robot_with(from));
        for (other, to) in order.into_iter().enumerate() {
            assert_eq!(state.between(one, other), before.between(from, to));
        }
    }
    state.swap_remove(3);
    assert_eq!(state.walls.len(), 3);
    state.add_known([1.0, 2.0], &Matrix2::identity());
    assert_eq!(state.between(3, 3), Matrix2::identity());
    assert_eq!(state.between(3, 0), Matrix2::zeros(), "nothing is left of the wall that was here");
    assert_eq!(state.robot_with(3), SMatrix::<f64, ROBOT, 2>::zeros());
}
