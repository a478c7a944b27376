//! Graphs like M3500 of Olson: poses on a grid of streets, 3 constraints for every 2 poses. Bar: 150 ms for a whole optimization
//! of 1,000 poses, goal 40 ms.
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;
use rumbo_core::frames::{Pose2, pose2};
use rumbo_kit::pose_graph::{Constraint, GraphOptimizer, OptimizeSettings, PoseGraph, RobustKernel};

fn main() {
    divan::main();
}

const SIZES: [usize; 2] = [1000, 3500];
/// As many as M3500 has.
const LOOPS_A_POSE: f64 = 1954.0 / 3500.0;
const DEVIATION: f64 = 0.05;

fn noisy(motion: Pose2, rng: &mut Xoshiro256PlusPlus) -> Pose2 {
    let [x, y, turn]: [f64; 3] = std::array::from_fn(|_| DEVIATION * rng.sample::<f64, _>(StandardNormal));
    motion * pose2(x, y, turn)
}

/// Poses where the chords put them.
fn city(n_poses: usize) -> PoseGraph {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3500);
    let (mut graph, mut truth) = (PoseGraph::default(), vec![Pose2::identity()]);
    let bind = |graph: &mut PoseGraph, from: usize, to: usize, from_to: Pose2| {
        let information = nalgebra::Matrix3::identity() * DEVIATION.powi(-2);
        let kernel = RobustKernel::Quadratic;
        if graph.add(Constraint { from: Some(from), to, from_to, information, kernel }).is_err() {
            std::process::abort()
        }
    };
    for k in 0..n_poses {
        if graph.add_pose(&Pose2::identity()).is_err() {
            std::process::abort()
        }
        if k == 0 {
            continue;
        }
        let is_far = truth[k - 1].translation.vector.amax() > 20.0;
        let quarters = if k % 4 != 0 {
            0.0
        } else if is_far {
            1.0
        } else {
            f64::from(rng.random_range(-1..=1))
        };
        truth.push(truth[k - 1] * pose2(1.0, 0.0, quarters * std::f64::consts::FRAC_PI_2));
        bind(&mut graph, k - 1, k, noisy(truth[k - 1].inverse() * truth[k], &mut rng));
    }
    let is_beside = |[a, b]: &[usize; 2]| {
        (truth[*a].translation.vector - truth[*b].translation.vector).norm() < 1.1 && b - a > 10
    };
    let pairs: Vec<[usize; 2]> =
        (0..n_poses).flat_map(|a| (a + 1..n_poses).map(move |b| [a, b])).filter(is_beside).collect();
    for [a, b] in
        pairs.iter().step_by(((pairs.len() as f64 / (LOOPS_A_POSE * n_poses as f64)) as usize).max(1))
    {
        bind(&mut graph, *a, *b, noisy(truth[*a].inverse() * truth[*b], &mut rng));
    }
    graph
}

#[divan::bench(sample_count = 20, args = SIZES)]
fn from_chords_to_the_minimum(bencher: divan::Bencher<'_, '_>, n_poses: usize) {
    let mut graph = city(n_poses);
    graph.start_from_chords();
    bencher.with_inputs(|| graph.clone()).bench_local_values(|mut graph| {
        GraphOptimizer::default().optimize(&mut graph, &OptimizeSettings::default())
    });
}

#[divan::bench(sample_count = 20, args = SIZES)]
fn one_more_step_with_the_structure_known(bencher: divan::Bencher<'_, '_>, n_poses: usize) {
    let mut graph = city(n_poses);
    graph.start_from_chords();
    let mut optimizer = GraphOptimizer::default();
    let one = OptimizeSettings { most_iterations: 1, ..OptimizeSettings::default() };
    optimizer.optimize(&mut graph, &one);
    bencher
        .with_inputs(|| graph.clone())
        .bench_local_values(|mut graph| optimizer.optimize(&mut graph, &one));
}

#[divan::bench(sample_count = 20, args = SIZES)]
fn chords(bencher: divan::Bencher<'_, '_>, n_poses: usize) {
    let graph = city(n_poses);
    bencher.with_inputs(|| graph.clone()).bench_local_values(|mut graph| graph.start_from_chords());
}
