//! Where an optimization begins when nobody knows the poses: only the minimum that it begins near is found.

use super::component::held_poses;
use super::constraint::Constraint;
use super::graph::PoseGraph;
use faer::Side;
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};
use nalgebra::{Matrix2, Rotation2, Vector2, Vector3};
use rumbo_core::frames::{Pose2, pose2};
use std::collections::{BTreeMap, VecDeque};

impl PoseGraph {
    /// Moves all poses that nothing holds to where the shortest chain of constraints from a held one puts them. Errors of
    /// long chains add up: [`PoseGraph::start_from_chords`] is better wherever there are loops.
    pub fn start_from_tree(&mut self) {
        let held = held_poses(self);
        let mut neighbors: Vec<Vec<(usize, Pose2)>> = vec![Vec::new(); held.len()];
        let mut open: VecDeque<usize> = VecDeque::new();
        let mut is_placed = held.clone();
        let mut placed: Vec<(usize, Pose2)> = Vec::new();
        for constraint in self.constraints() {
            let (to, from_to) = (constraint.to, constraint.from_to);
            match constraint.from {
                Some(from) => {
                    neighbors[from].push((to, from_to));
                    neighbors[to].push((from, from_to.inverse()));
                }
                None if !is_placed[to] => {
                    is_placed[to] = true;
                    open.push_back(to);
                    placed.push((to, from_to));
                }
                None => {}
            }
        }
        for (node, pose) in placed {
            self.put(node, &pose);
        }
        open.extend((0..held.len()).filter(|node| held[*node]));
        while let Some(node) = open.pop_front() {
            let Some(here) = self.pose(node) else { continue };
            for (other, from_to) in &neighbors[node] {
                if !std::mem::replace(&mut is_placed[*other], true) {
                    self.put(*other, &(here * from_to));
                    open.push_back(*other);
                }
            }
        }
    }

    /// Moves all poses that nothing holds to the answer of two linear problems: first the turns, as if the columns of
    /// their matrices were any vectors, then the places with these turns. Carlone, Tron, Daniilidis, Dellaert,
    /// "Initialization techniques for 3D SLAM: a survey on rotation estimation and its use in pose graph optimization"
    /// (2015), chordal relaxation, in the plane. It weighs all loops at once, needs no guess and no iteration. Whether it
    /// could be solved; where not, the poses are those of [`PoseGraph::start_from_tree`].
    pub fn start_from_chords(&mut self) -> bool {
        self.start_from_tree();
        let held = held_poses(self);
        let turned = solved(self, &held, |pose| Vector2::new(pose.z.cos(), pose.z.sin()), by_turn);
        let Some(turned) = turned else { return false };
        let before = self.poses().to_vec();
        for (node, direction) in turned.iter().enumerate().filter(|(node, _)| !held[*node]) {
            // Turns that disagree completely leave no direction: the one of the tree is as good as any.
            if direction.norm() > 1e-9 {
                let place = before.get(node).map_or_else(Vector2::zeros, |pose| pose.xy());
                self.put(node, &pose2(place.x, place.y, direction.y.atan2(direction.x)));
            }
        }
        let turns: Vec<f64> = self.poses().iter().map(|pose| pose.z).collect();
        let by_place = |constraint: &Constraint| by_place(constraint, &turns);
        let Some(places) = solved(self, &held, Vector3::xy, by_place) else {
            before.iter().enumerate().for_each(|(node, v)| self.put(node, &pose2(v.x, v.y, v.z)));
            return false;
        };
        for (node, place) in places.iter().enumerate().filter(|(node, _)| !held[*node]) {
            self.put(node, &pose2(place.x, place.y, turns[node]));
        }
        true
    }

    /// Poses that are no numbers stay out.
    fn put(&mut self, node: usize, pose: &Pose2) {
        // Nothing to say about a node that is there and a pose that came out of finite ones.
        let _ = self.set_pose(node, pose);
    }
}

/// What a constraint says of the vectors of its two poses: `to - turn * from - shift` is 0, weighed.
struct Linear {
    turn: Matrix2<f64>,
    shift: Vector2<f64>,
    weight: Matrix2<f64>,
}

fn by_turn(constraint: &Constraint) -> Linear {
    let turn = *Rotation2::new(constraint.from_to.rotation.angle()).matrix();
    let weight = Matrix2::identity() * constraint.information[(2, 2)];
    Linear { turn, shift: Vector2::zeros(), weight }
}

fn by_place(constraint: &Constraint, turns: &[f64]) -> Linear {
    let from_rad = constraint.from.map_or(0.0, |from| turns[from]);
    let shift = Rotation2::new(from_rad) * constraint.from_to.translation.vector;
    let axes = *Rotation2::new(from_rad + constraint.from_to.rotation.angle()).matrix();
    let information = constraint.information.fixed_view::<2, 2>(0, 0).into_owned();
    Linear { turn: Matrix2::identity(), shift, weight: axes * information * axes.transpose() }
}

/// The vectors that agree best with what all constraints say; those of held poses are known. None where the equations
/// have no answer.
fn solved(
    graph: &PoseGraph,
    held: &[bool],
    known: impl Fn(&Vector3<f64>) -> Vector2<f64>,
    said: impl Fn(&Constraint) -> Linear,
) -> Option<Vec<Vector2<f64>>> {
    let mut vectors: Vec<Vector2<f64>> = graph.poses().iter().map(&known).collect();
    let mut equations = Equations::of(held);
    for constraint in graph.constraints() {
        let Linear { turn, shift, weight } = said(constraint);
        let (from, to) = (constraint.from, constraint.to);
        let column = |node: usize| equations.columns.get(node).copied().flatten();
        let (from_column, to_column) = (from.and_then(column), column(to));
        // What is known of the pose looked from: the map's own vector is that of a pose at its origin.
        let from_known = from.map_or_else(|| known(&Vector3::zeros()), |from| vectors[from]);
        let back = turn.transpose() * weight;
        if let Some(to) = to_column {
            equations.add(to, to, &weight);
            let moved = if from_column.is_none() { turn * from_known } else { Vector2::zeros() };
            equations.pull(to, &(weight * (shift + moved)));
        }
        if let Some(from) = from_column {
            equations.add(from, from, &(back * turn));
            let seen = if to_column.is_none() { vectors[to] } else { Vector2::zeros() };
            equations.pull(from, &(back * (seen - shift)));
        }
        if let (Some(from), Some(to)) = (from_column, to_column) {
            if from < to {
                equations.add(from, to, &-back)
            } else {
                equations.add(to, from, &-back.transpose())
            }
        }
    }
    let answer = equations.solve()?;
    for (vector, column) in vectors.iter_mut().zip(&equations.columns) {
        let part = column.and_then(|column| answer.get(2 * column..2 * column + 2));
        if let Some(&[x, y]) = part {
            *vector = Vector2::new(x, y);
        }
    }
    Some(vectors)
}

/// Normal equations of vectors, the upper half by columns.
struct Equations {
    columns: Vec<Option<usize>>,
    blocks: BTreeMap<(usize, usize), Matrix2<f64>>,
    right: Vec<f64>,
}

impl Equations {
    fn of(held: &[bool]) -> Equations {
        let mut free = 0..;
        let columns: Vec<Option<usize>> =
            held.iter().map(|held| if *held { None } else { free.next() }).collect();
        Equations { columns, blocks: BTreeMap::new(), right: vec![0.0; 2 * free.start] }
    }

    fn add(&mut self, row: usize, column: usize, block: &Matrix2<f64>) {
        *self.blocks.entry((column, row)).or_insert_with(Matrix2::zeros) += block;
    }

    fn pull(&mut self, column: usize, by: &Vector2<f64>) {
        self.right.iter_mut().skip(2 * column).zip(by.iter()).for_each(|(sum, part)| *sum += part);
    }

    fn solve(&self) -> Option<Vec<f64>> {
        let n = self.right.len();
        if n == 0 {
            return Some(Vec::new());
        }
        let (mut starts, mut rows, mut values) = (vec![0], Vec::new(), Vec::new());
        for column in 0..n / 2 {
            for part in 0..2 {
                for ((_, row), block) in self.blocks.range((column, 0)..=(column, column)) {
                    // Of the diagonal's own block only what is above it.
                    let n_rows = if *row == column { part + 1 } else { 2 };
                    rows.extend((0..n_rows).map(|row_part| 2 * row + row_part));
                    values.extend((0..n_rows).map(|row_part| block[(row_part, part)]));
                }
                starts.push(rows.len());
            }
        }
        let pattern = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        let matrix = SparseColMatRef::new(pattern.as_ref(), &values[..]);
        let symbolic = SymbolicLlt::try_new(pattern.as_ref(), Side::Upper).ok()?;
        let factor = Llt::try_new_with_symbolic(symbolic, matrix, Side::Upper).ok()?;
        let mut answer = self.right.clone();
        factor.solve_in_place(faer::MatMut::from_column_major_slice_mut(&mut answer, n, 1));
        answer.iter().all(|v| v.is_finite()).then_some(answer)
    }
}
