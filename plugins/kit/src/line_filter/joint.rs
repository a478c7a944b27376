//! Pairs of lines and walls that fit together (Neira and Tardós 2001: joint compatibility, branch and bound).
//!
//! Each line may fit a wall by itself and yet not together with the others: what all innovations have in common, the error
//! of the robot's pose, must explain them all. The largest set of pairs that passes the chi-square test of all of them wins,
//! and among those of one size the nearest. Not in the source, which takes the nearest wall for each line.

use super::association::Match;
use super::sighting::{PredictedLine, Viewpoint};
use super::state::State;
use super::update::Row;
use crate::lines::SensedLine;
use nalgebra::{DMatrix, Matrix5};

/// Pairs that are tried at most: then the best set so far has to do.
const MOST_TRIED: usize = 20_000;

/// A pair that passes its own test.
struct Pair {
    found: Match,
    rows: [Row; 2],
    columns: [usize; 5],
}

/// The search for the best set.
struct Search<'a> {
    state: &'a State,
    /// Pairs of each line, nearest first.
    choices: Vec<Vec<Pair>>,
    /// Largest squared distance of a pair.
    gate: f64,
    /// Cholesky factor of the covariance of the innovations that are in, row by row, and what it leaves of them.
    factor: DMatrix<f64>,
    whitened: Vec<f64>,
    chosen: Vec<(usize, usize)>,
    best: Vec<(usize, usize)>,
    best_distance2: f64,
    n_tried: usize,
}

/// The best set of pairs out of all that pass their own test.
pub(super) fn compatible(
    state: &State,
    view: &Viewpoint,
    seen: &[SensedLine],
    passing: &[Match],
    gate: f64,
) -> Vec<Match> {
    let mut choices: Vec<Vec<Pair>> = (0..seen.len()).map(|_| Vec::new()).collect();
    for found in passing {
        let (Some(line), Some(wall)) = (seen.get(found.seen), state.walls.get(found.wall)) else { continue };
        let column = state.column_of(found.wall);
        let rows = PredictedLine::from(view, *wall).rows(column, line);
        let columns = [0, 1, 2, column, column + 1];
        if let Some(choices) = choices.get_mut(found.seen) {
            choices.push(Pair { found: *found, rows, columns });
        }
    }
    choices.retain(|choices| !choices.is_empty());
    choices.iter_mut().for_each(|c| c.sort_by(|a, b| a.found.distance2.total_cmp(&b.found.distance2)));
    // Lines with few choices first: they bound the others.
    choices.sort_by_key(Vec::len);
    let n_lines = choices.len();
    let mut search = Search {
        state,
        gate,
        factor: DMatrix::zeros(2 * n_lines, 2 * n_lines),
        whitened: vec![0.0; 2 * n_lines],
        choices,
        chosen: Vec::new(),
        best: Vec::new(),
        best_distance2: f64::INFINITY,
        n_tried: 0,
    };
    search.go_on(0, 0.0);
    let pairs = search.best.iter().filter_map(|(line, choice)| search.choices.get(*line)?.get(*choice));
    let mut matches: Vec<Match> = pairs.map(|pair| pair.found).collect();
    matches.sort_by_key(|found| found.seen);
    matches
}

impl Search<'_> {
    /// Tries all choices for a line, and to leave it out.
    fn go_on(&mut self, line: usize, distance2: f64) {
        let n_left = self.choices.len() - line;
        let n_at_most = self.chosen.len() + n_left;
        // More pairs may be farther: a set that is too far for its size may be part of one that is not.
        let is_hopeless = n_at_most < self.best.len()
            || (n_at_most == self.best.len() && distance2 >= self.best_distance2)
            || !is_likely(n_at_most, distance2, self.gate);
        if is_hopeless || self.n_tried > MOST_TRIED {
            return;
        }
        if n_left == 0 {
            (self.best, self.best_distance2) = (self.chosen.clone(), distance2);
            return;
        }
        for choice in 0..self.choices.get(line).map_or(0, Vec::len) {
            self.n_tried += 1;
            let Some(more) = self.add(line, choice) else { continue };
            self.chosen.push((line, choice));
            self.go_on(line + 1, distance2 + more);
            self.chosen.pop();
        }
        self.go_on(line + 1, distance2);
    }

    /// Adds two rows to the factor: what the squared distance of all innovations grows by.
    fn add(&mut self, line: usize, choice: usize) -> Option<f64> {
        let Search { state, choices, factor, whitened, chosen, .. } = self;
        let pair = choices.get(line)?.get(choice)?;
        let mut more = 0.0;
        for (k, row) in pair.rows.iter().enumerate() {
            let at = 2 * chosen.len() + k;
            let before = chosen.iter().filter_map(|(line, choice)| choices.get(*line)?.get(*choice));
            let mut left = row.innovation;
            let mut own = covariance(state, row, pair, row, pair) + row.variance;
            let rows = before.chain((k > 0).then_some(pair)).flat_map(|other| {
                let n = if std::ptr::eq(other, pair) { k } else { 2 };
                other.rows.iter().take(n).map(move |row| (other, row))
            });
            for (col, (other, other_row)) in rows.enumerate() {
                let mut shared = covariance(state, row, pair, other_row, other);
                if std::ptr::eq(other, pair) {
                    shared += other_row.covariance_with_next;
                }
                let inner: f64 = (0..col).map(|c| factor[(at, c)] * factor[(col, c)]).sum();
                let entry = (shared - inner) / factor[(col, col)];
                factor[(at, col)] = entry;
                own -= entry * entry;
                left -= entry * whitened[col];
            }
            if !(own > 0.0 && own.is_finite()) {
                return None;
            }
            factor[(at, at)] = own.sqrt();
            whitened[at] = left / own.sqrt();
            more += whitened[at] * whitened[at];
        }
        Some(more)
    }
}

/// Right sets of so many pairs are farther than this as seldom as right pairs are farther than the gate: chi square of 2 n
/// degrees of freedom is beyond x with probability `e^(-x/2)` times the first n terms of the series of `e^(x/2)`.
fn is_likely(n_pairs: usize, distance2: f64, gate: f64) -> bool {
    let half = distance2 / 2.0;
    let terms = (1..n_pairs).scan(1.0, |term, k| {
        *term *= half / k as f64;
        Some(*term)
    });
    (1.0 + terms.sum::<f64>()) * (-half).exp() >= (-gate / 2.0).exp() * (1.0 - 1e-12)
}

/// h P g^T of two rows.
fn covariance(state: &State, row: &Row, pair: &Pair, other: &Row, other_pair: &Pair) -> f64 {
    let all = state.covariance.view();
    let between = Matrix5::from_fn(|r, c| all[(pair.columns[r], other_pair.columns[c])]);
    let dense = |row: &Row, columns: &[usize; 5]| {
        let mut weights = [0.0; 5];
        for (at, weight) in row.entries() {
            if let Some(k) = columns.iter().position(|column| *column == at) {
                weights[k] += weight;
            }
        }
        nalgebra::Vector5::from(weights)
    };
    dense(row, &pair.columns).dot(&(between * dense(other, &other_pair.columns)))
}
