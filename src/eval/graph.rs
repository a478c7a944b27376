//! `rumbo eval graph`: how well the poses of a graph can agree.

use super::figures;
use crate::exit::{Exit, Failure};
use crate::terminal::Terminal;
use rumbo_kit::pose_graph::{
    G2oGraph, GraphOptimizer, OptimizeSettings, OptimizeStatus, PoseGraph, read_g2o,
};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Least cost of a pose graph in a g2o file, from several starts
///
/// The graph is optimized from the poses in the file, from a tree of constraints, and from a chordal initialization, each
/// with plain least squares. The cost is the sum of the squared errors of all constraints, each in units of its variance.
#[derive(clap::Args)]
pub struct Args {
    /// A graph in the plane (VERTEX_SE2, EDGE_SE2), plain or gzip
    graph: PathBuf,
    /// Print the figures as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Serialize)]
struct Figures {
    n_poses: usize,
    n_constraints: usize,
    starts: Vec<Solved>,
}

/// What came of one start.
#[derive(Serialize)]
struct Solved {
    start: &'static str,
    cost_at_start: f64,
    cost: f64,
    n_iterations: usize,
    is_converged: bool,
    wall_s: f64,
}

/// Does it.
pub fn run(args: &Args, terminal: &Terminal) -> Result<Exit, Failure> {
    let file = read_g2o(&args.graph).map_err(|error| Failure::Usage(error.to_string()))?;
    let figures = Figures {
        n_poses: file.graph.n_nodes(),
        n_constraints: file.graph.constraints().len(),
        starts: all_starts(&file),
    };
    if args.json {
        terminal.json(&figures)?;
    } else {
        say(args, &figures, terminal);
    }
    Ok(Exit::Success)
}

fn all_starts(file: &G2oGraph) -> Vec<Solved> {
    let tree = |graph: &mut PoseGraph| {
        graph.start_from_tree();
        true
    };
    let in_file = file.has_poses.then(|| solved("file", &file.graph, |_| true)).flatten();
    let others =
        [solved("tree", &file.graph, tree), solved("chords", &file.graph, PoseGraph::start_from_chords)];
    in_file.into_iter().chain(others.into_iter().flatten()).collect()
}

fn solved(
    start: &'static str,
    graph: &PoseGraph,
    place: impl FnOnce(&mut PoseGraph) -> bool,
) -> Option<Solved> {
    let mut graph = graph.clone();
    let clock = Instant::now();
    if !place(&mut graph) {
        return None;
    }
    let patient = OptimizeSettings { most_iterations: 200, ..OptimizeSettings::default() };
    let done = GraphOptimizer::default().optimize(&mut graph, &patient);
    Some(Solved {
        start,
        cost_at_start: done.costs.first().copied().unwrap_or_default(),
        cost: done.cost(),
        n_iterations: done.costs.len() - 1,
        is_converged: done.status == OptimizeStatus::Converged,
        wall_s: clock.elapsed().as_secs_f64(),
    })
}

fn say(args: &Args, figures: &Figures, terminal: &Terminal) {
    let title =
        format!("{}: {} poses, {} constraints", args.graph.display(), figures.n_poses, figures.n_constraints);
    let row = |solved: &Solved| {
        let Solved { start, cost_at_start, cost, n_iterations, is_converged, wall_s } = solved;
        let end = if *is_converged { "" } else { ", not at a minimum" };
        let ms = 1e3 * wall_s;
        (
            *start,
            format!("cost {cost:.4} from {cost_at_start:.4}, {n_iterations} iterations, {ms:.1} ms{end}"),
        )
    };
    figures::lines(&title, &figures.starts.iter().map(row).collect::<Vec<_>>(), terminal);
}
