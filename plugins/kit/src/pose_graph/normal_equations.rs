//! The sparse normal equations of a graph: blocks of 3 x 3, the upper half kept by columns.

use super::component::held_poses;
use super::graph::PoseGraph;
use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use nalgebra::{Matrix3, Vector3};

/// Where the block of a constraint lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BlockPlace {
    column: usize,
    rank: usize,
}

/// Structure and numbers of the equations.
#[derive(Debug)]
pub(super) struct NormalEquations {
    /// Column of each pose; none where it is held.
    columns: Vec<Option<usize>>,
    /// Node pairs of the constraints, to see whether the structure is still right.
    pairs: Vec<(Option<usize>, usize)>,
    held: Vec<bool>,
    places: Vec<Option<BlockPlace>>,
    /// Blocks above the diagonal, per column.
    n_above: Vec<usize>,
    pattern: SymbolicSparseColMat<usize>,
    symbolic: SymbolicLlt<usize>,
    values: Vec<f64>,
    damped: Vec<f64>,
    pub(super) gradient: Vec<f64>,
}

/// The matrix could not be factorized.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotDefinite;

impl NormalEquations {
    /// The equations of a graph; none where no pose can move.
    pub(super) fn of(graph: &PoseGraph) -> Option<NormalEquations> {
        let held = held_poses(graph);
        let mut free = 0..;
        let columns: Vec<Option<usize>> =
            held.iter().map(|held| if *held { None } else { free.next() }).collect();
        let n_columns = free.start;
        if n_columns == 0 {
            return None;
        }
        let pairs: Vec<_> = graph.constraints().iter().map(|c| (c.from, c.to)).collect();
        let blocks: Vec<Option<[usize; 2]>> = pairs
            .iter()
            .map(|(from, to)| {
                let (from, to) = (columns[(*from)?]?, columns[*to]?);
                Some([from.min(to), from.max(to)])
            })
            .collect();
        let mut above: Vec<Vec<usize>> = vec![Vec::new(); n_columns];
        blocks.iter().flatten().for_each(|[row, column]| above[*column].push(*row));
        for rows in &mut above {
            rows.sort_unstable();
            rows.dedup();
        }
        let place = |[row, column]: [usize; 2]| {
            let rank = above[column].binary_search(&row).unwrap_or_else(|place| place);
            BlockPlace { column, rank }
        };
        let places = blocks.iter().map(|block| block.map(place)).collect();
        let pattern = pattern(&above);
        let symbolic = SymbolicLlt::try_new(pattern.as_ref(), Side::Upper).ok()?;
        let n_values = pattern.row_idx().len();
        Some(NormalEquations {
            columns,
            pairs,
            held,
            places,
            n_above: above.iter().map(Vec::len).collect(),
            pattern,
            symbolic,
            values: vec![0.0; n_values],
            damped: vec![0.0; n_values],
            gradient: vec![0.0; 3 * n_columns],
        })
    }

    /// The structure is still that of the graph.
    pub(super) fn fits(&self, graph: &PoseGraph) -> bool {
        self.held == held_poses(graph)
            && self.pairs.len() == graph.constraints().len()
            && self.pairs.iter().zip(graph.constraints()).all(|(pair, c)| *pair == (c.from, c.to))
    }

    /// Takes the slopes at the poses as they are.
    pub(super) fn linearize(&mut self, graph: &PoseGraph) {
        self.values.fill(0.0);
        self.gradient.fill(0.0);
        for (idx, constraint) in graph.constraints().iter().enumerate() {
            let line = constraint.linearize(&graph.origin_of(constraint), &graph.end_of(constraint));
            let weight = constraint.kernel.weight(constraint.chi2(&line.error));
            let information = constraint.information * weight;
            let (by_from, by_to) = (line.by_from, line.by_to);
            let pull = information * line.error;
            let from = constraint.from.and_then(|from| self.columns[from]);
            let to = self.columns[constraint.to];
            if let Some(from) = from {
                self.add_diagonal(from, &(by_from.transpose() * information * by_from));
                self.add_gradient(from, &(by_from.transpose() * pull));
            }
            if let Some(to) = to {
                self.add_diagonal(to, &(by_to.transpose() * information * by_to));
                self.add_gradient(to, &(by_to.transpose() * pull));
            }
            if let (Some(from), Some(to), Some(place)) = (from, to, self.places[idx]) {
                let block = by_from.transpose() * information * by_to;
                self.add_block(place, if from < to { block } else { block.transpose() });
            }
        }
    }

    /// The step that lowers the linearized cost most, with the diagonal raised by this share.
    pub(super) fn step(&mut self, damping: f64) -> Result<Vec<f64>, NotDefinite> {
        let factor = self.factor(damping)?;
        let mut step: Vec<f64> = self.gradient.iter().map(|v| -v).collect();
        let n = step.len();
        factor.solve_in_place(faer::MatMut::from_column_major_slice_mut(&mut step, n, 1));
        if step.iter().all(|v| v.is_finite()) { Ok(step) } else { Err(NotDefinite) }
    }

    pub(super) fn factor(&mut self, damping: f64) -> Result<Llt<usize, f64>, NotDefinite> {
        self.damped.copy_from_slice(&self.values);
        for (column, n_above) in self.n_above.iter().enumerate() {
            for part in 0..3 {
                let diagonal = self.pattern.col_ptr()[3 * column + part] + 3 * n_above + part;
                // The least part keeps a direction that nothing measures from being singular.
                self.damped[diagonal] += damping * self.damped[diagonal].max(1e-9);
            }
        }
        let matrix = SparseColMatRef::new(self.pattern.as_ref(), &self.damped[..]);
        Llt::try_new_with_symbolic(self.symbolic.clone(), matrix, Side::Upper).map_err(|_| NotDefinite)
    }

    /// A pose's part of a vector over all columns; none where it is held.
    pub(super) fn column_of(&self, node: usize) -> Option<usize> {
        self.columns.get(node).copied().flatten()
    }

    fn add_gradient(&mut self, column: usize, pull: &Vector3<f64>) {
        for (sum, part) in self.gradient[3 * column..].iter_mut().zip(pull.iter()) {
            *sum += part;
        }
    }

    fn add_diagonal(&mut self, column: usize, block: &Matrix3<f64>) {
        let first = 3 * self.n_above[column];
        for part in 0..3 {
            let start = self.pattern.col_ptr()[3 * column + part] + first;
            for row in 0..=part {
                self.values[start + row] += block[(row, part)];
            }
        }
    }

    fn add_block(&mut self, place: BlockPlace, block: Matrix3<f64>) {
        for part in 0..3 {
            let start = self.pattern.col_ptr()[3 * place.column + part] + 3 * place.rank;
            for row in 0..3 {
                self.values[start + row] += block[(row, part)];
            }
        }
    }
}

/// Rows of the upper half: the blocks above the diagonal, then the diagonal's own.
fn pattern(above: &[Vec<usize>]) -> SymbolicSparseColMat<usize> {
    let (mut starts, mut rows) = (vec![0], Vec::new());
    for (column, blocks) in above.iter().enumerate() {
        for part in 0..3 {
            rows.extend(blocks.iter().flat_map(|block| 3 * block..3 * block + 3));
            rows.extend(3 * column..=3 * column + part);
            starts.push(rows.len());
        }
    }
    let n = 3 * above.len();
    SymbolicSparseColMat::new_checked(n, n, starts, None, rows)
}
